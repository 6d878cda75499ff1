"""Laws that keep a base on its path: one file each, all steps alike (`PathLaw`), in the table `PATH_LAWS`.

Errors of the reference seen from the robot's axes are (e_x, e_y, e_theta); the command is a forward speed and a
turning rate, so that any base that rolls forwards and turns can follow it. References that drive backwards have a
negative speed, and cusps are places where it passes zero.

====================  ========================================================================
`kanayama`            feedback on the reference in time, critically damped
`ltv`                 the same errors, LQR gains over the speed
`ramsete`             the same errors, gains of De Luca, Oriolo and Vendittelli
`stanley`             the leading axle onto the path: heading and cross-track error
`pure_pursuit`        arcs to a point ahead; slower in curves and before what is ahead
====================  ========================================================================
"""

__all__: list[str] = []
