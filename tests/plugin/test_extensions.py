"""Engines, robots, shapes and types of sub-goals of users: in conftest.py, and of installed packages."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pytest_lpb import (
    LpbError,
    load_run,
    load_scenario,
    register_engine,
    register_goal,
    register_robot,
    register_shape,
    register_urdf,
    run_trial,
)
from pytest_lpb.cli import main
from pytest_lpb.environment.engine import ENGINES
from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.planar import PlanarEngine
from pytest_lpb.errors import ConfigurationError
from pytest_lpb.problem import registries
from pytest_lpb.problem.goal import GOAL_TYPES, SubGoal
from pytest_lpb.problem.planar.point import Point
from pytest_lpb.problem.planar.shapes import SHAPES
from pytest_lpb.problem.robot import ROBOT_MODELS
from pytest_lpb.problem.spatial.generated import GENERATED
from pytest_lpb.problem.spatial.library import BUILT_IN
from pytest_lpb.problem.spatial.shapes import BULLET_SHAPES
from pytest_lpb.scenario.json_schema import schema_text
from tests.plugin.projects import Project, read_run

# One of each. Distances are those of a disc and of the convex hull of four points.
EXTENSIONS = '''
from math import hypot

import numpy as np

from pytest_lpb import Planner, register_engine, register_goal, register_robot, register_shape, register_urdf
from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.planar import PlanarEngine
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.planar.geometry import point_to_segment
from pytest_lpb.problem.planar.point import Point


@register_engine("gusty", dimension=2)
class Gusty(PlanarEngine):
    """The planar engine with a constant wind along y."""

    def advance(self, action):
        super().advance([action[0], action[1] + 0.1])


@register_robot("heavy", body_radius=0.1, keys={"mass": (float, 2.0)})
class Heavy(Point):
    """A point with a mass [kg]: actions are forces."""

    def integrate(self, q, u, action, dt):
        return super().integrate(q, u, [value / self.entry["mass"] for value in action], dt)


register_urdf("slider", "slider.urdf")


@register_shape("tree", dimension=2, keys={"trunk": float, "rings": (int, 3)})
class Tree:
    """A disc."""

    def __init__(self, entry):
        self.circumradius = entry["trunk"]
        self.place(0.0, 0.0, 0.0)

    def place(self, x, y, angle):
        self.x, self.y = x, y

    def distance_to_segment(self, ax, ay, bx, by):
        point = (ax, ay) == (bx, by)
        distance = hypot(ax - self.x, ay - self.y) if point else point_to_segment(self.x, self.y, ax, ay, bx, by)
        return distance - self.circumradius


@register_shape("wedge", dimension=3, keys={"height": float})
class Wedge:
    """A tetrahedron that stands on its position."""

    def __init__(self, entry):
        self.vertices = np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0, 0.1, 0], [0, 0, entry["height"]]])


@register_goal("along_x", size=1, keys={"link": str})
class AlongX(SubGoal):
    """A link's x [m]."""

    unit = "m"

    def __init__(self, entry, robot):
        super().__init__(entry, robot)
        self._index = robot.link_index(entry["link"])

    def value(self, q, frames):
        return [frames[self._index][0]]

    def distance(self, value, target):
        return abs(value[0] - target[0])


class Pusher(Planner):
    name = "pusher"

    def setup(self, problem):
        self.told = [item.parameters for item in problem.obstacles]

    def compute_action(self, observation):
        action = np.zeros_like(observation["u"])
        action[0] = 4.0 * (observation["goal_position"][0] - observation["q"][0]) - 4.0 * observation["u"][0]
        return action
