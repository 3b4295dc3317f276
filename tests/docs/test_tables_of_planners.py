"""docs/observation.md and docs/scenario-keys.md say what there is."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb import run_trial
from pytest_lpb.environment.observation import Observation
from pytest_lpb.planner import registry
from pytest_lpb.planner.base import GoalInfo, ObstacleInfo, PlannerProblem
from pytest_lpb.problem.preview import Preview
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.json_schema import scenario_json_schema
from pytest_lpb.scenario.key_table import keys_page
from pytest_lpb.scenarios_cli import main
from tests.problem.entries import ARM, CART, circle, make_problem, position_goal
from tests.problem.spatial import robots
from tests.problem.spatial.problems import spatial_problem, sphere

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/observation.md").read_text("utf-8")


def table(heading: str) -> dict[str, str]:
    """Second column by name of the first, of the table below a heading."""
    text = PAGE.partition(f"{heading}\n")[2].partition("\n#")[0]
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("| `")
    ]
    return {name: row[1] for row in rows for name in re.findall(r"`([\w.]+)(?:\([^)]*\))?`", row[0])}


def problem_of(name: str) -> Problem:
    if name == "arm":
        return make_problem(ARM, goal=[position_goal([1.0, 1.0], "end")], obstacles=[circle(9.0, 9.0, 1.0)])
    if name == "cart":
        return make_problem(CART, obstacles=[circle(9.0, 9.0, 1.0, "a"), circle(9.0, 5.0, 1.0, "b")])
    return spatial_problem(robots.CART, obstacles=[sphere(9.0, 9.0, 9.0)])


@pytest.mark.parametrize("name", ["arm", "cart", "space"])
def test_keys_and_shapes_of_an_observation(name: str) -> None:
    problem = problem_of(name)
    shapes = table("## observation")
    robot, primary = problem.robot, problem.primary
    known = {
        "n": len(problem.obstacles),
        "d": problem.dimension,
        "dof": robot.dof,
        "n_actions": robot.n_actions,
        "size": primary.motion.size,
        "steps": 3,
    }
    views = Observation(problem, Preview(3, 0.1), len(problem.obstacles)).views
    told = {key.replace("NAME", primary.name): shape for key, shape in shapes.items()}
    assert set(told) == set(views)
    for key, shape in told.items():
        forms = re.findall(r"\(([^)]*)\)", shape)
        form = forms[-1] if problem.dimension == 3 else forms[0]
        expected = tuple(int(eval(part, {}, known)) for part in form.split(",") if part.strip())
        assert views[key].shape == expected, key


def public(thing: object) -> set[str]:
    return {name for name in {*vars(type(thing)), *vars(thing)} if not name.startswith("_")}


def test_attributes_of_a_problem() -> None:
    problem = PlannerProblem.of(problem_of("arm"), 0.1)
    assert set(table("## problem")) == public(problem) - {"of"}
    assert set(table("### problem.goal[i]")) == {field.name for field in fields(GoalInfo)}
    assert set(table("### problem.obstacles[i]")) == {field.name for field in fields(ObstacleInfo)}


@pytest.mark.parametrize("name", ["arm", "cart", "space"])
def test_attributes_of_a_robot(name: str) -> None:
    problem = problem_of(name)
    robot, size = problem.robot, problem.dimension + 1
    for attribute in table("### problem.robot"):
        value: Any = robot
        for part in attribute.split("."):
            value = getattr(value, part)
    q, link = problem.start_q, robot.link_names[-1]
    assert robot.base_pose.shape == robot.forward_kinematics(q, link).shape == (size, size)
    assert robot.jacobian(q, link).shape == ({3: 3, 4: 6}[size], robot.dof)
    assert robot.action_map(q).shape == (robot.dof, robot.n_actions)
    assert len(robot.action_names) == len(robot.action_kinds) == robot.n_actions
    assert robot.limits.position.shape == (robot.dof, 2)
    assert robot.limits.velocity.shape == robot.limits.effort.shape == (robot.n_actions, 2)


def test_the_example(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(registry, "_classes", dict(registry._classes))
    found: dict[str, Any] = {}
    exec(PAGE.partition("```python\n")[2].partition("```")[0], found)
    trial = run_trial("scenarios/point/one_circle.yaml", found["Careful"])
    assert trial.outcome == "success", trial.metadata["message"]
    assert trial.clearance.min() > 0.0


def test_the_page_of_all_keys_is_what_the_schema_says() -> None:
    page = (ROOT / "docs/scenario-keys.md").read_text("utf-8")
    assert page == keys_page(), "run: lpb-scenarios keys --output docs/scenario-keys.md"
    schema = scenario_json_schema()
    for name, definition in {"file": schema, **schema["$defs"]}.items():
        for key, field in definition["properties"].items():
            assert f"| `{key}` |" in page
            assert field.get("description"), f"{name}.{key} has no description"


def test_commands_that_write_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys"]) == 0
    assert capsys.readouterr().out == keys_page()
    plugin = tmp_path / "mine.py"
    plugin.write_text(
        "from pytest_lpb import register_shape\n\n\n@register_shape('hill', dimension=2, keys={'slope': float})\n"
        "class Hill:\n    '''A hill.'''\n",
        "utf-8",
    )
    # In a process of its own: what it registers stays there.
    output = tmp_path / "schema.json"
    program = str(Path(sys.executable).with_name("lpb-scenarios"))
    command = [program, "schema", "--plugin", str(plugin), "--output", str(output)]
    subprocess.run(command, check=True)
    assert '"hill"' in output.read_text("utf-8")
    assert main(["schema", "--plugin", str(tmp_path / "none.py")]) == 4
    assert "none.py" in capsys.readouterr().err
