"""Names in a URDF that a scenario cannot work with: they could not be written, or are taken by the robot's base."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_lpb.names import MAX_NAME_LENGTH, is_name
from pytest_lpb.problem.spatial.composition import HELPER
from pytest_lpb.problem.spatial.generated import BASE_BODY
from pytest_lpb.problem.spatial.urdf import UrdfModel


def wrong_name(model: UrdfModel, base_joints: Sequence[str], *, carried: bool) -> str | None:
    """What is wrong with the names of a URDF, in words; None when nothing is.

    Args:
        model: as it was read.
        base_joints: names of the entries of q that are the base's.
        carried: whether the box of `base_size` carries the robot.
    """
    joints = [joint.name for joint in model.joints]
    taken = sorted(set(base_joints) & set(joints))
    if taken:
        return f"{model.name} has joints called {', '.join(taken)}, as its base has; rename them in the URDF"
    for kind, names in (("link", [link.name for link in model.links]), ("joint", joints)):
        helper = next((name for name in names if name.startswith(HELPER)), None)
        if helper is not None:
            return f"{model.name} has a {kind} called {helper!r}; names in {HELPER} are kept for bases: rename it"
    if carried and any(link.name == BASE_BODY for link in model.links):
        return f"{model.name} has a link called {BASE_BODY!r}, as the box of base_size is; rename it in the URDF"
    odd = next((name for name in model.movable if not is_name(name)), None)
    if odd is not None:
        return (
            f"{model.name} has a joint called {odd!r}; rename it in the URDF: a name is made of letters, digits, "
            f"'_', '.' and '-', does not begin with '.', and has at most {MAX_NAME_LENGTH} characters"
        )
    return None
