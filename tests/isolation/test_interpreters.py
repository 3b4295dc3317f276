"""Planners in interpreters of their own: a bare virtual environment, other versions of Python."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.settings import isolation_of
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import read_planner
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import POINT, position_goal, problem_entry

MODULE = """\
from dataclasses import dataclass

import numpy as np

from pytest_lpb import Infeasible, Planner, Preview


class Towards(Planner):
    name = "towards"

    @dataclass(frozen=True)
    class Parameters:
        gain: float = 1.0
        steps: int = 2

    @classmethod
    def preview_for(cls, parameters):
        return Preview(steps=parameters.steps, step_s=0.1)

    def setup(self, problem):
        assert problem.name == "family" and problem.control == "acceleration" and problem.dimension == 2
        assert problem.goal[0].link == "body" and problem.robot.limits.velocity.shape == (2, 2)
        self.robot = problem.robot
        hash(problem.structure)

    def compute_action(self, observation):
        seen = observation["goal_reach_preview"].shape[0]
        if observation["t"] > 0.9:
            raise Infeasible("far enough")
        self.diagnostics = {"seen": seen, "numpy": int(np.__version__.split(".")[0])}
        return self.parameters.gain * (observation["goal_position"] - observation["q"])


class Kinematic(Towards):
    name = "kinematic"

    def compute_action(self, observation):
        return observation["goal_position"] - self.robot.forward_kinematics(observation["q"], "body")[:2, 2]
