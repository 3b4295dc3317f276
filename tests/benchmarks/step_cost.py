"""CPU time of a step of the environment, of two installations in turn, so that a busy machine treats both alike:

    python tests/benchmarks/step_cost.py OTHER/bin/python [ROUNDS]

Run without arguments it prints the microseconds per step of its own interpreter's pytest_lpb.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from math import sin
from pathlib import Path
from statistics import median
from time import process_time_ns
from typing import Any

STEPS, REPEATS = 200, 12
SPHERES = [[0.7, 0.3, 0.6], [-0.5, 0.3, 0.2], [0.2, 0.8, 0.5], [0.5, -0.5, 0.8], [0.0, 0.5, 1.2]]
SETTINGS = {"dt": 0.01, "duration": 100.0, "end_at": []}
ALL: dict[str, dict[str, Any]] = {
    "point": {
        "robot": {"model": "point", "body_radius": 0.2},
        "environment": SETTINGS,
        "start": {"q": [0.0, 0.0]},
        "goal": [{"name": "reach", "type": "position", "link": "body", "target": [4.0, 0.2], "tolerance": 0.1}],
        "obstacles": [
            {"name": f"o{i}", "shape": "circle", "radius": 1.0, "position": [2.0, y]} for i, y in enumerate([1.5, -1.8])
        ],
    },
    "seven-link arm": {
        "robot": {"model": "planar_arm", "links": [0.5] * 7, "body_radius": 0.05},
        "environment": SETTINGS,
        "start": {"q": [0.3] * 7},
        "goal": [{"name": "reach", "type": "position", "link": "end", "target": [1.0, 2.0], "tolerance": 0.1}],
        "obstacles": [
            {"name": f"o{i}", "shape": "circle", "radius": 0.3, "position": [3.0 * sin(i) - 3.0, 3.0 * sin(i + 1.6)]}
            for i in range(10)
        ],
    },
    "panda among five spheres": {
        "robot": {"model": "panda"},
        "environment": {**SETTINGS, "engine": "pybullet"},
        "start": {"q": [1.0, 0.0, 0.0, -1.5, 0.0, 1.8675, 0.0]},
        "goal": [
            {"name": "reach", "type": "position", "link": "panda_link8", "target": [0.4, 0.2, 0.5], "tolerance": 0.01}
        ],
        "obstacles": [
            {"name": f"o{i}", "shape": "sphere", "radius": 0.1, "position": p} for i, p in enumerate(SPHERES)
        ],
    },
}


def microseconds() -> dict[str, float]:
    """The least CPU time per step of `REPEATS` courses of `STEPS` steps, by robot [us]."""
    from pytest_lpb.environment.environment import ScenarioEnvironment

    found = {}
    for name, scenario in ALL.items():
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scenario.yaml"
            path.write_text(json.dumps({"version": 1, **scenario}), encoding="utf-8")
            environment = ScenarioEnvironment(path, reuse_observations=True)
        count = environment.problem.robot.n_actions
        actions = [[0.5 * sin(0.03 * k + 1.5 * joint) for joint in range(count)] for k in range(STEPS)]
        times = []
        for _ in range(REPEATS):
            environment.reset(seed=0)
            started = process_time_ns()
            for action in actions:
                environment.step(action)
            times.append((process_time_ns() - started) / STEPS / 1e3)
        environment.close()
        found[name] = min(times)
    return found


def compare(other: str, rounds: int) -> None:
    """Measure both interpreters in turn, and print medians and their ratio."""
    measured: dict[str, list[dict[str, float]]] = {other: [], sys.executable: []}
    for _ in range(rounds):
        for interpreter, results in measured.items():
            # Not from this folder: each imports what is installed for it.
            done = subprocess.run(
                [interpreter, __file__], capture_output=True, text=True, check=True, cwd=tempfile.gettempdir()
            )
            results.append(json.loads(done.stdout))
    for name in ALL:
        before, after = (median(result[name] for result in results) for results in measured.values())
        print(f"{name}: {before:.1f} us before, {after:.1f} us after, ratio {after / before:.3f}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        compare(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 15)
    else:
        print(json.dumps(microseconds()))
