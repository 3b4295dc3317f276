"""Random fast motions of points, carts and arms past thin obstacles, judged by closed forms or by dense sampling.

    python -m tests.environment.fast_motions 1000000

What an engine says of one step is held to a referee that shares no code with it: none of the motions passes through an
obstacle unseen, and none is called a contact that keeps clear.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.environment.monitor import Violation, contact_since
from pytest_lpb.environment.planar import PlanarEngine
from pytest_lpb.problem.problem import Problem
from tests.problem.entries import make_problem

Array = NDArray[np.float64]
DT = 0.1  # [s]
SURE_M = 1e-7  # [m] to which closed forms are trusted
SAMPLES = 2001


@dataclass
class Motion:
    """One step of a problem from its start, and the referee's least distance during it, with its error [m]."""

    problem: Problem
    action: list[float]
    distance: float
    error: float


def judged(motion: Motion) -> tuple[str, Violation | None]:
    """How the engine's verdict compares with the referee's.

    `hit`, `hit between rows` and `free` are right, `missed` and `false` wrong; `open` where the referee cannot tell.
    """
    engine = PlanarEngine(motion.problem)
    engine.set_state(motion.problem.start_q.tolist(), motion.problem.start_u.tolist())
    place(engine, motion.problem, 0.0)
    before, own_before = engine.clearance()
    if min(before[0], own_before[0] if own_before[0] == own_before[0] else before[0]) < 1e-3:
        return "open", None  # it begins in contact, or about so
    engine.advance(motion.action)
    place(engine, motion.problem, DT)
    after, own_after = engine.clearance()
    violation = None
    if engine.may_have_touched(1, before[0] + after[0], own_before[0] + own_after[0]):
        violation = contact_since(1, engine, DT)
    if motion.distance < -motion.error:
        if violation is None:
            return "missed", None
        return ("hit" if violation.clearance[0] < 0.0 else "hit between rows"), violation
    if motion.distance > motion.error:
        return ("false" if violation else "free"), violation
    return "open", violation


def place(engine: PlanarEngine, problem: Problem, t: float) -> None:
    """Place all obstacles at a time [s]."""
    poses = [obstacle.poses(np.array([t])) for obstacle in problem.obstacles]
    engine.place_obstacles([p[0].tolist() for p, _ in poses], [float(a[0]) for _, a in poses])


def segment_to_box(start: Array, end: Array, half: Array) -> float:
    """Distance of a segment to a box around the origin; 0 where they meet (Liang and Barsky's clipping)."""
    direction = end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = (-half - start) / direction, (half - start) / direction
    inside = np.abs(start) <= half
    enter = np.where(direction == 0.0, np.where(inside, -np.inf, np.inf), np.minimum(low, high)).max()
    leave = np.where(direction == 0.0, np.where(inside, np.inf, -np.inf), np.maximum(low, high)).min()
    if enter <= leave and leave >= 0.0 and enter <= 1.0:
        return 0.0
    ends = np.linalg.norm(np.maximum(np.abs(np.stack([start, end])) - half, 0.0), axis=1)
    corners = half * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    share = np.clip((corners - start) @ direction / (direction @ direction), 0.0, 1.0)
    return float(min(ends.min(), np.linalg.norm(start + share[:, None] * direction - corners, axis=1).min()))


def point_past_a_bar(random: np.random.Generator) -> Motion:
    """A disc in straight motion, up to 1 km/s, past a bar that stands or moves along a line: closed form."""
    radius = 10.0 ** random.uniform(-4, -1)
    thickness, length = 10.0 ** random.uniform(-4, -1), 10.0 ** random.uniform(-2, 1)
    angle, bar = random.uniform(-np.pi, np.pi), random.uniform(-1, 1, 2)
    speed = 10.0 ** random.uniform(0, 3)
    heading = random.uniform(-np.pi, np.pi)
    # Most lines of motion lead past the bar at about its length.
    through = bar + random.uniform(-0.7, 0.7) * length * np.array([np.cos(angle), np.sin(angle)])
    velocity = speed * np.array([np.cos(heading), np.sin(heading)])
    start = through - random.uniform(-0.2, 1.2) * velocity * DT
    drift = random.uniform(-50, 50, 2) if random.random() < 0.15 else np.zeros(2)
    robot_velocity = velocity + drift
    place = {"trajectory": [f"{x!r} + {v!r}*t" for x, v in zip(bar.tolist(), drift.tolist(), strict=True)]}
    entry = {"name": "bar", "shape": "rectangle", "size": [length, thickness], "orientation": angle}
    problem = _problem(
        {"model": "point", "name": "point", "base": "fixed", "body_radius": radius, "control": "velocity"},
        [entry | (place if drift.any() else {"position": bar.tolist()})],
        start.tolist(),
    )
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    half = 0.5 * np.array([length, thickness])
    distance = segment_to_box(turn @ (start - bar), turn @ (start + velocity * DT - bar), half) - radius
    return Motion(problem, robot_velocity.tolist(), distance, SURE_M * (1.0 + speed * DT))


