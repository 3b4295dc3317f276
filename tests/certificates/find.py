"""Finds a path for each scenario in space and writes it beside them: python -m tests.certificates.find FILE..

Successful trials of the built-in planners come first; where there are none, a bidirectional search in joint space
(RRT-Connect: Kuffner and LaValle, ICRA 2000) for problems in which nothing moves but the robot.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.planner.files import find_planners
from pytest_lpb.problem.collision import CollisionSpace
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.inverse_kinematics import goal_configurations
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.certificates.paths import Array, faults_of_path, path_length, write_path

ROWS_S = (0.2, 0.1, 0.05, 0.02)  # [s] between rows kept of a trial
MARGIN_M = 0.005  # [m] that a searched path keeps
STEP = 0.05  # [rad or m] of the search
NODES = 20_000
SHORTCUTS = 300
SPEED = 0.5  # share of the velocity limits that a searched path uses
SLOW = 1.0  # [rad/s or m/s] where there are none

VARIANTS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("pd", {}),
    ("potential_field", {}),
    ("potential_field", {"repulsion": 0.001, "influence": 0.15, "speed": 0.4}),
    ("potential_field", {"repulsion": 0.01, "influence": 0.3, "speed": 0.4}),
    ("potential_field", {"repulsion": 0.0005, "influence": 0.1, "stiffness": 8.0, "damping": 5.0}),
    ("potential_field", {"stiffness": 40.0, "damping": 12.0}),
)


def from_trials(problem: Problem) -> Iterator[tuple[str, Array, Array]]:
    """Rows of successful trials, every few."""
    for name, parameters in VARIANTS:
        configuration = find_planners([name], [Path("planners")])[0]
        configuration = replace(
            configuration,
            parameters={**configuration.parameters, **parameters},
            per_robot=_with(configuration.per_robot, parameters),
        )
        trajectory = run_trial(TrialSpecification(problem.to_dict(), configuration))
        if not trajectory.metadata["success"]:
            continue
        last = len(trajectory) - 1 if problem.primary.moving else int(trajectory.goal_row or 0)
        for spacing in ROWS_S:
            every = max(1, round(spacing / problem.dt))
            rows = sorted({*range(0, last, every), last})
            yield f"Found by the planner {name} {parameters or ''}".rstrip(), trajectory.t[rows], trajectory.q[rows]


def _with(per_robot: Mapping[str, Mapping[str, Any]], parameters: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    return {name: {**given, **parameters} for name, given in per_robot.items()}


def connected(problem: Problem) -> Iterator[tuple[str, Array, Array]]:
    """Paths of the search in joint space, with a time law."""
    robot = problem.robot
    if any(obstacle.moving for obstacle in problem.obstacles) or robot.non_holonomic:
        return
    goals = goal_configurations(robot, [g for g in problem.goal if g.tolerance is not None], problem.start_q)
    with closing(robot.collision_space(problem.obstacles)) as space:
        free = [goal for goal in goals if _is_free(space, goal)]
        for seed in range(5):
            generator = np.random.Generator(np.random.PCG64(seed))
            for goal in free:
                way = _search(space, problem.start_q, goal, robot.limits.position, generator)
                if way is not None:
                    t = _times(way, robot.limits.velocity[:, 1])
                    yield f"Found by RRT-Connect, seed {seed}, with short cuts", t, way


def _is_free(space: CollisionSpace, q: Array) -> bool:
    values = q.tolist()
    return not space.clearance(values)[0] < MARGIN_M and not space.self_clearance(values)[0] < 0.0


def _line_is_free(space: CollisionSpace, a: Array, b: Array) -> bool:
    count = max(1, int(np.ceil(np.abs(b - a).max() / (0.4 * STEP))))
    return all(_is_free(space, a + (b - a) * share) for share in np.arange(1, count + 1) / count)


def _search(
    space: CollisionSpace, start: Array, goal: Array, limits: Array, generator: np.random.Generator
) -> Array | None:
    limits = np.clip(limits, -np.pi, np.pi)
    trees: list[tuple[list[Array], list[int]]] = [([start], [-1]), ([goal], [-1])]
    for count in range(NODES):
        target = limits[:, 0] + generator.random(len(start)) * (limits[:, 1] - limits[:, 0])
        first, second = trees[count % 2], trees[1 - count % 2]
        new = _extend(space, first, target)
        if new is not None and _connect(space, second, first[0][new]):
            ways = (_trace(first, new), _trace(second, len(second[0]) - 1))
            there, back = ways if count % 2 == 0 else (ways[1], ways[0])
            return _shortened(space, np.array([*there, *back[::-1][1:]]), generator)
        if len(first[0]) + len(second[0]) > NODES:
            return None
    return None


def _extend(space: CollisionSpace, tree: tuple[list[Array], list[int]], target: Array) -> int | None:
    nodes, parents = tree
    nearest = int(np.abs(np.array(nodes) - target).max(axis=1).argmin())
    offset = target - nodes[nearest]
    length = float(np.abs(offset).max())
    if length < 1e-9:
        return None
    new = nodes[nearest] + offset * min(1.0, 4.0 * STEP / length)
    if not _line_is_free(space, nodes[nearest], new):
        return None
    nodes.append(new)
    parents.append(nearest)
    return len(nodes) - 1


def _connect(space: CollisionSpace, tree: tuple[list[Array], list[int]], target: Array) -> bool:
    while True:
        new = _extend(space, tree, target)
        if new is None:
            return False
        if np.abs(tree[0][new] - target).max() < 1e-9:
            return True


def _trace(tree: tuple[list[Array], list[int]], node: int) -> list[Array]:
    way = []
    while node >= 0:
        way.append(tree[0][node])
        node = tree[1][node]
    return way[::-1]


def _shortened(space: CollisionSpace, way: Array, generator: np.random.Generator) -> Array:
    for _ in range(SHORTCUTS):
        if len(way) < 3:
            break
        i, j = sorted(generator.choice(len(way), 2, replace=False).tolist())
        if j - i > 1 and _line_is_free(space, way[i], way[j]):
            way = np.vstack([way[: i + 1], way[j:]])
    return way


def _times(way: Array, fastest: Array) -> Array:
    speed = SPEED * np.where(np.isfinite(fastest), fastest, SLOW)
    return np.concatenate([[0.0], np.cumsum((np.abs(np.diff(way, axis=0)) / speed).max(axis=1))])


def certify(file: Path) -> str:
    """Find a path, write it, and name it in the scenario file."""
    text = file.read_text(encoding="utf-8")
    plain = re.sub(r"^certified:.*\n", "", text, flags=re.MULTILINE)
    file.write_text(plain, encoding="utf-8")
    scenario = load_scenario(file)
    problem = draw_problem(scenario, scenario.seed)
    for find in (from_trials, connected):
        for how, t, q in find(problem):
            q = np.vstack([problem.start_q, q[1:]])
            faults = faults_of_path(problem, t, q)
            if not faults:
                path = file.parents[1] / "paths" / f"{file.parent.name}_{file.stem}.csv"
                write_path(path, how, t, q)
                length = path_length(problem, np.round(q, 6))
                entry = f"{{seed: {scenario.seed}, length_m: {length:.4f}, path: ../paths/{path.name}}}"
                file.write_text(f"{plain}certified: {entry}\n", encoding="utf-8")
                return f"{file}: {how}, {t[-1]:.2f} s, {length:.3f} m, {len(t)} rows"
            print(f"  {file.stem}: {how}: {'; '.join(faults)}")
    return f"{file}: NOT FOUND"


if __name__ == "__main__":
    for name in sys.argv[1:]:
        print(certify(Path(name)), flush=True)
