"""An arm alone, integrated: free, under a law, many variations at once."""

from holonom.mechanics.simulate.simulate import (
    METHODS,
    ComputedTorque,
    Ensemble,
    PDGravity,
    Simulation,
    Tableau,
    simulate,
    simulate_ensemble,
)

__all__ = [
    "METHODS",
    "ComputedTorque",
    "Ensemble",
    "PDGravity",
    "Simulation",
    "Tableau",
    "simulate",
    "simulate_ensemble",
]
