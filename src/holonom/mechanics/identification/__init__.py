"""Which masses, moments and frictions an arm has, found from its motion.

======================  ==================================================================
`regressor`             tau = Y(q, qd, qdd) pi; `column_names`, `parameters` (pi of a model)
`base_parameters`       the smallest set of numbers that the torque depends on
`excitation`            a motion that tells much about them
`identify`              estimates with confidence, and a model that can exist
======================  ==================================================================
"""

from holonom.mechanics.identification.base import BaseParameters, base_parameters
from holonom.mechanics.identification.columns import column_names, parameters, regressor
from holonom.mechanics.identification.consistent import is_consistent, pseudo_inertia
from holonom.mechanics.identification.estimate import Identification, identify
from holonom.mechanics.identification.excitation import Excitation, condition_number, excitation

__all__ = [
    "BaseParameters",
    "Excitation",
    "Identification",
    "base_parameters",
    "column_names",
    "condition_number",
    "excitation",
    "identify",
    "is_consistent",
    "parameters",
    "pseudo_inertia",
    "regressor",
]
