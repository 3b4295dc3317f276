"""Balls that cover the collision geometry of a robot's links, for planners whose collision geometry is spheres.

A convex shape is cut into convex pieces, and every piece has the smallest ball around it. A ball that holds the
corners of a convex piece holds the piece, so the balls together hold the shape, whatever the cuts are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import cos, dist, hypot, inf, pi, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.meshes import mesh_vertices
from pytest_lpb.problem.spatial.urdf import Geometry, UrdfModel

if TYPE_CHECKING:
    from pytest_lpb.problem.spatial.robot import SpatialRobot

Ball = tuple[float, float, float, float]  # centre in the link's frame, radius [m]

PAYS = 1.2  # more balls only where fewer reach beyond the shape by more than this factor
SIDES = 32  # of the prism around a cylinder: wider than the cylinder by half a percent
FLAT = 1e-6  # [m] a shape that is thinner somewhere is taken as reaching this far to either side there
THIN = 1e-9  # a share of a piece's largest extent: not cut across directions in which it is thinner
MAX_STEPS = 200  # of the search for a smallest ball; most take about six
EXACT = 1e-10  # a share of a ball's radius


def covering_balls(shape: Geometry, excess: float, most: int) -> tuple[Ball, ...]:
    """Balls in the link's frame that hold every point of a shape.

    Args:
        shape: on a link; of a mesh, its convex hull.
        excess: [m] how far a ball may reach beyond the shape's surface before the shape is split further.
        most: the largest number of balls. Where even that many reach farther than `excess`, the fewest balls that
            are about as good.
    """
    return _balls(shape, excess, most, "" if shape.file is None else file_digest(shape.file))


def link_balls(robot: SpatialRobot, excess: float, most: int) -> dict[str, tuple[Ball, ...]]:
    """Per link with collision geometry, balls in its frame that cover all its shapes, at most `most` per shape.

    Found once per robot and process; the dictionary is shared, so callers must not change it.
    """
    model, names = robot.urdf, robot.body_names
    return _link_balls(model, names, excess, most, tuple(map(file_digest, _files(model, names))))


@lru_cache(maxsize=64)
def _files(model: UrdfModel, names: tuple[str, ...]) -> tuple[Path, ...]:
    shapes = (shape for name in names for shape in model.link(name).collisions)
    return tuple({shape.file: None for shape in shapes if shape.file is not None})


# Robots of equal entries share a model; those that differ in their base or control share the shapes of their links.
@lru_cache(maxsize=64)
def _link_balls(
    model: UrdfModel, names: tuple[str, ...], excess: float, most: int, _digests: tuple[str, ...]
) -> dict[str, tuple[Ball, ...]]:
    return {
        name: tuple(ball for shape in model.link(name).collisions for ball in covering_balls(shape, excess, most))
        for name in names
    }


@lru_cache(maxsize=1024)
def _balls(shape: Geometry, excess: float, most: int, _digest: str) -> tuple[Ball, ...]:
    return _KINDS[shape.kind](shape, excess, most)


def _of_sphere(shape: Geometry, _excess: float, _most: int) -> tuple[Ball, ...]:
    return (_ball(shape.origin[:3, 3], shape.size[0]),)


def _of_capsule(shape: Geometry, excess: float, most: int) -> tuple[Ball, ...]:
    """Equal balls along the axis that meet on the capsule's surface; the outer two touch its caps from outside."""
    radius, length = shape.size
    count = next((n for n in range(1, most) if _beyond(radius, length, n) <= excess), most)
    beyond = _beyond(radius, length, count)
    half = max(0.5 * length - beyond, 0.0)
    along = np.linspace(-half, half, count) if count > 1 else np.zeros(1)
    return tuple(_ball(shape.origin[:3, 3] + z * shape.origin[:3, 2], radius + beyond) for z in along.tolist())


def _beyond(radius: float, length: float, count: int) -> float:
    """How far equal balls reach beyond a capsule that they just cover [m].

    The root x of 2 (count - 1) sqrt((radius + x)^2 - radius^2) = length - 2 x: the outer centres lie x within the
    caps' centres, and between any two the balls' surfaces meet on the capsule's.
    """
    if length == 0.0:
        return 0.0
    gaps = count - 1
    a, b = 4.0 * (gaps * gaps - 1), 8.0 * gaps * gaps * radius + 4.0 * length
    return 2.0 * length * length / (b + sqrt(max(b * b + 4.0 * a * length * length, 0.0)))


def _of_box(shape: Geometry, excess: float, most: int) -> tuple[Ball, ...]:
    corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * np.array(shape.size)
    return _of_corners(corners, shape.origin, excess, most)


