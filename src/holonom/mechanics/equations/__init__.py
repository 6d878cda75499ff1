"""The textbook's equations over plain scalars: they run on floats as their own reference and are traced into kernels.

====================  ======================================================
`kinematics`          frames, Jacobian
`inertia`             mass, first and second moment of a link
`newton_euler`        inverse dynamics
`composite_body`      mass matrix
`forward_dynamics`    B qdd = tau - h
`subproblems`         the angles that closed-form inverses are made of
`regional`            where three joints bring a point
`general_arm`         the same where no axes are parallel or meet: a quartic
`spherical_wrist`     inverse of arms whose last three axes meet
`parallel_axes`       inverse of arms with three parallel axes
`puma_geometry`       the lengths of Puma-type arms
====================  ======================================================
"""

__all__: list[str] = []
