"""Pictures of trials, looked at pixel by pixel."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.picture import picture_for
from pytest_lpb.errors import LpbError
from tests.problem.entries import ARM, CART, POINT, Entry, circle, make_problem, position_goal

LINKS = {"point": "body", "planar_arm": "end", "differential_drive": "base"}
ROBOT = (133, 144, 154)  # as it is blended with a white page


def pixels_near(picture: NDArray[np.uint8], colour: tuple[int, int, int], distance: float = 6.0) -> int:
    return int((np.linalg.norm(picture.astype(float) - colour, axis=2) < distance).sum())


@pytest.mark.parametrize("robot", [POINT, ARM, CART])
def test_robot_and_obstacle_are_in_the_picture(robot: Entry) -> None:
    problem = make_problem(
        robot, goal=[position_goal([1.0, 1.0], LINKS[robot["model"]])], obstacles=[circle(1.5, 1.5, 0.4)]
    )
    environment = ScenarioEnvironment(problem=problem, render_mode="rgb_array")
    environment.reset()
    first = environment.render()
    assert first.ndim == 3
    assert first.shape[2] == 3
    assert first.dtype == np.uint8
    assert pixels_near(first, ROBOT) > 100
    assert pixels_near(first, (184, 191, 199)) > 100
    for _ in range(20):
        environment.step(np.ones(problem.robot.n_actions))
    assert (environment.render() != first).any()
    environment.close()


def test_what_is_around_is_in_the_picture_unless_it_is_far_away() -> None:
    problem = make_problem(POINT, goal=[{"name": "left", "type": "joint", "joints": ["x"], "target": [0.0]}])
    seen = {}
    for name, around in {"nothing": None, "near": [[1.2, 0.0]], "far": [[1e7, -1e7]]}.items():
        picture = picture_for(2, show=False, around=None if around is None else np.array(around))
        seen[name] = [np.asarray(picture.draw(problem, row, [x, 0.0])) for row, x in enumerate((0.0, 1.2))]
        picture.close()
    assert pixels_near(seen["nothing"][1], ROBOT) == 0
    assert pixels_near(seen["near"][1], ROBOT) > 100
    assert pixels_near(seen["far"][0], ROBOT) > 100


def test_a_window_needs_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("matplotlib.get_backend", lambda: "agg")
    environment = ScenarioEnvironment(problem=make_problem(POINT), render_mode="human")
    with pytest.raises(LpbError, match="needs a display"):
        environment.reset()
    environment.close()
