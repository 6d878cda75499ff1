"""The textbook's equations over plain scalars: they run on floats as their own reference and are traced into kernels.

====================  ======================================================
`kinematics`          frames, Jacobian
`inertia`             mass, first and second moment of a link
`newton_euler`        inverse dynamics
`composite_body`      mass matrix
`forward_dynamics`    B qdd = tau - h
`puma_inverse`        closed-form inverse geometry of Puma-type arms
====================  ======================================================
"""

__all__: list[str] = []
