"""Which faults of trials are equal: those of one planner from one line, whatever numbers they name."""

# ruff: noqa: E501 - tables of one case a line

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_lpb.run.faults import cause_and_time, fault_groups, fault_key

HERE = Path.cwd()


def trial(seed: int, message: str, planner: str = "dwa", outcome: str = "planner_error") -> dict[str, str]:
    return {
        "planner": planner,
        "outcome": outcome,
        "message": message,
        "node_id": f"a.yaml::{planner}::seed{seed}",
        "command": f"pytest a.yaml::{planner}::seed{seed}",
    }


@pytest.mark.parametrize(
    ("one", "other", "equal"),
    [
        ("planner error at t = 0.1 s: KeyError: 3 (/x/dwa.py:27)", "planner error at t = 2e+01 s: KeyError: 5 (/x/dwa.py:27)", True),
        ("planner error at t = 0.1 s: KeyError: 3 (/x/dwa.py:27)", "planner error at t = 0.1 s: KeyError: 3 (/x/dwa.py:28)", False),
        ("planner error at t = 0.1 s: KeyError: 'a' (/x/dwa.py:27)", "planner error at t = 0.1 s: KeyError: 'b' (/x/dwa.py:27)", False),
        ("planner error at t = 0 s: compute_action returned [nan, 0.0]; every", "planner error at t = 1 s: compute_action returned [1.5, -inf]; every", True),
        ("the process that ran the trial died", "the process that ran the trial died", True),
    ],
)  # fmt: skip
def test_equal_faults(one: str, other: str, equal: bool) -> None:
    assert (fault_key("dwa", "planner_error", one) == fault_key("dwa", "planner_error", other)) is equal


def test_the_cause_comes_without_the_time() -> None:
    message = "planner error at t = 0.15 s: ValueError: at t = 3 s: no"
    assert cause_and_time(message) == ("ValueError: at t = 3 s: no", "at t = 0.15 s")
    assert cause_and_time("came to a standstill 0.3 m from the goal") == (
        "came to a standstill 0.3 m from the goal",
        "",
    )


def test_groups_are_by_planner_the_most_frequent_first() -> None:
    places = [f"planner error at t = 0.{seed} s: AttributeError: x ({HERE}/dwa.py:27)" for seed in range(3)]
    trials = [
        trial(0, "deadline at t = 1 s: compute_action took longer", outcome="deadline"),
        *(trial(seed, message) for seed, message in enumerate(places)),
        trial(0, places[0], planner="mine"),
        trial(1, "'body' hit obstacle", outcome="collision"),
    ]
    groups = fault_groups(trials)
    assert [group.line for group in groups] == [
        "3 trials of dwa: planner_error: AttributeError: x (dwa.py:27)",
        "1 trial of dwa: deadline: compute_action took longer",
        "1 trial of mine: planner_error: AttributeError: x (dwa.py:27)",
    ]
    assert groups[0].node_ids == ("a.yaml::dwa::seed0", "a.yaml::dwa::seed1", "a.yaml::dwa::seed2")
    assert groups[0].command == "pytest a.yaml::dwa::seed0"
