"""Derivatives of the dynamics, Christoffel symbols, energies and momenta, rotor model and payload.

Inverse and forward dynamics, mass and Coriolis matrix and gravity are methods of `Arm`; `floating` has those of an arm
whose base moves.
"""

from holonom.mechanics.dynamics import floating
from holonom.mechanics.dynamics.quantities import (
    CouplingTable,
    Energy,
    ForwardDynamicsDerivatives,
    InverseDynamicsDerivatives,
    bias,
    centre_of_mass,
    centroidal_momentum,
    christoffel,
    coupling_table,
    energy,
    forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
    momentum,
    with_payload,
    with_rotors,
)

__all__ = [
    "CouplingTable",
    "Energy",
    "ForwardDynamicsDerivatives",
    "InverseDynamicsDerivatives",
    "bias",
    "centre_of_mass",
    "centroidal_momentum",
    "christoffel",
    "coupling_table",
    "energy",
    "floating",
    "forward_dynamics_derivatives",
    "inverse_dynamics_derivatives",
    "momentum",
    "with_payload",
    "with_rotors",
]
