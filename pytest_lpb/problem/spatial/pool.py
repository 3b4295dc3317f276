"""Worlds that wait to be used again: loading a robot takes 10 to 30 ms, placing one 0.01 ms.

A world is lent to one user at a time and has no memory: whoever borrows it sets joints and obstacles anew.
"""

from __future__ import annotations

from collections import deque
from threading import Lock

from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.world import World

MAX_IDLE = 2  # worlds kept; each takes about 30 MB

_idle: deque[tuple[object, World]] = deque()
_lock = Lock()


def borrow_world(robot: SpatialRobot) -> World:
    """A world with this robot; what it does not need to be told is in it. Give it back, or close it."""
    key = _key(robot)
    with _lock:
        for entry in _idle:
            if entry[0] == key:
                _idle.remove(entry)
                return entry[1]
    return World(robot)


def give_back(robot: SpatialRobot, world: World) -> None:
    """Keep a world for the next one who needs this robot; the one idle for longest makes room."""
    with _lock:
        _idle.append((_key(robot), world))
        surplus = _idle.popleft() if len(_idle) > MAX_IDLE else None
    if surplus is not None:
        surplus[1].close()


def close_idle_worlds() -> None:
    """Free all that nobody uses."""
    with _lock:
        idle = list(_idle)
        _idle.clear()
    for _, world in idle:
        world.close()


def _key(robot: SpatialRobot) -> tuple[object, ...]:
    # The model itself, compared by identity: equal entries share it. A world's bounds of motion follow the limits.
    files = (shape.file for link in robot.urdf.links for shape in link.collisions if shape.file is not None)
    digests = tuple(file_digest(file) for file in dict.fromkeys(files))
    return (robot.urdf, tuple(sorted(robot.locked.items())), robot.limits.position.tobytes(), digests)
