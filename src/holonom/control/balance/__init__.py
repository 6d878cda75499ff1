"""Laws that balance an inverted pendulum on its wheels: one file each, in the table `BALANCE_LAWS`.

Each makes gains of one step (`kernels.balance_step`) from the linear model of the body (`Pendulum`).

====================  ========================================================================
`lqr`                 linear quadratic regulator of pitch, its rate, speed and place
`cascade`             a PI of the speed asks for a pitch, a PD of the pitch for a force
====================  ========================================================================
"""

__all__: list[str] = []
