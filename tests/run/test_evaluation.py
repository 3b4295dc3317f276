"""What the evaluation of a trial says of its control mode."""

import pytest

from pytest_lpb.run.evaluation import control_mode
from tests.kpis.trials import ARM, CART, POINT, REACH, make_problem


@pytest.mark.parametrize(
    ("robot", "link", "mode"),
    [
        (POINT, "body", "acceleration [m/s^2]"),
        ({**POINT, "control": "velocity"}, "body", "velocity [m/s]"),
        (ARM, "end", "acceleration [rad/s^2]"),
        (CART, "base", "velocity [m/s, rad/s]"),
    ],
)
def test_control_modes_with_the_same_units_are_the_same(robot: dict[str, object], link: str, mode: str) -> None:
    assert control_mode(make_problem(robot, goal=[{**REACH, "link": link}])) == mode