def _of_cylinder(shape: Geometry, excess: float, most: int) -> tuple[Ball, ...]:
    radius, length = shape.size
    angles = np.arange(SIDES) * (2.0 * pi / SIDES)
    rim = radius / cos(pi / SIDES) * np.column_stack([np.cos(angles), np.sin(angles)])
    corners = np.vstack([np.column_stack([rim, np.full(SIDES, z)]) for z in (-0.5 * length, 0.5 * length)])
    return _of_corners(corners, shape.origin, excess, most)


def _of_mesh(shape: Geometry, excess: float, most: int) -> tuple[Ball, ...]:
    assert shape.file is not None
    corners = mesh_vertices(shape.file, (shape.size[0], shape.size[1], shape.size[2]))
    return _of_corners(corners, shape.origin, excess, most)


_KINDS: dict[str, Callable[[Geometry, float, int], tuple[Ball, ...]]] = {
    "sphere": _of_sphere,
    "capsule": _of_capsule,
    "box": _of_box,
    "cylinder": _of_cylinder,
    "mesh": _of_mesh,
}


def _ball(centre: FloatArray, radius: float) -> Ball:
    x, y, z = centre.tolist()
    return (x, y, z, radius)


@dataclass(frozen=True, eq=False)
class _Polytope:
    """A convex body.

    Attributes:
        corners: (n, 3) [m]; the body is their convex hull.
        edges: (m, 2) corners that are joined; all edges of the body, and any other lines in it.
    """

    corners: FloatArray
    edges: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Piece:
    """A part of a shape and its ball; the ball reaches `excess` [m] beyond the whole shape."""

    body: _Polytope
    centre: FloatArray
    radius: float
    excess: float


def _of_corners(corners: FloatArray, origin: FloatArray, excess: float, most: int) -> tuple[Ball, ...]:
    """Balls that hold the convex hull of corners (n, 3) [m] in the frame `origin` (4, 4)."""
    covers = list(_covers(corners, excess, most))
    worst = [max(piece.excess for piece in cover) for cover in covers]
    enough = excess if min(worst) <= excess else PAYS * min(worst)
    chosen = next(cover for cover, reach in zip(covers, worst, strict=True) if reach <= enough)
    turn, shift = origin[:3, :3], origin[:3, 3]
    return _without_nested([_ball(turn @ piece.centre + shift, piece.radius) for piece in chosen])


def _without_nested(balls: list[Ball]) -> tuple[Ball, ...]:
    """The balls that are in no other one, the largest first."""
    kept: list[Ball] = []
    for ball in sorted(balls, key=lambda ball: -ball[3]):
        if not any(dist(ball[:3], other[:3]) + ball[3] <= other[3] for other in kept):
            kept.append(ball)
    return tuple(kept)


def _covers(corners: FloatArray, excess: float, most: int) -> Iterator[list[_Piece]]:
    """Covers by one piece, two pieces and so on, as far as they are asked for."""
    body, planes = _hull(corners)
    pieces = [_piece(body, planes)]
    yield pieces
    while len(pieces) < most:
        worst = max(pieces, key=lambda piece: piece.excess)
        halves = _best_halves(worst.body, planes) if worst.excess > excess else None
        if halves is None:
            return
        pieces = [*(piece for piece in pieces if piece is not worst), *halves]
        yield pieces


