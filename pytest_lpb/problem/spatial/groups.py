"""Links that move as one: joined by fixed or locked joints."""

from __future__ import annotations

from collections.abc import Iterable

from pytest_lpb.problem.spatial.urdf import UrdfModel


class RigidGroups:
    """Which links belong together, and which groups a moving joint joins.

    Args:
        model: the robot.
        moving: names of the entries of q; joints that mimic one of them move too.
    """

    def __init__(self, model: UrdfModel, moving: Iterable[str]) -> None:
        planned = set(moving)
        self._group = {model.root: 0}
        self._joined: set[frozenset[int]] = set()
        for joint in model.joints:
            source = joint.name if joint.mimic is None else joint.mimic[0]
            above = self._group[joint.parent]
            if joint.kind == "fixed" or source not in planned:
                self._group[joint.child] = above
            else:
                self._group[joint.child] = len(self._group)
                self._joined.add(frozenset({above, self._group[joint.child]}))

    def adjacent(self, first: str, second: str) -> bool:
        """Whether two links move as one, or have one moving joint between them."""
        pair = frozenset({self._group[first], self._group[second]})
        return len(pair) == 1 or pair in self._joined
