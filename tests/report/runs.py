"""Small runs made by hand: motions towards a goal, evaluated by the package's own KPIs and tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pytest_lpb.errors import RecordingError
from pytest_lpb.kpis.registry import evaluate_kpis, load_builtin
from pytest_lpb.problem.planar.collision import PlanarCollision
from pytest_lpb.problem.problem import Problem
from pytest_lpb.report.data import ReportData
from pytest_lpb.run.tables import aggregates_table, comparisons_table, summary_table
from pytest_lpb.trajectory import Trajectory

Array = NDArray[np.float64]

CIRCLES = [
    {"name": "left", "shape": "circle", "radius": 0.7, "position": [2.0, 0.5]},
    {"name": "wall", "shape": "rectangle", "size": [0.3, 1.6], "position": [3.1, -1.4], "orientation": 0.4},
]
CART = [{"name": "cart", "shape": "circle", "radius": 0.3, "trajectory": ["3 - 0.3*t", "1.2*sin(0.4*t)"]}]
POINT = {"model": "point", "name": "point", "control": "acceleration", "base": "fixed", "body_radius": 0.15}
DRIVE = {
    "model": "differential_drive",
    "name": "differential_drive",
    "control": "velocity",
    "base": "differential_drive",
    "wheel_base": 0.5,
    "body_radius": 0.2,
}
ARM = {
    "model": "planar_arm",
    "name": "planar_arm_3",
    "links": [1.0, 1.0, 0.8],
    "control": "acceleration",
    "base": "fixed",
    "body_radius": 0.08,
}
SCENARIOS: dict[str, tuple[dict[str, Any], str, list[dict[str, Any]]]] = {
    "point/two_obstacles": (POINT, "body", CIRCLES),
    "cart/crossing": (DRIVE, "base", CART),
    "arm/reach": (ARM, "end", [{"name": "ball", "shape": "circle", "radius": 0.35, "position": [1.6, 1.9]}]),
}


def make_problem(scenario: str, seed: int) -> Problem:
    """A problem of one of `SCENARIOS` (any other name: the point's), its goal drawn by the seed."""
    robot, link, obstacles = SCENARIOS.get(scenario, SCENARIOS["point/two_obstacles"])
    shift = np.random.default_rng(seed).uniform(-0.8, 0.8)
    target = [-0.7, 2.2 + 0.3 * shift] if robot is ARM else [4.2, 0.2 + shift]
    size = {"point": 2, "planar_arm": 3, "differential_drive": 3}[robot["model"]]
    return Problem.from_dict(
        {
            "robot": robot,
            "environment": {
                "engine": "planar",
                "dt": 0.05,
                "duration": 12.0,
                "end_at": ["goal", "violation"],
                "safety_margin": 0.1,
                "dynamics": False,
                "gravity": [0.0, 0.0, -9.81],
                "prediction": "constant_velocity",
            },
            "start": {"q": [0.0] * size, "u": [0.0] * (2 if robot is DRIVE else size)},
            "goal": [{"name": "reach", "type": "position", "link": link, "target": target, "tolerance": 0.12}],
            "obstacles": obstacles,
            "success": {"hold_time": 0.2},
            "seed": seed,
        }
    )


def make_trajectory(problem: Problem, node_id: str, push: float, rows: int = 240) -> Trajectory:
    """Motion to the goal, away from obstacles as hard as `push` says; ends at the goal or a contact."""
    robot, goal = problem.robot, problem.primary
    collision = PlanarCollision(robot, problem.obstacles)  # type: ignore[arg-type]
    q, states, errors, clearances = problem.start_q.copy(), [], [], []
    for row in range(rows):
        t = np.array([row * problem.dt])
        for shape, obstacle in zip(collision.shapes, problem.obstacles, strict=True):
            place, angle = obstacle.poses(t)
            shape.place(float(place[0, 0]), float(place[0, 1]), float(angle[0]))
        frames: Any = robot.frames(q.tolist())
        target = goal.motion.evaluate(t)[0][0]
        tip = np.array(goal.value(q.tolist(), frames))
        states.append(q.copy())
        errors.append(goal.distance(tip.tolist(), target.tolist()))
        clearances.append(collision.clearance(collision.capsules(frames)))
        if clearances[-1][0] < 0 or (row > 4 and max(errors[-5:]) < 0.12):
            break
        q = _step(problem, q, _wish(tip, target, collision, push), clearances[-1][0])
    outcome = "collision" if clearances[-1][0] < 0 else "success" if errors[-1] < 0.12 else "timeout"
    return _recorded(problem, node_id, outcome, np.array(states), np.array(errors), clearances)


def _wish(tip: Array, target: Array, collision: PlanarCollision, push: float) -> Array:
    wish = target - tip
    wish = wish / max(float(np.linalg.norm(wish)), 0.6)
    for shape in collision.shapes:
        away = tip - np.array([shape.x, shape.y])
        gap = max(float(np.linalg.norm(away)) - shape.circumradius, 0.05)
        side = np.array([-away[1], away[0]])
        wish = wish + push * math.exp(-3 * gap) * (away + side) / np.linalg.norm(away)
    return wish


def _step(problem: Problem, q: Array, wish: Array, clearance: float) -> Array:
    robot, dt = problem.robot, problem.dt
    jacobian = robot.jacobian(q, problem.primary.link or "")[:2]
    if robot.non_holonomic:
        turn = math.remainder(math.atan2(wish[1], wish[0]) - q[2], 2 * math.pi)
        speed = float(np.linalg.norm(wish)) * max(math.cos(turn), 0.0)
        return np.asarray(q + dt * robot.action_map(q) @ np.array([speed, 2.0 * turn]))
    damped = jacobian @ jacobian.T + 0.02 * np.eye(2)
    return np.asarray(q + dt * jacobian.T @ np.linalg.solve(damped, wish) + 1e-3 * min(clearance, 1.0))


def _recorded(
    problem: Problem,
    node_id: str,
    outcome: str,
    q: Array,
    errors: Array,
    clearances: Sequence[tuple[float, str, str]],
) -> Trajectory:
    rows, actions = len(q), problem.robot.n_actions
    t = np.arange(rows).astype(np.float64) * problem.dt
    qd = (np.gradient(q, problem.dt, axis=0) if rows > 1 else np.zeros_like(q)).astype(np.float64)
    noise = np.random.default_rng(rows)
    columns: dict[str, NDArray[Any]] = {"t": t, "goal_reach_error": errors}
    columns |= {f"q{i}": q[:, i] for i in range(q.shape[1])} | {f"qd{i}": qd[:, i] for i in range(q.shape[1])}
    for name in ("u", "action", "applied"):
        columns |= {f"{name}{i}": qd[:, i] for i in range(actions)}
    links = problem.robot.link_positions(q)
    for index, link in enumerate(problem.robot.link_names):
        columns |= {f"link_{link}_{letter}": links[:, index, axis] for axis, letter in enumerate("xy")}
    target = problem.primary.motion.evaluate(t)[0]
    columns |= {f"goal_reach_{i}": target[:, i] for i in range(2)}
    for obstacle in problem.obstacles:
        place, angle = obstacle.poses(t)
        columns |= {f"obstacle_{obstacle.name}_x": place[:, 0], f"obstacle_{obstacle.name}_y": place[:, 1]}
        columns[f"obstacle_{obstacle.name}_theta"] = angle
    for index, name in enumerate(("clearance_m", "clearance_body", "clearance_obstacle")):
        columns[name] = np.array([row[index] for row in clearances])
    columns["self_clearance_m"] = np.full(rows, np.nan)
    columns["solver_wall_ms"] = noise.lognormal(-1.0, 0.3, rows)
    columns["solver_cpu_ms"] = 0.95 * columns["solver_wall_ms"]
    file, planner, seed = node_id.split("::")
    metadata = {
        "node_id": node_id,
        "scenario": file.removeprefix("scenarios/").removesuffix(".yaml"),
        "planner": planner,
        "seed": int(seed.removeprefix("seed")),
        "attempt": 1,
        "problem_hash": problem.problem_hash,
        "trajectory_hash": "",
        "outcome": outcome,
        "success": outcome == "success",
        "wall_s": 0.2,
        "setup_ms": 3.0,
        "period_s": problem.dt,
    }
    return Trajectory(columns, metadata, problem)


def make_run(
    scenarios: Sequence[str] = tuple(SCENARIOS),
    planners: Sequence[str] = ("potential_field", "pd", "fabrics"),
    seeds: int = 6,
    *,
    contended: bool = False,
    warnings: Sequence[str] = (),
    crashed: bool = True,
    rows: int = 240,
) -> ReportData:
    """A run; with `crashed`, the last planner's last trial of the first scenario lost its worker."""
    pushes = {planner: (2.2, 0.0, 1.3, 0.7, 3.0)[index % 5] for index, planner in enumerate(planners)}
    kpis = load_builtin().select()
    trajectories: dict[str, Trajectory] = {}
    records = []
    for scenario in scenarios:
        for seed in range(seeds):
            problem = make_problem(scenario, seed)
            for planner in planners:
                node_id = f"scenarios/{scenario}.yaml::{planner}::seed{seed}"
                trajectories[node_id] = make_trajectory(problem, node_id, pushes[planner], rows)
                values, _ = evaluate_kpis(trajectories[node_id], kpis)
                records.append(_record(scenario, planner, seed, trajectories[node_id], contended) | values)
    if crashed:
        name = f"scenarios/{scenarios[0]}.yaml::{planners[-1]}::seed{seeds - 1}"
        _crash(next(record for record in records if record["node_id"] == name), [kpi.name for kpi in kpis])
        del trajectories[name]
    trials = pd.DataFrame(records)

    def trajectory_of(node_id: str) -> Trajectory:
        if node_id not in trajectories:
            raise RecordingError(f"no trial file of {node_id}")
        return trajectories[node_id]

    return ReportData(
        trials=trials,
        summary=summary_table(trials, kpis),
        comparisons=comparisons_table(trials, kpis),
        aggregates=aggregates_table(trials, kpis),
        kpis=kpis,
        run_info=run_info(scenarios, planners, seeds),
        trajectory_of=trajectory_of,
        warnings=warnings,
        title="20261122T024921Z-74be96",
    )


def _record(scenario: str, planner: str, seed: int, trajectory: Trajectory, contended: bool) -> dict[str, Any]:
    node_id, outcome = trajectory.metadata["node_id"], trajectory.outcome
    messages = {
        "success": "",
        "collision": f"touched {trajectory.columns['clearance_obstacle'][-1]} at t = {trajectory.t[-1]:.2f} s",
        "timeout": f"goal error {trajectory.goal_error('reach')[-1]:.3g} m after 12 s",
    }
    return {
        "node_id": node_id,
        "scenario": scenario,
        "planner": planner,
        "seed": seed,
        "outcome": outcome,
        "success": outcome == "success",
        "failed_criteria": "",
        "steps": len(trajectory) - 1,
        "problem_hash": trajectory.problem.problem_hash,
        "trajectory_hash": f"{seed:064x}",
        "wall_s": 0.2,
        "attempt": 1,
        "timing_contended": contended,
        "duration_s": 12.0,
        "message": messages[outcome],
        "command": f"pytest --lpb-planners={planner} --lpb-seed={seed} 'scenarios/{scenario}.yaml'",
    }


def _crash(record: dict[str, Any], kpis: Sequence[str]) -> None:
    record |= dict.fromkeys(kpis, math.nan)
    record |= {
        "outcome": "worker_crash",
        "success": False,
        "steps": 0,
        "problem_hash": "",
        "message": "worker lost",
    }


def run_info(scenarios: Sequence[str], planners: Sequence[str], seeds: int) -> dict[str, Any]:
    """What run.json holds."""
    return {
        "schema_version": 1,
        "started": "2026-11-22T02:49:21Z",
        "command": ["pytest", f"--lpb-planners={','.join(planners)}", "-n", "2", "scenarios/"],
        "seeds": list(range(seeds)),
        "planners": {
            name: {
                "planner": name,
                "parameters": {"gain": 1.5, "limit": math.inf, "nothing": math.nan},
                "parameters_hash": "ab" * 32,
                "period": 0.1,
                "delay": 0.0,
                "source_hash": "cd" * 32,
            }
            for name in planners
        },
        "scenarios": {name: {"file": f"scenarios/{name}.yaml", "hash": "ef" * 32} for name in scenarios},
        "packages": {"numpy": "2.4.6", "pytest-lpb": "0.1.0"},
        "machine": {
            "cpu": "AMD EPYC",
            "cores": 2,
            "memory_gib": 7.8,
            "system": "Linux 6.1",
            "python": "3.11.9",
        },
        "git": {"commit": "360c25b" + "0" * 33, "dirty": True},
        "workers": 2,
    }
