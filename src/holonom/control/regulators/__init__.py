"""Regulators as a controller computes them, sample by sample (specification 04.1).

======================  ========================================================================
`REGULATORS`            the forms by name; each says whether it recoils
`respond`               what a form answers to a sequence of references and measurements
`Regulator`             a form's compiled `step` and `start`, and its settings
`four_sample_rate`      a derivative over four samples, with half the noise of two
======================  ========================================================================
"""

from holonom.control.regulators.contract import Regulator, RegulatorSettings
from holonom.control.regulators.kernels import four_sample_rate
from holonom.control.regulators.methods import REGULATORS
from holonom.control.regulators.sequence import respond

__all__ = ["REGULATORS", "Regulator", "RegulatorSettings", "four_sample_rate", "respond"]
