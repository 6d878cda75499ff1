"""Closed-form inverse geometry over scalars.

====================  ======================================================
`subproblems`         the angles that closed-form inverses are made of
`regional`            where three joints bring a point
`general_arm`         the same where no axes are parallel or meet: a quartic
`spherical_wrist`     inverse of arms whose last three axes meet
`parallel_axes`       inverse of arms with three parallel axes
`puma_geometry`       the lengths of Puma-type arms
====================  ======================================================
"""

__all__: list[str] = []
