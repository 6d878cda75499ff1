"""The equations of motion as readable formulas."""

from holonom.mechanics.symbolic.formulas import QUANTITIES, Formulas, formulas

__all__ = ["QUANTITIES", "Formulas", "formulas"]
