"""Equations of motion over scalars.

====================  ======================================================
`inertia`             mass, first and second moment of a link
`newton_euler`        inverse dynamics
`composite_body`      mass matrix
`forward_dynamics`    B qdd = tau - h
`articulated_body`    the same in linear time
`carried`             what each joint carries, in one frame
`coriolis`            Christoffel symbols, Coriolis matrix
`derivatives`         of inverse and forward dynamics
`energy`              energies and momenta
`regressor`           torques linear in the inertial parameters
`rotors`              spinning rotors
`closed_loop`         an arm under a law
====================  ======================================================
"""

__all__: list[str] = []
