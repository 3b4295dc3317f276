"""What planners can reach from what they are given: no target before it is observed, nothing of the future."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np
import pytest

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.planner.base import PlannerProblem
from pytest_lpb.problem.preview import Preview
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario

# Every number that is to stay hidden begins like this, and no other does.
HIDDEN = 7.4321

PLANE = f"""
version: 1
description: secret of the scenario
tags: [secret_tag]
robot: {{model: point, body_radius: 0.1}}
environment: {{dt: 0.05, duration: 2.0, prediction: PREDICTION, safety_margin: {HIDDEN}1}}
start: {{q: [0, 0]}}
goal:
  - {{name: reach, type: position, link: body, trajectory: ["{HIDDEN}2 + 0.1*t", "1 + {HIDDEN}3*t"], tolerance: 0.1}}
obstacles:
  - {{name: still, shape: circle, radius: 0.1, position: [{HIDDEN}4, 0]}}
  - {{name: later, shape: circle, radius: 0.1, spline: [[0, 5, 5], [1, 4, {HIDDEN}5], [2, 5, 5]]}}
success: {{hold_time: 0.5, clearance_min_m: ">= {HIDDEN}6"}}
xfail: {{rival: secret reason}}
"""

SPACE = f"""
version: 1
description: secret of the scenario
robot: {{model: point_3d, body_radius: 0.1}}
environment: {{engine: pybullet, dt: 0.05, duration: 2.0, prediction: PREDICTION, safety_margin: {HIDDEN}1}}
goal:
  - {{name: reach, type: position, link: body, target: [{HIDDEN}2, 0, 0], tolerance: 0.1}}
obstacles:
  - {{name: still, shape: sphere, radius: 0.1, position: [{HIDDEN}4, 0, 0]}}
  - {{name: later, shape: sphere, radius: 0.1, trajectory: ["5 + {HIDDEN}5*t*t*t", "1", "1"]}}
success: {{hold_time: 0.5}}
xfail: {{rival: secret reason}}
"""


@dataclass
class Reached:
    """Numbers and texts that can be reached from an object through attributes, items, closures and array bases."""

    numbers: set[float] = field(default_factory=set)
    texts: set[str] = field(default_factory=set)
    _known: dict[int, Any] = field(default_factory=dict)  # keeps what it knows alive: ids are used again

    def walk(self, root: Any) -> Reached:
        left = [root]
        while left:
            item = left.pop()
            # Modules and classes hold what is the same for all problems.
            if id(item) in self._known or isinstance(item, ModuleType | type):
                continue
            self._known[id(item)] = item
            if isinstance(item, bool | int | float):
                self.numbers.add(float(item))
            elif isinstance(item, str | bytes):
                self.texts.add(str(item))
            else:
                left.extend(_inside(item))
        return self

    def secrets(self) -> set[str]:
        """What of it should not be there."""
        numbers = {f"{number}" for number in self.numbers if f"{abs(number)}".startswith(f"{HIDDEN}")}
        return numbers | {text for text in self.texts if "secret" in text or f"{HIDDEN}" in text}


def _inside(item: Any) -> Iterator[Any]:
    """What an object holds."""
    if isinstance(item, np.ndarray):
        yield from item.ravel().tolist()
        yield item.base
    elif isinstance(item, memoryview):
        yield item.obj
    elif isinstance(item, dict):
        yield from item.keys()
        yield from item.values()
    elif isinstance(item, list | tuple | set | frozenset):
        yield from item
    elif isinstance(item, FunctionType):
        yield from (cell.cell_contents for cell in item.__closure__ or ())
        yield item.__defaults__
        yield item.__kwdefaults__
    for name in ("__dict__", "__self__", "__func__", "__wrapped__", "func", "args", "keywords"):
        yield getattr(item, name, None)
    for kind in type(item).__mro__:
        slots = kind.__dict__.get("__slots__", ())
        for slot in (slots,) if isinstance(slots, str) else slots:
            yield getattr(item, slot, None)


@pytest.fixture(params=[PLANE, SPACE], ids=["plane", "space"])
def content(request: pytest.FixtureRequest) -> str:
    text: str = request.param
    return text


def problem_of(folder: Path, content: str, prediction: str = "constant_velocity") -> Problem:
    path = folder / "secret_file.yaml"
    path.write_text(content.replace("PREDICTION", prediction), encoding="utf-8")
    return draw_problem(load_scenario(path), 0, (), "plain_key")


def test_the_walk_finds_what_is_hidden(tmp_path: Path, content: str) -> None:
    """Otherwise the tests below could not fail."""
    found = Reached().walk(problem_of(tmp_path, content)).secrets()
    for number in ("2", "4", "5"):
        assert any(f"{HIDDEN}{number}" in text for text in found), number
    assert any("secret" in text for text in found)


def test_before_the_trial(tmp_path: Path, content: str) -> None:
    """Nothing of targets, obstacles' places, motions, criteria, descriptions, other planners."""
    told = PlannerProblem.of(problem_of(tmp_path, content), 0.05)
    told.robot.forward_kinematics(np.zeros(told.robot.dof), told.robot.link_names[-1])
    reached = Reached().walk([told, told.to_dict(), told.structure])
    assert reached.secrets() == set()
    assert "still" in reached.texts  # an obstacle's name it may know


@pytest.mark.parametrize("prediction", ["none", "constant_velocity"])
def test_during_the_trial(tmp_path: Path, content: str, prediction: str) -> None:
    """An observation shows what is there now; what is seen of the future goes on as it moves now."""
    environment = ScenarioEnvironment(
        problem=problem_of(tmp_path, content, prediction),
        preview=Preview(steps=4, step_s=0.25),
        reuse_observations=True,
    )
    try:
        shown = {f"{HIDDEN}2", f"{HIDDEN}4"}  # the target, and an obstacle that is seen
        if content is PLANE:
            shown.add(f"{HIDDEN}3")  # the goal's velocity
        assert Reached().walk(environment.observe()).secrets() <= shown
        assert f"{HIDDEN}4" in Reached().walk(environment.observe()).secrets()
    finally:
        environment.close()


def test_what_is_told_is_the_same_for_all_scenes(tmp_path: Path, content: str) -> None:
    """Whatever is hidden may be any other number: planners are told the same, to the last bit."""
    (tmp_path / "other").mkdir()
    other = content.replace(f"{HIDDEN}", "6.1234").replace("secret", "other")
    first = PlannerProblem.of(problem_of(tmp_path, content), 0.05)
    second = PlannerProblem.of(problem_of(tmp_path / "other", other, "exact"), 0.05)
    assert first.to_dict() == second.to_dict()
    assert first.structure == second.structure