"""


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An interpreter that has NumPy and nothing else: neither our package nor what it needs."""
    folder = tmp_path_factory.mktemp("bare")
    venv.create(folder / "venv", symlinks=True)
    packages = next((folder / "venv" / "lib").glob("python*/site-packages"))
    for part in ("numpy", "numpy.libs"):
        source = Path(np.__file__).parents[1] / part
        if source.exists():
            (packages / part).symlink_to(source)
    return folder / "venv" / "bin" / "python"


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a planner module, where this interpreter finds it too."""
    (tmp_path / "towards_planner.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def configured(python: Path | str, cls: str = "Towards", **keywords: Any) -> PlannerConfiguration:
    isolation = isolation_of({"python": str(python), "setup_deadline_s": 60.0}, Path.cwd())
    return PlannerConfiguration("it", f"towards_planner:{cls}", isolation=isolation, **keywords)


def run(configuration: PlannerConfiguration, **problem: Any) -> Trajectory:
    entry = problem_entry(goal=[position_goal([4.0, 0.2])], **problem)
    return run_trial(TrialSpecification(problem=entry, planner=configuration, scenario="family"))


def test_nothing_of_ours_is_needed_there(bare: Path, module: Path) -> None:
    trajectory = run(configured(bare, parameters={"gain": 2.0}, per_robot={"point": {"steps": 5}}))
    assert trajectory.metadata["message"].startswith("infeasible at t = 0.95 s: far enough")
    assert trajectory.metadata["parameters"] == {"gain": 2.0, "steps": 5}
    assert trajectory.action[0].tolist() == [8.0, 0.4]
    assert trajectory.planner("seen")[0] == 5.0
    assert "towards_planner" not in sys.modules


def test_robots_compute_their_kinematics_there(bare: Path, module: Path) -> None:
    assert run(configured(bare, "Kinematic")).action[0].tolist() == [4.0, 0.2]


def test_what_run_json_says_of_it(bare: Path, module: Path) -> None:
    about = configured(bare).to_dict()
    assert about["runs"] == {"python": ".".join(map(str, sys.version_info[:3])), "numpy": np.__version__}
    assert about["parameters"] == {"gain": 1.0, "steps": 2}
    assert len(about["source_hash"]) == 64
    (module / "towards_planner.py").write_text(MODULE + "# changed\n")
    assert configured(bare).source_hash != about["source_hash"]


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"parameters": {"gian": 1.0}}, "parameters: gian: unknown parameter; did you mean 'gain'?; Towards has gain"),
        ({"parameters": {"gain": "much"}}, "gain: found 'much'; its type is float"),
        ({"per_robot": {"point": {"steps": 1.5}}}, "per_robot: point: steps: found 1.5; its type is int"),
    ],
)
def test_wrong_parameters_are_found_before_any_trial(
    bare: Path, module: Path, keywords: dict[str, Any], message: str
) -> None:
    with pytest.raises(ConfigurationError) as caught:
        configured(bare, **keywords).check()
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("cls", "message"),
    [("Nobody", "module 'towards_planner' has no attribute 'Nobody'"), ("np", "not a subclass of pytest_lpb.Planner")],
)
def test_classes_that_are_not_there(bare: Path, module: Path, cls: str, message: str) -> None:
    with pytest.raises(ConfigurationError, match="cannot be had from") as caught:
        configured(bare, cls).check()
    assert message in str(caught.value)


def test_classes_that_are_not_there_have_their_line(bare: Path, module: Path) -> None:
    path = module / "mine.yaml"
    path.write_text(f"python: {bare}\nplanner: towards_planner:Nobody\n")
    with pytest.raises(ConfigurationError) as caught:
        read_planner(path, "mine").check()
    assert str(caught.value).startswith(f"{path}:2: planner: 'towards_planner:Nobody' cannot be had from {bare}: Attr")


@pytest.mark.parametrize(
    ("python", "message"),
    [
        ("/no/such/python", "no program that can be run"),
        ("/bin/false", r"did not start as a Python interpreter \(exit code 1\)"),
    ],
)
def test_interpreters_that_are_none(python: str, message: str, module: Path) -> None:
    with pytest.raises(ConfigurationError, match=message):
        configured(python).check()


def test_an_interpreter_that_is_too_old(tmp_path: Path, module: Path) -> None:
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\necho 3 7\n")
    program.chmod(0o755)
    with pytest.raises(ConfigurationError, match=r"is Python 3\.7; 3\.8 or newer is needed"):
        configured(program).check()


def test_an_interpreter_without_numpy(tmp_path: Path, module: Path) -> None:
    venv.create(tmp_path / "empty", symlinks=True)
    with pytest.raises(ConfigurationError, match=r"has no NumPy, which is needed there \(missing: No module named"):
        configured(tmp_path / "empty" / "bin" / "python").check()


def old_pythons() -> list[str]:
    """Interpreters older than ours needs, as far as there are any with NumPy."""
    folders = [*os.environ.get("LPB_TEST_PYTHONS", "").split(os.pathsep), "/usr/bin"]
    names = ["python3.8", "python3.9", "python3.10"]
    found = [str(Path(folder, name)) for folder in folders if folder for name in names if Path(folder, name).is_file()]
    found += [folder for folder in folders if Path(folder).is_file()]
    return [
        path
        for path in found
        if subprocess.run([path, "-c", "import numpy"], capture_output=True, check=False).returncode == 0
    ]


@pytest.mark.parametrize("cls", ["Towards", "Kinematic"])
def test_older_interpreters(cls: str, module: Path) -> None:
    pythons = old_pythons()
    if not pythons:
        pytest.skip("no Python 3.8 to 3.10 with NumPy; name some in LPB_TEST_PYTHONS")
    for python in pythons:
        trajectory = run(configured(python, cls))
        if trajectory.metadata["message"].startswith("planner error"):
            # Ours needs 3.10 at least: only the planner that asks for kinematics notices.
            assert cls == "Kinematic"
            assert (
                "problem.robot.forward_kinematics cannot be computed here: this is Python 3."
                in (trajectory.metadata["message"])
            )
        else:
            assert trajectory.action[0].tolist() == [4.0, 0.2]


def test_a_described_robot_says_what_it_cannot(bare: Path, module: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The stand-in, in this process: attributes are there, kinematics are not."""
    from pytest_lpb.isolation.far.stand_in import PlannerProblem
    from pytest_lpb.planner import base
    from pytest_lpb.planner.elsewhere import robot_description
    from pytest_lpb.problem.problem import Problem

    entry = problem_entry(robot={**POINT, "limits": {"velocity": [[-1.0, 1.0], None]}})
    real = base.PlannerProblem.of(Problem.from_dict(entry, "x"), 0.05)
    told: Any = PlannerProblem(real.to_dict(), robot_description(real.robot), "it is too old")
    for name in ("name", "dof", "n_actions", "joint_names", "link_names", "base", "body_radius", "urdf_path"):
        assert getattr(told.robot, name) == getattr(real.robot, name)
    np.testing.assert_array_equal(told.robot.limits.velocity, real.robot.limits.velocity)
    assert told.robot.collision_bodies[0].capsules == real.robot.collision_bodies[0].capsules
    assert (told.dt, told.period, told.control, told.dimension) == (real.dt, real.period, real.control, real.dimension)
    with pytest.raises(NotImplementedError, match=r"problem\.robot\.jacobian cannot be computed here: it is too old"):
        told.robot.jacobian([0.0, 0.0], "body")
    with pytest.raises(AttributeError, match="has no attribute 'colour'"):
        told.robot.colour  # noqa: B018
