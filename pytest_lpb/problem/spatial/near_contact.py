"""Distances near contact and inside of each other, where Bullet's are not exact.

Bullet's GJK algorithm gives way to EPA where the cores of shapes come nearer than about a millimetre, and errors of up
to 1.4 mm were seen there. Whether bodies touch is decided at a thousandth of that, so such pairs are measured anew.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_lpb.problem.spatial.convex.cores import Core
from pytest_lpb.problem.spatial.convex.signed_distance import signed_distance
from pytest_lpb.problem.spatial.rotations import inverse, matrix_of, multiply, rotate

NEAR_M = 4e-3  # [m] about three times the largest error of Bullet's distances near contact

Pose = tuple[Sequence[float], Sequence[float]]  # position [m], quaternion xyzw, as PyBullet has them


def measured_exactly(first: Sequence[Core], second: Sequence[Core]) -> bool:
    """Whether Bullet's distance of two bodies is as exact as can be, or all there is: for spheres and capsules among
    themselves, and surfaces, which have no cores."""
    return not first or not second or (all(core.round for core in first) and all(core.round for core in second))


def exact_distance(first: Sequence[Core], second: Sequence[Core], poses: tuple[Pose, Pose]) -> float:
    """Signed distance [m] of two bodies at their poses.

    It is exact to 1e-8 m where they are apart, and for boxes and convex hulls everywhere; for cylinders inside of other
    shapes see `convex.epa`.
    """
    (position, (x, y, z, w)), (place, (ox, oy, oz, ow)) = poses
    back = inverse((w, x, y, z))  # in the frame of the first, so that distances do not depend on where bodies are
    turn = matrix_of(multiply(back, (ow, ox, oy, oz)))
    shift = rotate(back, [there - here for here, there in zip(position, place, strict=True)])
    return signed_distance(first, [core.placed(turn, np.array(shift)) for core in second])
