"""Poses: checks and the few constructions that SciPy's `Rotation` does not have.

Rotation arithmetic is SciPy's (`scipy.spatial.transform.Rotation`); a pose is a 4x4 array `T_ab`.

===================  ==============================================
`check_pose`         is it a rigid transform?
`inverse`            T_ba from T_ab
`pose`               from a position and a rotation matrix
`zyz_angles`, ...    Euler angles, both branches
`PoseGraph`          known poses between named frames
===================  ==============================================
"""

from holonom.spatial.euler import EulerAngles, rpy_angles, zyz_angles
from holonom.spatial.graph import PoseGraph
from holonom.spatial.poses import check_pose, inverse, pose

__all__ = ["EulerAngles", "PoseGraph", "check_pose", "inverse", "pose", "rpy_angles", "zyz_angles"]
