"""Trials, planners and runs in Python: the numbers of pytest, and errors for people."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import pytest_lpb
from pytest_lpb import LpbError, Planner, Trajectory, evaluate, load_planner, load_run, load_scenario, run_trial
from pytest_lpb.cli import main
from pytest_lpb.errors import ConfigurationError, RecordingError, ScenarioError
from pytest_lpb.library.evaluate import registered_kpis
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.scenario.draw import draw_problem
from tests.plugin.projects import DRAWN, SCENARIO, Project, read_table

PLANNER = """
from dataclasses import dataclass
import numpy as np
from pytest_lpb import Planner

class Mine(Planner):
    name = "mine"

    @dataclass(frozen=True)
    class Parameters:
        gain: float = 1.0

    def setup(self, problem):
        self.noise = np.random.default_rng(problem.seed).normal(size=problem.robot.n_actions)

    def compute_action(self, observation):
        self.diagnostics["distance"] = float(np.hypot(*(observation["goal_position"] - observation["q"])))
        return self.parameters.gain * (observation["goal_position"] - observation["q"]) - observation["qd"] + self.noise
"""


class Given(Planner):
    @dataclass(frozen=True)
    class Parameters:
        gain: float = 1.0  # [1/s^2]

    closed = 0

    def compute_action(self, observation: Any) -> Any:
        return self.parameters.gain * (observation["goal_position"] - observation["q"]) - observation["qd"]

    def close(self) -> None:
        self.closed += 1


@pytest.fixture
def repository(project: Project, monkeypatch: pytest.MonkeyPatch) -> Iterator[Project]:
    monkeypatch.chdir(project.path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    project.ini()
    project.scenario("scenarios/point/near.yaml", DRAWN)
    project.write("my_library_planner.py", PLANNER)
    project.write("planners/mine.yaml", "planner: my_library_planner:Mine\nparameters: {gain: 2.0}\n")
    yield project
    sys.modules.pop("my_library_planner", None)


def test_the_same_numbers_as_in_pytest(repository: Project) -> None:
    repository.run("--lpb-trials=2", "--lpb-assert=none", planners="mine", fast=False)
    run = load_run("reports/latest")
    timing = {entry.name for entry in registered_kpis() if entry.timing}
    table = read_table(run.path / "trials.csv")
    assert [row["node_id"] for row in table] == run.trials["node_id"].tolist()
    for row in table:
        recorded = run.trajectory(row["node_id"])
        alone = run_trial("scenarios/point/near.yaml", "planners/mine.yaml", int(row["seed"]))
        assert alone.metadata["trajectory_hash"] == row["trajectory_hash"]
        assert alone.metadata["problem_hash"] == row["problem_hash"]
        same = ("node_id", "scenario", "planner", "seed", "outcome", "message", "parameters", "parameters_hash")
        assert {key: alone.metadata[key] for key in same} == {key: recorded.metadata[key] for key in same}
        np.testing.assert_array_equal(alone.planner("distance"), recorded.planner("distance"))
        assert alone.problem.to_dict() == recorded.problem.to_dict()
        values, expected = evaluate(alone), evaluate(recorded)
        assert list(values) == [name for name in row if name in values]
        for name, value in expected.items():
            assert float(row[name] or "nan") == pytest.approx(value, rel=1e-9, abs=1e-12, nan_ok=True), name
            if name not in timing:
                np.testing.assert_equal(values[name], value, name)
    assert len(list(run.trajectories())) == len(table) == 2
    assert repr(run) == f"<Run {run.path}>"
    (command,) = {alone.metadata["command"]}
    assert command == "pytest --lpb-planners=planners/mine.yaml --lpb-seed=1 --lpb-trials=1 scenarios/point/near.yaml"
    repository.run(*command.split()[1:], planners=None)
    assert load_run("reports/latest").trials["trajectory_hash"].tolist() == [alone.metadata["trajectory_hash"]]


def hash_of(trajectory: Trajectory) -> tuple[str, str]:
    return trajectory.metadata["trajectory_hash"], trajectory.metadata["parameters_hash"]


def test_scenarios_and_planners_in_every_form(repository: Project) -> None:
    path = Path("scenarios/point/near.yaml")
    expected = hash_of(run_trial(path, "mine", 1))
    scenario = load_scenario(path)
    configuration = load_planner("planners/mine.yaml")
    assert (configuration.name, configuration.parameters) == ("mine", {"gain": 2.0})
    assert hash_of(run_trial(str(path), "mine", np.int64(1))) == expected  # type: ignore[arg-type] # an index is a number
    assert hash_of(run_trial(scenario, configuration, 1)) == expected
    assert hash_of(run_trial(draw_problem(scenario, 1, (), "point/near"), Path("planners/mine.yaml"))) == expected
    cls: Any = type(configuration.build())
    two = {"gain": 2.0}
    for planner in (
        cls(cls.Parameters(gain=2.0)),
        load_planner(cls, two),
        load_planner("my_library_planner:Mine", two),
    ):
        again = run_trial(scenario, planner, 1)
        assert hash_of(again) == expected
        assert again.metadata["planner"] == "mine"
    assert run_trial(scenario, "other=planners/mine.yaml").metadata["planner"] == "other"
    assert hash_of(run_trial(scenario, cls, 1)) != expected
    assert run_trial(scenario, "mine").metadata["seed"] == scenario.seed


def test_an_instance_stays_open_and_a_class_needs_no_module(repository: Project) -> None:
    given = Given(Given.Parameters(gain=3.0))
    first, second = (run_trial("scenarios/point/near.yaml", given, seed) for seed in (0, 1))
    assert given.closed == 0
    assert first.metadata["parameters"] == {"gain": 3.0}
    assert (first.metadata["planner"], second.metadata["command"]) == ("Given", "")

    class Local(Given):
        def compute_action(self, observation: Any) -> Any:
            raise ZeroDivisionError("of a planner")

    failed = run_trial("scenarios/point/near.yaml", Local)
    assert failed.outcome == "planner_error"
    assert "ZeroDivisionError: of a planner" in failed.metadata["message"]


def test_nothing_is_written_unless_asked(repository: Project) -> None:
    before = sorted(repository.path.rglob("*"))
    run_trial("scenarios/point/near.yaml", Given)
    assert sorted(path for path in repository.path.rglob("*") if path.suffix != ".pyc") == before


def test_a_folder_of_trials_is_a_run(repository: Project) -> None:
    trials = [
        run_trial("scenarios/point/near.yaml", planner, seed, folder="mine")
        for planner in (Given(Given.Parameters(gain=3.0)), "pd")
        for seed in (0, 1)
    ]
    run_trial(draw_problem(load_scenario("scenarios/point/near.yaml"), 5), "pd", folder="mine")
    run = load_run("mine")
    assert run.trials["node_id"].tolist()[-4:] == [trial.metadata["node_id"] for trial in trials]
    assert len(run.trials) == 5
    assert set(run.info["planners"]) == {"Given", "pd"}
    assert run.info["planners"]["Given"]["parameters"] == {"gain": 3.0}
    assert not (repository.path / "latest").exists()
    again = run_trial(run.path / "trials/point/near/pd/seed1.yaml", "pd")
    assert hash_of(again) == hash_of(trials[3])
    assert main(["mine", "--trial", trials[0].metadata["node_id"]]) == 0
    with pytest.raises(RecordingError, match=r"mine holds trials of 'Given' with other parameters; give the planner"):
        run_trial("scenarios/point/near.yaml", Given, folder="mine")
    repository.scenario("scenarios/point/near.yaml", SCENARIO)
    with pytest.raises(RecordingError, match="holds another problem of this seed"):
        run_trial("scenarios/point/near.yaml", "pd", 0, folder="mine")
    with pytest.raises(RecordingError, match=r"is there and is no run folder: it has no run\.json"):
        run_trial("scenarios/point/near.yaml", "pd", folder="planners")
    assert len(load_run("mine").trials) == 5


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"scenario": "nowhere.yaml"}, r"nowhere\.yaml:1: cannot be read"),
    ({"scenario": 3}, "scenario: found 3; allowed: the path of a scenario file"),
    ({"planner": None}, "planner: missing; give a name"),
    ({"planner": "mien"}, r"unknown planner 'mien'; did you mean 'mine'\?"),
    ({"planner": "nowhere:Mine"}, "cannot import 'nowhere'"),
    ({"planner": object()}, "planner: found <object object .*>; allowed: a name such as 'pd'"),
    ({"seed": -1}, "seed: found -1; allowed: a whole number from 0"),
    ({"seed": True}, "seed: found True"),
    ({"seed": 1.0}, r"seed: found 1\.0"),
    ({"seed": "1"}, "seed: found '1'"),
    ({"draw": ["goals"]}, r"draw: found 'goals'; did you mean 'goal'\?; allowed: goal, obstacles, start"),
]


@pytest.mark.parametrize(("changes", "message"), WRONG)
def test_wrong_arguments(repository: Project, changes: dict[str, Any], message: str) -> None:
    arguments = {"scenario": "scenarios/point/near.yaml", "planner": "mine", "seed": 0, **changes}
    with pytest.raises(LpbError, match=message):
        run_trial(**arguments)


def test_wrong_files_and_parameters(repository: Project) -> None:
    scenario = repository.scenario("scenarios/bad.yaml", SCENARIO.replace("hold_time: 0.2", "path_lenght_m: '< 3'"))
    with pytest.raises(ScenarioError, match=r"bad\.yaml:8: success: unknown KPI 'path_lenght_m'; did you mean"):
        run_trial(scenario, "mine")
    blocked = repository.scenario(
        "scenarios/blocked.yaml", SCENARIO + "obstacles: [{shape: circle, radius: 1, position: [0, 0]}]\n"
    )
    with pytest.raises(ScenarioError, match=r"blocked\.yaml:5: start: the start is in collision"):
        run_trial(blocked, "mine")
    with pytest.raises(ConfigurationError, match=r"planner 'mine': parameters: gian: .*did you mean 'gain'"):
        load_planner("mine", {"gian": 1.0})
    with pytest.raises(ConfigurationError, match="an instance has its parameters already"):
        load_planner(Given(), {"gain": 1.0})
    unset = Given()
    unset.parameters = None
    with pytest.raises(ConfigurationError, match=r"parameters: found None; an instance of Given\.Parameters"):
        load_planner(unset)
    with pytest.raises(LpbError, match="this problem is that of seed 0; only a scenario has others"):
        run_trial(draw_problem(load_scenario("scenarios/point/near.yaml"), 0), "mine", 1)


def test_runs_that_are_none_and_kpis(repository: Project) -> None:
    with pytest.raises(RecordingError, match=r"reports is no run folder: it has no run\.json"):
        load_run("reports")
    trajectory = run_trial("scenarios/point/near.yaml", "mine", folder="run")
    run = load_run("run", kpis=["path_length_m"])
    assert isinstance(run.trials, pd.DataFrame)
    assert {"path_length_m", "spl"} & set(run.trials.columns) == {"path_length_m"}
    assert evaluate(trajectory, ["path_length_m"]) == {"path_length_m": run.trials["path_length_m"][0]}
    with pytest.raises(LpbError, match=r"unknown KPI 'path_lenght_m'; did you mean 'path_length_m'"):
        evaluate(trajectory, ["path_lenght_m"])
    with pytest.raises(LpbError, match=r"unknown KPI 'nothing'"):
        _ = load_run("run", kpis=["nothing"]).trials
    with pytest.raises(LpbError, match=r"no trial 'near::mine::seed0' in this run; did you mean"):
        run.trajectory("near::mine::seed0")
    (file,) = RunFolder.open(run.path).trial_files()
    file.write_bytes(b"nothing")
    with pytest.warns(UserWarning, match=r"seed0\.parquet"):
        assert load_run("run").trials.empty


def test_importing_the_names_stays_light() -> None:
    program = (
        "import sys, pytest_lpb; assert {'run_trial', 'load_planner', 'load_run', 'evaluate'} <= set(dir(pytest_lpb));"
        "print(*[name for name in ('numpy', 'pandas', 'yaml', 'gymnasium') if name in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == ""
    assert pytest_lpb.run_trial is run_trial


def test_planners_beside_the_script_are_found(repository: Project) -> None:
    program = "from pytest_lpb import run_trial; print(run_trial('scenarios/point/near.yaml', 'mine').outcome)"
    script = repository.write("scripts/go.py", program)
    result = subprocess.run([sys.executable, os.fspath(script)], capture_output=True, text=True, cwd=repository.path)
    assert result.stdout.strip() in ("success", "timeout"), result.stderr