'''
MODULE = "lpb_extensions_of_a_test"
PLANAR = """\
version: 1
robot: {model: heavy, mass: 1.5}
environment: {engine: gusty, duration: 4.0}
goal: [{name: there, type: along_x, link: body, target: [0.5], tolerance: 0.05}]
obstacles: [{name: oak, shape: tree, trunk: 0.25, position: [0.5, -1.0]}]
randomize:
  draw: [obstacles]
  obstacles: {count: 1, shape: tree, trunk: [0.1, 0.3], rings: 5, position: [[2, 3], [2, 3]]}
"""
SPATIAL = """\
version: 1
robot: {model: slider, limits: {position: [[-1, 1]]}}
environment: {engine: pybullet, duration: 4.0}
goal: [{name: there, type: along_x, link: carriage, target: [0.5], tolerance: 0.05}]
obstacles: [{name: ramp, shape: wedge, height: 0.3, position: [0.5, 0, -1.0]}]
"""
SLIDER = """<robot name="slider"><link name="rail"/><link name="carriage">
<collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="carriage"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="10" velocity="1"/></joint></robot>
"""


@pytest.fixture
def extended(project: Project, monkeypatch: pytest.MonkeyPatch) -> Iterator[Project]:
    monkeypatch.chdir(project.path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(registries._state, "loaded", False)
    project.ini()
    project.scenario("scenarios/planar.yaml", PLANAR)
    project.scenario("scenarios/spatial.yaml", SPATIAL)
    yield project
    for name in ("conftest", MODULE):
        sys.modules.pop(name, None)


def install(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package as pip leaves it: a module, and entry points in its metadata."""
    folder = project.path / "site"
    project.write(f"site/{MODULE}.py", EXTENSIONS)
    project.write("site/slider.urdf", SLIDER)
    project.write(
        "site/lpb_extensions-1.dist-info/METADATA", "Metadata-Version: 2.1\nName: lpb-extensions\nVersion: 1\n"
    )
    of = {"engines": "Gusty", "robots": "Heavy", "shapes": "Tree", "goals": "AlongX", "planners": "Pusher"}
    points = [f"[pytest_lpb.{group}]\npusher = {MODULE}:{name}\n" for group, name in of.items()]
    project.write("site/lpb_extensions-1.dist-info/entry_points.txt", "\n".join(points))
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("PYTHONPATH", str(folder))


def check_run(project: Project, module: str) -> None:
    """Trials, their clearances, what the run recorded, the report, and the recorded problems again."""
    run = load_run("reports/latest")
    assert run.trials["outcome"].tolist() == ["success"] * 2
    planar, spatial = (run.trajectory(f"scenarios/{name}.yaml::pusher::seed0") for name in ("planar", "spatial"))
    drawn = planar.problem.obstacles[-1]
    assert drawn.parameters == {"trunk": pytest.approx(0.2, abs=0.1), "rings": 5}
    # The disc of 0.25 m around (0.5, -1), the body's of 0.1 m; the tip at z = -0.7, the carriage's sphere of 0.1 m.
    centre = planar.link("body")[:, :2] - planar.obstacle("oak")[:, :2]
    assert planar.clearance[0] == pytest.approx(np.hypot(*centre[0]) - 0.35)
    assert planar.qd[-1, 1] == pytest.approx(0.1 / 1.5 * planar.t[-1])  # the wind, on a mass
    tip = spatial.link("carriage") - (0.5, 0.0, -0.7)
    assert spatial.clearance.min() == pytest.approx(np.linalg.norm(tip, axis=1).min() - 0.1, abs=1e-6)
    assert [entry["module"] for entry in read_run(run.path)["plugins"]] == [module]
    html = (run.path / "report.html").read_text("utf-8")
    assert all(name in html for name in ("planar", "spatial", "drawn0"))
    for trajectory in (planar, spatial):
        path = run.path / f"trials/{trajectory.metadata['scenario']}/pusher/seed0.yaml"
        again = run_trial(path, "planners/pusher.yaml")
        assert again.metadata["trajectory_hash"] == trajectory.metadata["trajectory_hash"]
        seen = ScenarioEnvironment(path).reset()[0]["obstacle_size"]
        expected = [[0.5, 0.5], [2 * drawn.parameters["trunk"]] * 2] if trajectory is planar else [[0.2, 0.2, 0.6]]
        np.testing.assert_allclose(seen[:2], expected)


def test_those_of_a_conftest_with_workers(extended: Project) -> None:
    extended.write("conftest.py", EXTENSIONS)
    extended.write("slider.urdf", SLIDER)
    extended.write("planners/pusher.yaml", "planner: conftest:Pusher\n")
    extended.run_workers(planners="pusher").assert_outcomes(passed=2)
    check_run(extended, "conftest")


def test_those_of_an_installed_package(extended: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    install(extended, monkeypatch)
    extended.write("planners/pusher.yaml", f"planner: {MODULE}:Pusher\n")
    extended.run(planners="pusher").assert_outcomes(passed=2)
    check_run(extended, MODULE)
    # Each process that reads such a run finds them by itself.
    assert main(["reports/latest", "--trial", "scenarios/spatial.yaml::pusher::seed0"]) == 0
    schema = schema_text()
    assert all(f'"{name}"' in schema for name in ("gusty", "mass", "tree", "trunk", "wedge", "along_x"))
    check_messages(extended)
    check_built_in_planners(extended)


WRONG = [
    (
        "shape: tree, trunk: 0.25",
        "shape: tere, trunk: 1",
        r"planar.yaml:5: obstacles\[0\]: shape: .*'tree'.*tree, wedge",
    ),
    ("trunk: [0.1, 0.3]", "trnuk: [1, 2]", r"planar.yaml:8: randomize.*trnuk: unknown key; did you mean 'trunk'\?"),
    ("trunk: 0.25, ", "", r"planar.yaml:5: obstacles\[0\]\.trunk: is missing"),
    ("type: along_x", "type: along", r"planar.yaml:4: goal\[0\]: type: found .*'along_x'"),
    ("link: body", "link: boyd", r"planar.yaml:4: goal\[0\]\.link: unknown link 'boyd'; did you mean 'body'"),
    ("target: [0.5]", "target: [0.5, 1]", r"planar.yaml:4: goal\[0\]\.target: found 2 coordinates.* required 1"),
    ("model: heavy", "model: haevy", r"planar.yaml:2: robot\.model: unknown 'haevy'; did you mean 'heavy'"),
    ("mass: 1.5", "mass: big", r"planar.yaml:2: robot\.mass: found .*; a number is required"),
    ("model: heavy", "model: point", r"planar.yaml:2: robot\.mass: has no meaning for the model point"),
    ("engine: gusty", "engine: gutsy", r"planar.yaml:3: environment\.engine: .*did you mean 'gusty'"),
    ("engine: gusty", "engine: gusty, dynamics: true", r"planar.yaml:3: .*dynamics: true is not available .* gusty"),
    ("shape: tree, trunk: 0.25", "shape: wedge, height: 1", r"planar.yaml:5: .*wedge is not available .*engine gusty"),
]


def check_messages(project: Project) -> None:
    """Did you mean, line by line, as for built-in ones."""
    for before, after, message in WRONG:
        assert before in PLANAR
        path = project.scenario("scenarios/planar.yaml", PLANAR.replace(before, after, 1))
        with pytest.raises(LpbError, match=message):
            load_scenario(path)
    project.scenario("scenarios/planar.yaml", PLANAR)


def check_built_in_planners(project: Project) -> None:
    """They say what they do not know; `pd`, which ignores obstacles, minds sub-goals only."""
    for planner in ("pd", "mpc"):
        trial = run_trial("scenarios/planar.yaml", planner)
        assert trial.outcome == "planner_error"
        assert f"{planner} has no law for sub-goals of type 'along_x'; it has alignment" in trial.metadata["message"]
    goal = "{name: there, type: position, link: body, target: [0.5, 0], tolerance: 0.05}"
    path = project.scenario("scenarios/a.yaml", PLANAR.replace(PLANAR.splitlines()[3], f"goal: [{goal}]"))
    assert run_trial(path, "pd").outcome != "planner_error"
    message = run_trial(path, "potential_field").metadata["message"]
    assert "potential_field knows no distance to obstacles of shape 'tree'; it has circle, rectangle" in message


def test_the_names_of_what_is_built_in() -> None:
    assert set(registries.ENGINES) == set(ENGINES)
    assert set(registries.ROBOTS) == {*ROBOT_MODELS, *GENERATED, *BUILT_IN}
    assert {2: tuple(SHAPES), 3: (*BULLET_SHAPES, "mesh")} == registries.SHAPES
    assert {(dimension, name) for dimension in (2, 3) for name in registries.GOALS} == set(GOAL_TYPES)


def test_names_that_are_taken(tmp_path: Path) -> None:
    with registries.preserved():
        for register, name in (
            (register_engine("planar", dimension=2), "engine 'planar'"),
            (register_robot("panda"), "robot 'panda'"),
            (register_shape("box", dimension=3, keys={}), "shape 'box'"),
            (register_goal("joint", size=1), "goal type 'joint'"),
        ):
            with pytest.raises(ConfigurationError, match=f"{name} is built in; choose another name .*test_extensions"):
                register(Point)
        register_shape("mine", dimension=2, keys={})(Point)
        register_shape("mine", dimension=2, keys={})(Point)  # a module imported again
        with pytest.raises(ConfigurationError, match=r"shape 'mine' is taken: .* and .* both register it"):
            register_shape("mine", dimension=2, keys={})(PlanarEngine)
        with pytest.raises(ConfigurationError, match="shape 'a b': its name may have letters"):
            register_shape("a b", dimension=2, keys={})(Point)
        with pytest.raises(ConfigurationError, match="shape 'ours': key 'position' is not allowed"):
            register_shape("ours", dimension=2, keys={"position": float})(Point)
        with pytest.raises(ConfigurationError, match="goal type 'ours': dimension: found 4; allowed: 2 or 3"):
            register_goal("ours", size=1, dimension=4)(SubGoal)
        with pytest.raises(ConfigurationError, match=r"robot 'ours': there is no file .*nowhere\.urdf"):
            register_urdf("ours", tmp_path / "nowhere.urdf")
    assert not registries.origins()


def test_an_entry_point_that_cannot_be_loaded(extended: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    install(extended, monkeypatch)
    extended.write(f"site/{MODULE}.py", "1 / 0")
    with pytest.raises(ConfigurationError, match=r"entry point 'pusher' of pytest_lpb\.engines: ZeroDivisionError"):
        load_scenario("scenarios/planar.yaml")
