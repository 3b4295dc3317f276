"""A run of trials in space, recorded and evaluated as runs of the plugin are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.problem.problem import Problem
from pytest_lpb.report.build import report_data
from pytest_lpb.report.data import ReportData
from pytest_lpb.run.evaluation import evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.trial.files import write_trial
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.spatial.entries import Entry, panda_entry, point_entry, problem_of, scenario_entry, write_torus
from tests.report.runs import run_info
from tests.trial.specifications import configuration

PLANNERS = {"pd": {"p": 6.0, "k": 3.0}, "slow": {"p": 1.0, "k": 2.0}}


def reach(link: str, target: Sequence[float], **changes: object) -> Entry:
    return {"name": "reach", "type": "position", "link": link, "target": list(target), "tolerance": 0.1, **changes}


def spatial_problems(folder: Path) -> dict[str, Problem]:
    """Problems by scenario: a ball among shapes, a Panda that hits something, a cart that drives."""
    ring = write_torus(folder / "ring.obj", 0.5, 0.1, 16, 8)
    turned = {"axis": [1, 0, 0], "angle": 0.7}
    shapes: list[Entry] = [
        {"name": "ball", "shape": "sphere", "radius": 0.3, "position": [-1.0, 1.0, 0.5]},
        {"name": "crate", "shape": "box", "size": [0.4, 0.6, 0.8], "position": [1.0, 1.5, 0.0], "orientation": turned},
        {"name": "post", "shape": "cylinder", "radius": 0.2, "length": 1.0, "position": [1.0, -1.5, 0.0]},
        {"name": "beam", "shape": "capsule", "radius": 0.1, "length": 1.0, "trajectory": ["-1", "-1 - 0.3*t", "1"]},
        {"name": "ring", "shape": "mesh", "file": str(ring), "concave": True, "position": [3.0, 0.0, 0.5]},
    ]
    wall: Entry = {"name": "wall", "shape": "box", "size": [0.5, 0.1, 1.0], "position": [0.6, 0.0, 0.5]}
    cart = scenario_entry(
        {"model": "cart", "control": "velocity"}, joint="x", goal=[reach("base", [2.0, 0.5], axes=[0, 1])]
    )
    entries = {
        "point_3d/shapes": point_entry(0.2, shapes, goal=[reach("body", [2.0, 0.0, 1.0])]),
        "panda/wall": panda_entry([wall], goal=[reach("panda_hand", [0.6, -0.4, 0.4])], environment={"duration": 2.0}),
        "cart/drive": cart,
    }
    return {name: problem_of(folder, entry) for name, entry in entries.items()}


def spatial_run(folder: Path, problems: Mapping[str, Problem] | None = None) -> ReportData:
    """A recorded run, read and evaluated again."""
    load_builtin()
    problems = problems or spatial_problems(folder)
    info = run_info(list(problems), list(PLANNERS), 1)
    for name in PLANNERS:
        info["planners"][name]["parameters"] = PLANNERS[name]
    run = RunFolder.create(folder / "run", info)
    for scenario, problem in problems.items():
        for name, parameters in PLANNERS.items():
            planner = configuration("pd", parameters)
            trial = TrialSpecification(
                problem=problem.to_dict(),
                planner=type(planner)(name=name, planner=planner.planner, parameters=parameters),
                scenario=scenario,
                node_id=f"scenarios/{scenario}.yaml::{name}::seed0",
            )
            write_trial(run.path, run_trial(trial))
    return report_data(evaluate(run, ["path_length_m", "clearance_min_m"]))
