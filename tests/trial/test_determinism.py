"""The same specification gives the same raw data, to the last bit."""

import gc
import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_lpb.trial.holder import PlannerHolder
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import CART, circle, position_goal

from .specifications import recorded_problem, same_columns, specification


def cart() -> TrialSpecification:
    moving = {"name": "cart", "shape": "circle", "radius": 0.3, "trajectory": ["3 - 0.3*t", "sin(0.5*t)"]}
    return specification(
        "potential_field",
        robot=CART,
        goal=[position_goal([3.0, 1.0], "base")],
        obstacles=[circle(1.5, 0.6, 0.2), moving],
        duration=10.0,
        end_at=[],
    )


SPECIFICATIONS = {"pd": recorded_problem, "potential field": cart}


@pytest.mark.parametrize("name", SPECIFICATIONS)
def test_twice(name: str) -> None:
    first, second = run_trial(SPECIFICATIONS[name]()), run_trial(SPECIFICATIONS[name]())
    assert same_columns(first, second)
    assert first.metadata["trajectory_hash"] == second.metadata["trajectory_hash"]
    assert first.metadata["problem_hash"] == second.metadata["problem_hash"]


@pytest.mark.parametrize("name", SPECIFICATIONS)
def test_in_another_process(name: str, tmp_path: Path) -> None:
    made = SPECIFICATIONS[name]()
    expected = run_trial(made).metadata
    path = tmp_path / "specification"
    path.write_bytes(pickle.dumps(made))
    program = (
        "import pickle, sys; from pathlib import Path; from pytest_lpb.trial.trial import run_trial;"
        "print(run_trial(pickle.loads(Path(sys.argv[1]).read_bytes())).metadata['trajectory_hash'])"
    )
    result = subprocess.run(
        [sys.executable, "-c", program, str(path)],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "99"},
    )
    assert result.stdout.strip() == expected["trajectory_hash"]


@pytest.mark.parametrize("name", SPECIFICATIONS)
def test_after_other_trials_of_the_same_planner(name: str) -> None:
    made = SPECIFICATIONS[name]()
    alone = run_trial(made)
    holder = PlannerHolder(made.planner)
    other = {**made.problem, "goal": [{**made.problem["goal"][0], "target": [-3.0, -2.0]}]}
    for problem in (other, made.problem, other):
        run_trial(made.with_problem(problem), holder)
    after = run_trial(made, holder)
    holder.close()
    assert same_columns(alone, after)
    assert alone.metadata["trajectory_hash"] == after.metadata["trajectory_hash"]


def test_the_hash_follows_the_motion() -> None:
    made = recorded_problem()
    moved = made.with_problem({**made.problem, "start": {"q": [1e-12, 0.0], "qd": [0.0, 0.0]}})
    assert run_trial(made).metadata["trajectory_hash"] != run_trial(moved).metadata["trajectory_hash"]


def test_one_planner_runs_all_trials_of_a_holder() -> None:
    """It is the planner's duty to forget: one that does not is found out by this."""
    made = specification("Counting", duration=0.5)
    holder = PlannerHolder(made.planner)
    actions = [run_trial(made, holder).action[0, 0] for _ in range(3)]
    assert actions == [1.0, 2.0, 3.0]
    assert run_trial(made).action[0, 0] == 1.0  # its own planner


@pytest.mark.parametrize("enabled", [True, False])
@pytest.mark.parametrize("planner", ["pd", "BadSetup"])
def test_garbage_collection_is_as_it_was(enabled: bool, planner: str) -> None:
    (gc.enable if enabled else gc.disable)()
    try:
        run_trial(specification(planner))
        assert gc.isenabled() is enabled
        assert gc.get_freeze_count() == 0
    finally:
        gc.enable()