def point_that_brakes(random: np.random.Generator) -> Motion:
    """A disc on a parabola, which may turn round within the step, past a small disc: roots of a cubic."""
    radius, size = 10.0 ** random.uniform(-4, -1, 2)
    velocity, action = random.uniform(-100, 100, 2), random.uniform(-2000, 2000, 2)
    share = random.uniform(0, 1)
    meets = velocity * share * DT + 0.5 * action * (share * DT) ** 2
    disc = meets + random.normal(0, 2.0, 2) * (radius + size)
    problem = _problem(
        {"model": "point", "name": "point", "base": "fixed", "body_radius": radius, "control": "acceleration"},
        [{"name": "disc", "shape": "circle", "radius": size, "position": disc.tolist()}],
        [0.0, 0.0],
        velocity.tolist(),
    )
    # d/dt |p - disc|^2 = 0
    cubic = 2.0 * sum(np.polymul([0.5 * a, v, -c], [a, v]) for a, v, c in zip(action, velocity, disc, strict=True))
    roots = np.roots(cubic)
    times = np.clip(np.concatenate([[0.0, DT], roots[np.abs(roots.imag) < 1e-6].real]), 0.0, DT)
    path = times[:, None] * velocity + 0.5 * times[:, None] ** 2 * action - disc
    return Motion(problem, action.tolist(), float(np.linalg.norm(path, axis=1).min()) - radius - size, SURE_M)


def cart_past_a_post(random: np.random.Generator) -> Motion:
    """A cart on an arc past a thin post: the distance of a point to an arc, by its angles."""
    radius, size = 10.0 ** random.uniform(-3, -1, 2)
    speed, rate = random.uniform(-80, 80), random.uniform(-40, 40)
    arc = speed / rate
    share = random.uniform(0, 1)
    angle = rate * DT * share
    meets = arc * np.array([np.sin(angle), 1.0 - np.cos(angle)])
    post = meets + random.normal(0, 2.0, 2) * (radius + size)
    robot = {"model": "differential_drive", "name": "cart", "base": "differential_drive", "wheel_base": 0.5}
    problem = _problem(
        {**robot, "body_radius": radius, "control": "velocity"},
        [{"name": "post", "shape": "circle", "radius": size, "position": post.tolist()}],
        [0.0, 0.0, 0.0],
        [0.0, 0.0],
    )
    centre = np.array([0.0, arc])
    # The robot is at centre + arc (sin, -cos)(angle), and nearest where that direction is the post's, or at an end.
    towards = np.arctan2(*((post - centre) * np.sign(arc) * np.array([1.0, -1.0])))
    turns = towards + 2.0 * np.pi * np.arange(-3, 4)
    total = rate * DT
    within = turns[(turns >= min(0.0, total)) & (turns <= max(0.0, total))]
    angles = np.concatenate([[0.0, total], within])
    path = centre + arc * np.column_stack([np.sin(angles), -np.cos(angles)])
    return Motion(problem, [speed, rate], float(np.linalg.norm(path - post, axis=1).min()) - radius - size, SURE_M)


