import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.problem.hold import first_held_row, rows_to_hold

from .trials import REACH, make_problem, make_trial


@pytest.mark.parametrize(
    ("hold_time", "dt", "rows"),
    [(0.5, 0.05, 10), (0.5, 0.1, 5), (0.3, 0.1, 3), (0.51, 0.1, 6), (0.0, 0.1, 0), ("end", 0.1, None)],
)
def test_hold_time_is_rounded_up_to_steps(hold_time: float | str, dt: float, rows: int | None) -> None:
    assert rows_to_hold(hold_time, dt) == rows


@pytest.mark.parametrize(
    ("within", "hold_rows", "row"),
    [
        ("01110111", 2, 1),
        ("01101111", 2, 4),
        ("01110", 3, None),
        ("1111", 3, 0),
        ("1111", 4, None),
        ("0010", 0, 2),
        ("0000", 0, None),
        ("0110", None, None),
        ("0101", None, 3),
        ("1111", None, 0),
        ("", None, None),
        ("", 0, None),
    ],
)
def test_first_interval_that_lasts(within: str, hold_rows: int | None, row: int | None) -> None:
    assert first_held_row(np.array([digit == "1" for digit in within], dtype=np.bool_), hold_rows) == row


@given(st.lists(st.booleans(), max_size=30), st.one_of(st.none(), st.integers(0, 8)))
def test_agrees_with_a_search_row_by_row(within: list[bool], hold_rows: int | None) -> None:
    rows = len(within)
    expected = next(
        (
            row
            for row in range(rows)
            if (hold_rows is None or row + hold_rows < rows)
            and all(within[row : rows if hold_rows is None else row + hold_rows + 1])
        ),
        None,
    )
    assert first_held_row(np.array(within, dtype=np.bool_), hold_rows) == expected


def test_negative_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="hold_rows is -1; allowed is 0 or more"):
        first_held_row(np.ones(3, dtype=np.bool_), -1)


def test_goal_row_asks_every_sub_goal_with_a_tolerance() -> None:
    goals = [
        {**REACH, "target": [1.0, 0.0]},
        {**REACH, "name": "height", "axes": [1], "target": [0.5], "tolerance": 0.12},
        {**REACH, "name": "wish", "target": [9.0, 9.0], "tolerance": None},
    ]
    x = np.minimum(np.arange(21) * 0.1, 1.0)
    y = np.concatenate([np.zeros(12), np.linspace(0.0, 0.5, 6), np.full(3, 0.5)])
    goals[0]["tolerance"] = 0.6
    trial = make_trial(make_problem(goal=goals, hold_time=0.2), np.column_stack([x, y]))
    assert trial.goal_row == 16  # height 0.4 at row 16, 0.5 from row 17 on