def _hull(corners: FloatArray) -> tuple[_Polytope, FloatArray]:
    """The convex hull of corners (n, 3), and planes (m, 4) around it: outward normal, offset [m]."""
    from scipy.spatial import ConvexHull  # late: it takes a third of a second

    offsets = corners - corners.mean(axis=0)
    axes = _principal(offsets)
    for axis in axes[np.ptp(offsets @ axes.T, axis=0) < FLAT]:  # Qhull takes no flat shapes
        corners = np.concatenate([corners - FLAT * axis, corners + FLAT * axis])
    hull = ConvexHull(corners)
    sides = np.sort(hull.simplices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    used, edges = np.unique(np.unique(sides, axis=0), return_inverse=True)
    return _Polytope(corners[used], edges.reshape(-1, 2)), hull.equations


def _piece(body: _Polytope, planes: FloatArray) -> _Piece:
    centre, radius = enclosing_ball(body.corners)
    # The centre is in the shape. Beyond the face it is nearest to, the ball reaches farthest.
    return _Piece(body, centre, radius, radius + float((planes[:, :3] @ centre + planes[:, 3]).max()))


def _best_halves(body: _Polytope, planes: FloatArray) -> tuple[_Piece, _Piece] | None:
    """The halves whose balls reach least beyond the shape; None for a point, which has none."""
    best, least = None, inf
    for first, second in _halvings(body):
        one = _piece(first, planes)
        if one.excess >= least:
            continue
        other = _piece(second, planes)
        if other.excess < least:
            best, least = (one, other), max(one.excess, other.excess)
    return best


def _halvings(body: _Polytope) -> Iterator[tuple[_Polytope, _Polytope]]:
    """Halves across the axes of the shape's frame and across the body's principal axes."""
    for axes in (np.eye(3), _principal(body.corners - body.corners.mean(axis=0))):
        along = body.corners @ axes.T
        low, high = along.min(axis=0), along.max(axis=0)
        for index in np.flatnonzero(high - low > THIN * (high - low).max()).tolist():
            middle = 0.5 * (low[index] + high[index])
            yield _cut(body, np.roll(axes, -index, axis=0), middle)


def _principal(offsets: FloatArray) -> FloatArray:
    """Principal axes of points (n, 3) around the origin: orthonormal rows (3, 3)."""
    axes: FloatArray = np.linalg.eigh(offsets.T @ offsets)[1].T
    return axes


def _cut(body: _Polytope, axes: FloatArray, offset: float) -> tuple[_Polytope, _Polytope]:
    """The parts of a body below and above `offset` [m] along the first of three orthonormal axes (rows)."""
    height = body.corners @ axes[0] - offset
    low = height <= 0.0
    cut = body.edges[low[body.edges[:, 0]] != low[body.edges[:, 1]]]
    share = height[cut[:, :1]] / (height[cut[:, :1]] - height[cut[:, 1:]])
    section = body.corners[cut[:, 0]] + share * (body.corners[cut[:, 1]] - body.corners[cut[:, 0]])
    # The section is convex: around its middle, its corners follow one another, and so do its edges.
    flat = (section - section.mean(axis=0)) @ axes[1:].T
    ring = np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))
    rim = np.column_stack([ring, np.roll(ring, -1)])
    return _part(body, low, cut, section, rim), _part(body, ~low, cut, section, rim)


def _part(
    body: _Polytope, inside: NDArray[np.bool_], cut: NDArray[np.intp], section: FloatArray, rim: NDArray[np.intp]
) -> _Polytope:
    """The hull of a body's corners inside and the section's, where the edges `cut` meet the section in turn."""
    count = int(inside.sum())
    index = np.cumsum(inside) - 1
    whole = body.edges[inside[body.edges].all(axis=1)]
    ends = np.where(inside[cut[:, 0]], cut[:, 0], cut[:, 1])
    shortened = np.column_stack([index[ends], count + np.arange(len(cut))])
    return _Polytope(
        np.concatenate([body.corners[inside], section]), np.concatenate([index[whole], shortened, count + rim])
    )


def enclosing_ball(points: FloatArray) -> tuple[FloatArray, float]:
    """Centre (3,) and radius [m] of the smallest ball that holds points (n, 3).

    After Fischer, Gaertner and Kutz (2003): the centre walks towards that of the smallest ball through the points
    on the surface, until another point is met or one of them is no longer needed. The radius is the farthest point's
    distance from wherever the walk ends, so the ball holds all points.
    """
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    squares = _squares(points - centre)
    support = [int(squares.argmax())]
    tiny = EXACT * sqrt(squares[support[0]])
    for _ in range(MAX_STEPS):
        first = points[support[0]]
        spans = points[support[1:]] - first
        weights = np.linalg.lstsq(spans.T, centre - first, rcond=None)[0] if len(support) > 1 else np.zeros(0)
        step = first + weights @ spans - centre
        if hypot(*step.tolist()) <= tiny:
            shares = [1.0 - float(weights.sum()), *weights.tolist()]
            least = min(range(len(shares)), key=shares.__getitem__)
            if shares[least] >= -EXACT:
                break
            del support[least]
            continue
        share, met = _way(points, centre, step, first)
        centre = centre + min(share, 1.0) * step
        if share < 1.0:
            support.append(met)
    return centre, sqrt(_squares(points - centre).max())


def _way(points: FloatArray, centre: FloatArray, step: FloatArray, first: FloatArray) -> tuple[float, int]:
    """The share of a step after which another point is as far from the centre as `first` is, and that point."""
    squares, square = _squares(points - centre), float((first - centre) @ (first - centre))
    closing = 2.0 * ((first - points) @ step)
    # Never met: points that the step does not bring nearer to the surface, as those on it and in their plane.
    met = closing > 1e-12 * sqrt(float(step @ step) * square)
    shares = np.full(len(points), inf)
    np.divide(np.maximum(square - squares, 0.0), closing, out=shares, where=met)
    nearest = int(shares.argmin())
    return float(shares[nearest]), nearest


def _squares(rows: FloatArray) -> FloatArray:
    squares: FloatArray = np.einsum("ij,ij->i", rows, rows)
    return squares
