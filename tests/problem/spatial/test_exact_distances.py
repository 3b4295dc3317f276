"""Distances between shapes of robots and obstacles, each one proved by points and directions of its own.

`LPB_DISTANCE_PAIRS=2000 pytest -n 0 -s tests/problem/spatial/test_exact_distances.py` draws that many pairs per kind
and prints the largest errors.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import from_matrix
from pytest_lpb.problem.spatial.world import World
from tests.problem.spatial.convex_shapes import (
    Array,
    Convex,
    Placed,
    box,
    capsule,
    cylinder,
    directions_of,
    hull,
    separation,
    sphere,
)
from tests.problem.spatial.robots import DEFAULTS

PAIRS = int(os.environ.get("LPB_DISTANCE_PAIRS", "24"))
# [m] as docs/environment.md has them; of pairs with a cylinder, and of the others.
ROUND, EXACT = 1e-5, 1e-6

VERTICES = np.random.Generator(np.random.PCG64(3)).uniform(-0.3, 0.3, (40, 3)) * (1.0, 0.6, 1.4)


@dataclass(frozen=True, eq=False)
class Kind:
    """A shape by its formula, as a URDF has it, and as an obstacle of a scenario."""

    convex: Convex
    urdf: str
    obstacle: dict[str, Any]


KINDS = {
    "sphere": Kind(sphere(0.25), '<sphere radius="0.25"/>', {"radius": 0.25}),
    "box": Kind(box([0.5, 0.3, 0.8]), '<box size="0.5 0.3 0.8"/>', {"size": [0.5, 0.3, 0.8]}),
    "capsule": Kind(
        capsule(0.15, 0.6), '<capsule radius="0.15" length="0.6"/>', {"radius": 0.15, "length": 0.6}
    ),
    "cylinder": Kind(
        cylinder(0.3, 0.5), '<cylinder radius="0.3" length="0.5"/>', {"radius": 0.3, "length": 0.5}
    ),
    "mesh": Kind(hull(VERTICES), '<mesh filename="hull.obj"/>', {"file": "hull.obj"}),
}
JOINTS = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1", "a": "0 0 1", "b": "0 1 0", "c": "1 0 0"}


def robot_of(folder: Path, still: Kind, free: Kind) -> SpatialRobot:
    """A shape that stands at the origin, and another one that moves in all directions."""
    links, joints = [f'<link name="still">{_collision(still)}</link>'], []
    parent = "still"
    for name, axis in JOINTS.items():
        kind = "prismatic" if name in "xyz" else "revolute"
        shape = _collision(free) if name == "c" else ""
        links.append(f'<link name="{name}_link">{shape}</link>')
        joints.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{name}_link"/>'
            f'<axis xyz="{axis}"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
        )
        parent = f"{name}_link"
    write_hull(folder / "hull.obj")
    path = folder / "robot.urdf"
    path.write_text("\n".join(['<robot name="pair">', *links, *joints, "</robot>"]), encoding="utf-8")
    entry = {**DEFAULTS, "urdf": str(path), "name": "pair", "joints": list(JOINTS)}
    robot = SpatialRobot(entry)
    return robot


def _collision(kind: Kind) -> str:
    return f"<collision><geometry>{kind.urdf}</geometry></collision>"


def write_hull(path: Path) -> None:
    """The convex hull of `VERTICES` as a Wavefront file, its faces as seen from outside."""
    from scipy.spatial import ConvexHull

    found = ConvexHull(VERTICES)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in VERTICES.tolist()]
    for corners, plane in zip(found.simplices, found.equations, strict=True):
        a, b, c = VERTICES[corners]
        i, j, k = (corners if np.cross(b - a, c - a) @ plane[:3] > 0.0 else corners[::-1]) + 1
        lines.append(f"f {i} {j} {k}")
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")


def poses(kind: str, still: Convex, free: Convex) -> list[tuple[Array, Array]]:
    """Positions (3,) and angles (3,) of a free shape about one at the origin.

    By turns: anywhere, about to touch, deep inside; turned by right angles, so that faces, edges and axes are in line.
    """
    generator = np.random.Generator(np.random.PCG64(sum(kind.encode())))
    found = []
    for number in range(PAIRS):
        direction = generator.standard_normal(3)
        direction /= np.linalg.norm(direction)
        angles = generator.uniform(-np.pi, np.pi, 3)
        if number % 4 == 3:
            angles = 0.5 * np.pi * generator.integers(-2, 3, 3)
            direction = np.round(1.5 * direction)
            direction /= max(np.linalg.norm(direction), 1.0)
        far = (still.radius + free.radius) * generator.choice([generator.uniform(0.0, 0.5), generator.uniform(0.4, 3.0)])
        found.append((far * direction, angles))
    return found


def pose_of(position: Array, angles: Array) -> Array:
    """Of a link after joints x, y, z and turns about z, y, x."""
    pose = np.eye(4)
    pose[:3, 3] = position
    for axis, angle in zip((2, 1, 0), angles, strict=True):
        turn = np.eye(3)
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        turn[i, i] = turn[j, j] = np.cos(angle)
        turn[j, i], turn[i, j] = np.sin(angle), -np.sin(angle)
        pose[:3, :3] = pose[:3, :3] @ turn
    return pose


def measured(world: World, first: tuple[int, int, float], second: tuple[int, int, float]) -> tuple[float, Array, Array]:
    """Distance, a point of the second shape that is nearest, and the direction to the first from there."""
    points = world.client.call("getClosestPoints", first[0], second[0], 100.0, first[1], second[1])
    point = min(points, key=lambda point: point[8])
    normal = np.array(point[7])
    return point[8] + first[2] + second[2], np.array(point[6]) - second[2] * normal, normal


def error_of(distance: float, point: Array, normal: Array, first: Placed, second: Placed) -> float:
    """How far a distance is from the truth at most where the shapes are apart; else as far as directions can tell."""
    below = float(separation(first, second, normal[None] / np.linalg.norm(normal))[0])
    if distance > 0.0:
        other = point + distance * normal
        return max(distance - below, second.outside(point), first.outside(other))
    deepest = float(separation(first, second, directions_of(first, second, normal)).max())
    return max(distance - below, deepest - distance)


def report(what: str, errors: list[float], bound: float) -> None:
    if "LPB_DISTANCE_PAIRS" in os.environ:
        print(f"{what}: {len(errors)} pairs, largest error {max(errors):.1e} m, allowed {bound:.0e} m")
    assert max(errors) < bound, int(np.argmax(errors))


@pytest.mark.parametrize("free", KINDS)
def test_a_link_and_obstacles(free: str, tmp_path: Path) -> None:
    robot = robot_of(tmp_path, KINDS["sphere"], KINDS[free])
    world = World(robot)
    entries = [
        {"name": name, "shape": name, "position": [0.0, 0.0, 0.0], **kind.obstacle} for name, kind in KINDS.items()
    ]
    entries.append({**entries[-1], "name": "surface", "concave": True})
    for entry in entries:
        if "file" in entry:
            entry["file"] = str(tmp_path / entry["file"])
    world.set_obstacles([Obstacle(entry) for entry in entries])
    body = world.bodies[-1]
    for index, entry in enumerate(entries):
        still = KINDS[entry["shape"]].convex
        errors = []
        for position, angles in poses(free + entry["name"], still, KINDS[free].convex):
            # The obstacle is turned, the link as well: neither is where its frame's axes are those of the world.
            placed = pose_of(position[::-1].copy(), angles[::-1].copy())
            w, x, y, z = from_matrix(placed[:3, :3])
            world.place(index, placed[:3, 3].tolist(), (w, x, y, z))
            link = placed @ pose_of(position, angles)
            world.set_q([*link[:3, 3].tolist(), *angles_of(link[:3, :3])])
            world.bring(body)
            obstacle = (world.obstacles[index], -1, world.obstacle_margins[index])
            distance, point, normal = measured(world, (body.id, body.link, body.margin), obstacle)
            if entry["name"] != "surface" or distance > 0.0:  # it has no inside
                first, second = Placed(KINDS[free].convex, link), Placed(still, placed)
                errors.append(error_of(distance, point, normal, first, second))
        report(f"{free} and {entry['name']}", errors, ROUND if "cylinder" in (free, entry["shape"]) else EXACT)
    world.close()


@pytest.mark.parametrize(("still", "free"), list(combinations_with_replacement(KINDS, 2)))
def test_a_link_and_a_link(still: str, free: str, tmp_path: Path) -> None:
    world = World(robot_of(tmp_path, KINDS[still], KINDS[free]))
    one, other = world.bodies
    errors = []
    for position, angles in poses(still + free, KINDS[still].convex, KINDS[free].convex):
        link = pose_of(position, angles)
        world.set_q([*position.tolist(), *angles.tolist()])
        world.bring(one)
        world.bring(other)
        sides = ((other.id, other.link, other.margin), (one.id, one.link, one.margin))
        first, second = Placed(KINDS[free].convex, link), Placed(KINDS[still].convex, np.eye(4))
        errors.append(error_of(*measured(world, *sides), first, second))
    world.close()
    report(f"link {still} and link {free}", errors, ROUND if "cylinder" in (still, free) else EXACT)


def angles_of(matrix: Array) -> list[float]:
    """Turns about z, y, x that make a rotation matrix (3, 3)."""
    b = float(np.arctan2(-matrix[2, 0], np.hypot(matrix[0, 0], matrix[1, 0])))
    a = float(np.arctan2(matrix[1, 0], matrix[0, 0])) if abs(np.cos(b)) > 1e-9 else 0.0
    turned = pose_of(np.zeros(3), np.array([a, b, 0.0]))[:3, :3].T @ matrix
    return [a, b, float(np.arctan2(turned[2, 1], turned[1, 1]))]
