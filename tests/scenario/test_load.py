"""Loading: defaults, the canonical form and its round trip, the shipped JSON Schema."""

import hashlib
import json
import math
import pickle
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pytest_lpb.documents.reader import read_yaml
from pytest_lpb.documents.recognition import is_study
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.criterion import Criterion
from pytest_lpb.scenario.json_schema import SCHEMA_FILE, scenario_json_schema, schema_text
from pytest_lpb.scenario.load import XFail, load_scenario

SCENARIOS = sorted(path for path in (Path(__file__).parents[2] / "scenarios").rglob("*.yaml") if not is_study(path))

MINIMAL = """\
version: 1
robot: {model: point}
goal: [{type: position, link: body, target: [4, 0.2], tolerance: 0.1}]
"""
FULL = """\
version: 1
description: Planar arm.
tags: [planar, static]
robot:
  model: planar_arm
  links: [0.5, 0.4]
  name: my_arm
  control: velocity
  body_radius: 0.05
  collision: {link_spheres: 0.15}
  limits: {position: [[-3, 3], null], velocity: [[-1, 1], [-2, 2]]}
  self_collision_pairs: [[base, end]]
environment: {dt: 0.1, duration: 12, end_at: [], safety_margin: 0.1, prediction: exact}
start: {q: [0.1, 0.2]}
goal:
  - {type: joint, joints: [joint2], target: [1]}
  - {name: reach, type: position, link: end, trajectory: ["0.5*cos(t)", 0.25], tolerance: 0.1, primary: true}
  - {name: turn, type: orientation, link: link2, target: 0.5, weight: 2}
  - {name: up, type: alignment, link: end, axis: [1, 0], other_axis: [0, 1], tolerance: 0.1}
obstacles:
  - {name: left, shape: circle, radius: 1, position: [3, 0.2]}
  - {shape: rectangle, size: [0.6, 0.4], spline: [[0, 3, 3], [1, 4, 4]], orientation: "0.1*t"}
randomize:
  draw: [obstacles]
  start: {q: [[-1, 1], [-1, 1]]}
  obstacles: {count: 3, shape: circle, position: [[-5, 5], [-5, 5]], radius: 0.5}
  keep_obstacles: false
  margin: 0.1
seed: 7
trials: 10
success: {clearance_min_m: ">=2e-2", time_to_goal_s: " < 20 ", rate: ">= 0.8"}
xfail: {pd: ignores obstacles, mpc: {reason: slow, outcomes: [timeout, deadline], seeds: [3]}}
"""
DRIVE = """\
version: 1
robot: {model: differential_drive}
start: {u: [0.5, 0]}
goal: [{type: position, link: base, spline: [[0, 0, 0], [1, 1, 1], [2, 0, 0]], periodic: true, tolerance: 1}]
success: {hold_time: 1}
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "x.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_default(tmp_path: Path) -> None:
    scenario = load_scenario(written(tmp_path, MINIMAL))
    assert scenario.concrete == {
        "version": 1,
        "description": "",
        "tags": [],
        "robot": {
            "model": "point",
            "name": "point",
            "control": "acceleration",
            "base": "fixed",
            "body_radius": 0.2,
            "collision": "geometry",
            "limits": {"position": None, "velocity": None, "acceleration": None},
            "self_collision_pairs": None,
        },
        "environment": {
            "engine": "planar",
            "dt": 0.05,
            "duration": 25.0,
            "end_at": ["goal", "violation"],
            "safety_margin": 0.05,
            "dynamics": False,
            "gravity": [0.0, 0.0, -9.81],
            "prediction": "constant_velocity",
        },
        "start": {"q": [0.0, 0.0], "qd": [0.0, 0.0]},
        "goal": [
            {
                "name": "goal0",
                "type": "position",
                "link": "body",
                "target": [4.0, 0.2],
                "tolerance": 0.1,
                "weight": 1.0,
                "primary": True,
            }
        ],
        "obstacles": [],
        "seed": 0,
        "trials": 1,
        "success": {"hold_time": 0.5},
    }
    assert (scenario.randomize, scenario.draw, scenario.keep_obstacles, scenario.margin) == (
        {},
        (),
        True,
        0.05,
    )
    assert (scenario.tags, scenario.xfail, scenario.source) == ((), {}, None)


def test_every_part(tmp_path: Path) -> None:
    path = written(tmp_path, FULL)
    scenario = load_scenario(path)
    concrete = scenario.concrete
    assert concrete["robot"]["links"] == [0.5, 0.4]
    assert concrete["robot"]["collision"] == {"link_spheres": 0.15}
    assert concrete["robot"]["limits"] == {
        "position": [[-3.0, 3.0], None],
        "velocity": [[-1.0, 1.0], [-2.0, 2.0]],
        "acceleration": None,
    }
    assert [goal["name"] for goal in concrete["goal"]] == ["goal0", "reach", "turn", "up"]
    assert [goal["primary"] for goal in concrete["goal"]] == [False, True, False, False]
    assert concrete["goal"][1]["trajectory"] == ["0.5*cos(t)", "0.25"]
    assert concrete["goal"][2]["target"] == [0.5]
    assert concrete["goal"][3]["other"] == "world"
    assert "target" not in concrete["goal"][3]
    assert concrete["obstacles"][1] == {
        "name": "obstacle1",
        "shape": "rectangle",
        "size": [0.6, 0.4],
        "spline": [[0.0, 3.0, 3.0], [1.0, 4.0, 4.0]],
        "periodic": False,
        "orientation": "0.1*t",
    }
    assert scenario.randomize == {
        "start": {"q": [[-1.0, 1.0], [-1.0, 1.0]]},
        "obstacles": [
            {
                "count": [3, 3],
                "shape": "circle",
                "position": [[-5.0, 5.0], [-5.0, 5.0]],
                "radius": [0.5, 0.5],
            }
        ],
    }
    assert (scenario.draw, scenario.keep_obstacles, scenario.margin) == (("obstacles",), False, 0.1)
    assert (scenario.seed, scenario.trials, scenario.tags) == (7, 10, ("planar", "static"))
    assert scenario.success.hold_time == "end"
    assert scenario.success.rate == Criterion(">=", 0.8)
    assert scenario.success.criteria == {
        "clearance_min_m": Criterion(">=", 0.02),
        "time_to_goal_s": Criterion("<", 20.0),
    }
    assert concrete["success"] == {
        "hold_time": "end",
        "rate": ">= 0.8",
        "clearance_min_m": ">= 0.02",
        "time_to_goal_s": "< 20.0",
    }
    assert scenario.xfail == {
        "pd": XFail("ignores obstacles", None, None),
        "mpc": XFail("slow", ("timeout", "deadline"), (3,)),
    }
    assert scenario.file_hash == hashlib.sha256(path.read_bytes()).hexdigest()
    assert scenario.line_of(("goal", 1, "trajectory")) == 17
    assert scenario.place(("randomize", "start")) == f"{path}:25"


def test_differential_drive(tmp_path: Path) -> None:
    concrete = load_scenario(written(tmp_path, DRIVE)).concrete
    assert concrete["start"] == {"q": [0.0, 0.0, 0.0], "u": [0.5, 0.0]}
    assert (concrete["robot"]["base"], concrete["robot"]["wheel_base"]) == ("differential_drive", 0.5)
    assert concrete["goal"][0]["periodic"] is True
    assert concrete["success"] == {"hold_time": 1.0}


@pytest.mark.parametrize(("links", "name"), [("3", "planar_arm_3"), ("[0.5]", "planar_arm_1")])
def test_default_name_of_an_arm(tmp_path: Path, links: str, name: str) -> None:
    text = MINIMAL.replace("model: point", f"model: planar_arm, links: {links}").replace("body", "end")
    robot = load_scenario(written(tmp_path, text)).concrete["robot"]
    assert robot["name"] == name
    assert robot["body_radius"] == 0.1
    assert all(isinstance(length, float) for length in robot["links"])


def test_comments_and_marks_leave_the_problem_alone(tmp_path: Path) -> None:
    plain = load_scenario(written(tmp_path, MINIMAL))
    marked = load_scenario(written(tmp_path, MINIMAL + "tags: [a]  # b\nxfail: {pd: c}\ndescription: d\n"))
    assert plain.file_hash != marked.file_hash
    for section in ("robot", "environment", "start", "goal", "obstacles"):
        assert plain.concrete[section] == marked.concrete[section]


def test_a_scenario_survives_pickling(tmp_path: Path) -> None:
    scenario = load_scenario(written(tmp_path, FULL))
    again = pickle.loads(pickle.dumps(scenario))
    assert again == scenario
    assert again.line_of(("trials",)) == scenario.line_of(("trials",)) == 30


def test_paths_in_messages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path, "version: 2\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ScenarioError, match=r"^x\.yaml:1: version: "):
        load_scenario(path)
    monkeypatch.chdir("/")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path.relative_to("/"))
    assert caught.value.faults[0].startswith(f"{str(path)[1:]}:1: version: ")


@pytest.mark.parametrize(
    ("name", "reason"), [("absent.yaml", "No such file or directory"), ("folder", "Is a directory")]
)
def test_unreadable_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, reason: str) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    with pytest.raises(ScenarioError) as caught:
        load_scenario(Path(name))
    assert caught.value.faults == (f"{name}:1: cannot be read: {reason}",)


numbers = st.floats(-100.0, 100.0) | st.integers(-100, 100)
lengths = st.floats(1e-6, 10.0) | st.integers(1, 10)
names = st.from_regex(r"[A-Za-z0-9_-][A-Za-z0-9_.-]{0,11}", fullmatch=True)
points = st.lists(numbers, min_size=2, max_size=2)
constants = st.sampled_from(["sin(t)", "1e-3", "-2 + 0.1*t", "pi", 0.5, 3])
placements = st.one_of(
    st.fixed_dictionaries({"position": points}),
    st.fixed_dictionaries({"trajectory": st.lists(constants, min_size=2, max_size=2)}),
    points.map(lambda p: {"spline": [[0.5, *p], [2, 1, 1], [3.25, *p]], "periodic": True}),
    points.map(lambda p: {"spline": [[-1, *p], [2.0, 1, 1]]}),
)
shapes = st.one_of(
    lengths.map(lambda radius: {"shape": "circle", "radius": radius}),
    st.lists(lengths, min_size=2, max_size=2).map(lambda size: {"shape": "rectangle", "size": size}),
)
turns: st.SearchStrategy[dict[str, Any]] = st.one_of(
    st.just({}), numbers.map(lambda angle: {"orientation": angle}), st.just({"orientation": "0.1*t"})
)


def merged(*parts: dict[str, Any]) -> dict[str, Any]:
    return {key: value for part in parts for key, value in part.items()}


def optional(**values: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries({}, optional=values)


obstacle_entries = st.builds(merged, shapes, placements, turns)
limit_pairs = st.tuples(lengths, lengths).map(lambda pair: [-pair[0], pair[1]]) | st.none()
limits = st.lists(limit_pairs, min_size=2, max_size=2) | st.none()
robots = st.builds(
    merged,
    st.just({"model": "planar_arm"}),
    st.fixed_dictionaries({"links": st.just(2) | st.lists(lengths, min_size=2, max_size=2)}),
    optional(
        name=names,
        control=st.sampled_from(["velocity", "acceleration"]),
        body_radius=lengths,
        collision=st.just("geometry") | lengths.map(lambda radius: {"link_spheres": radius}),
        limits=optional(position=limits, velocity=limits, acceleration=limits),
        self_collision_pairs=st.sampled_from([None, [], [["base", "link2"]]]),
    ),
)
goal_entries = st.one_of(
    placements.map(
        lambda place: {
            "type": "position",
            "link": "end",
            **{{"position": "target"}.get(key, key): value for key, value in place.items()},
        }
    ),
    numbers.map(lambda angle: {"type": "orientation", "link": "link1", "target": angle}),
    numbers.map(lambda angle: {"type": "joint", "joints": ["joint2"], "target": [angle]}),
    st.just({"type": "alignment", "link": "end", "axis": [1, 0], "other": "link1", "other_axis": [0.0, -1]}),
)
goal_extras = st.builds(merged, st.fixed_dictionaries({"tolerance": lengths}), optional(weight=lengths))
scenarios = st.fixed_dictionaries(
    {
        "version": st.just(1),
        "robot": robots,
        "goal": st.lists(st.builds(merged, goal_entries, goal_extras), min_size=1, max_size=3),
    },
    optional={
        "description": st.text(st.characters(codec="utf-8"), max_size=40),
        "tags": st.lists(names.map("tag{}".format), max_size=3, unique=True),
        "environment": optional(
            dt=st.just(0.1),
            duration=st.integers(1, 20),
            end_at=st.sampled_from([[], ["goal"], ["violation"]]),
            prediction=st.sampled_from(["none", "exact"]),
            safety_margin=lengths,
        ),
        "obstacles": st.lists(obstacle_entries, max_size=3),
        "seed": st.integers(0, 2**62),
        "trials": st.integers(1, 1000),
        "success": optional(
            hold_time=st.just("end") | st.floats(0.0, 1.0),
            rate=st.just("> .5"),
            kpi=numbers.map("<= {}".format),
        ),
    },
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(scenarios)
def test_a_written_concrete_problem_loads_as_itself(tmp_path: Path, data: dict[str, Any]) -> None:
    first = load_scenario(written(tmp_path, dump_yaml(data))).concrete
    again = load_scenario(written(tmp_path, dump_yaml({**first, "source": "x"})))
    # repr tells 1 from 1.0, and -0.0 from 0.0; the order of keys is the same too.
    assert repr(again.concrete) == repr(first)
    assert again.source == "x"


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(scenarios)
def test_a_concrete_problem_survives_json(tmp_path: Path, data: dict[str, Any]) -> None:
    # YAML does not read every text that JSON writes, such as U+1F600 as two escapes: numbers are what counts.
    first = load_scenario(written(tmp_path, dump_yaml({**data, "description": ""}))).concrete
    assert repr(load_scenario(written(tmp_path, json.dumps(first))).concrete) == repr(first)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(scenarios)
def test_what_loads_is_right_by_the_json_schema(tmp_path: Path, data: dict[str, Any]) -> None:
    concrete = load_scenario(written(tmp_path, dump_yaml(data))).concrete
    VALIDATOR.validate(data)
    VALIDATOR.validate(concrete)


def test_names_of_drawn_obstacles_in_a_concrete_problem(tmp_path: Path) -> None:
    text = MINIMAL + "obstacles: [{name: drawn0, shape: circle, radius: 1, position: [9, 9]}]\n"
    with pytest.raises(ScenarioError, match="'drawn0' is kept for drawn obstacles"):
        load_scenario(written(tmp_path, text))
    assert load_scenario(written(tmp_path, text + "source: a/b\n")).source == "a/b"


VALIDATOR = jsonschema.Draft202012Validator(scenario_json_schema())


def test_the_shipped_json_schema_is_that_of_the_models() -> None:
    assert SCHEMA_FILE.read_text(encoding="utf-8") == schema_text(), "run python -m pytest_lpb.scenario.json_schema"
    jsonschema.Draft202012Validator.check_schema(scenario_json_schema())


@pytest.mark.parametrize("text", [MINIMAL, FULL, DRIVE])
def test_the_json_schema_accepts_scenarios(text: str) -> None:
    VALIDATOR.validate(read_yaml(text.encode(), "x").data)


@pytest.mark.parametrize(
    "change",
    [
        {"version": 2},
        {"robot": {"model": "point", "body_radius": "0.1"}},
        {"goal": [{"type": "position", "link": "body", "target": [1, 1], "tolerence": 1}]},
        {"obstacles": [{"shape": "circle", "size": [1, 1], "position": [0, 0]}]},
        {"success": {"clearance_min_m": "about 3"}},
        {"trials": 0},
        {"unknown": 1},
    ],
)
def test_the_json_schema_refuses_what_loading_refuses(tmp_path: Path, change: dict[str, Any]) -> None:
    data = {**read_yaml(MINIMAL.encode(), "x").data, **change}
    assert not VALIDATOR.is_valid(data)
    with pytest.raises(ScenarioError):
        load_scenario(written(tmp_path, dump_yaml(data)))


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_shipped_scenarios(path: Path) -> None:
    VALIDATOR.validate(read_yaml(path.read_bytes(), path.name).data)
    assert math.isfinite(load_scenario(path).concrete["environment"]["dt"])