def arm_past_posts(random: np.random.Generator) -> Motion:
    """An arm of two to four links that sweeps past three thin posts, and perhaps itself: dense sampling."""
    count = int(random.integers(2, 5))
    lengths = random.uniform(0.3, 1.0, count)
    radius = 10.0 ** random.uniform(-3, -1.5)
    rates = random.uniform(-20, 20, count)
    q = random.uniform(-np.pi, np.pi, count)
    posts = [
        {"name": f"post{index}", "shape": "circle", "radius": 10.0 ** random.uniform(-3, -1.5), "position": place}
        for index, place in enumerate(random.uniform(-2, 2, (3, 2)).tolist())
    ]
    robot = {"model": "planar_arm", "name": "arm", "links": lengths.tolist(), "base": "fixed", "body_radius": radius}
    problem = _problem({**robot, "control": "velocity"}, posts, q.tolist())
    times = np.linspace(0.0, DT, SAMPLES)
    angles = np.cumsum(q + times[:, None] * rates, axis=1)
    joints = np.zeros((SAMPLES, count + 1, 2))
    joints[:, 1:] = np.cumsum(np.stack([np.cos(angles), np.sin(angles)], axis=2) * lengths[:, None], axis=1)
    distance = min(
        *(
            float(_to_segments(np.array(post["position"]), joints[:, i], joints[:, i + 1]).min()) - post["radius"]
            for post in posts
            for i in range(count)
        ),
        *_own_distances(joints, radius),
    )
    # Half of what two bodies can close in by from one sample to the next.
    error = float(np.abs(np.cumsum(rates)) @ lengths) * DT / (SAMPLES - 1)
    return Motion(problem, rates.tolist(), distance - radius, error + SURE_M)


def _own_distances(joints: Array, radius: float) -> list[float]:
    """Distances between links that are not neighbours, less one radius: the base's disc and all links."""
    count = joints.shape[1] - 1
    found = [float(_to_segments(joints[:, 0], joints[:, j], joints[:, j + 1]).min()) - radius for j in range(1, count)]
    for i in range(count):
        for j in range(i + 2, count):
            ends = [
                _to_segments(joints[:, a], joints[:, b], joints[:, b + 1])
                for a, b in ((i, j), (i + 1, j), (j, i), (j + 1, i))
            ]
            apart = np.minimum.reduce(ends)
            found.append(float(np.where(_cross(joints, i, j), -radius, apart).min()) - radius)
    return found


def _cross(joints: Array, i: int, j: int) -> NDArray[np.bool_]:
    a, b, c, d = joints[:, i], joints[:, i + 1], joints[:, j], joints[:, j + 1]

    def side(p: Array, q: Array, r: Array) -> Array:
        turned: Array = (q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0]
        return turned

    crossing: NDArray[np.bool_] = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    return crossing


def _to_segments(point: Array, start: Array, end: Array) -> Array:
    along = end - start
    share = np.clip(((point - start) * along).sum(axis=1) / (along * along).sum(axis=1), 0.0, 1.0)
    distance: Array = np.linalg.norm(start + share[:, None] * along - point, axis=1)
    return distance


def _problem(robot: dict[str, Any], obstacles: list[dict[str, Any]], q: list[float], u: Any = None) -> Problem:
    return make_problem(robot, obstacles=obstacles, q=q, u=u, dt=DT, duration=DT)


KINDS: dict[str, Callable[[np.random.Generator], Motion]] = {
    "point past a bar": point_past_a_bar,
    "point that brakes": point_that_brakes,
    "cart past a post": cart_past_a_post,
    "arm past posts": arm_past_posts,
}
SHARES = {"point past a bar": 0.45, "point that brakes": 0.3, "cart past a post": 0.2, "arm past posts": 0.05}


def verdicts(kind: str, count: int, seed: int) -> Counter[str]:
    """How often each verdict came up in `count` motions. Raises AssertionError for a wrong one."""
    random = np.random.Generator(np.random.PCG64(seed))
    found: Counter[str] = Counter()
    for index in range(count):
        motion = KINDS[kind](random)
        verdict, violation = judged(motion)
        found[verdict] += 1
        if verdict in ("missed", "false"):
            entry = motion.problem.to_dict()
            raise AssertionError(
                f"{kind} {index} of seed {seed}: {verdict}, at {motion.distance} m: {violation}; "
                f"{entry['robot']} {entry['start']} {motion.action} {entry['obstacles']}"
            )
    return found


def main() -> None:
    """Judge as many motions as asked for."""
    total, seed = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    for kind, share in SHARES.items():
        count = round(share * total)
        print(f"{kind}: {count} motions, {dict(verdicts(kind, count, seed))}", flush=True)


if __name__ == "__main__":
    main()
