"""The textbook's equations over plain scalars: they run on floats as their own reference and are traced into kernels.

====================  ======================================================
`vectors`             vectors and matrices of scalars
`kinematics`          frames, Jacobian
`dynamics`            equations of motion
`inverse`             closed-form inverse geometry
`pose_task`           residual of a pose, for the numerical inverse
`criteria`            what a redundant arm does with its freedom
`singularities`       where an arm loses a direction
====================  ======================================================
"""

__all__: list[str] = []
