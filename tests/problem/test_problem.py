"""Problems as dictionaries, and their hashes."""

import copy
import json
import os
import subprocess
import sys
from collections.abc import Callable
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.hashing import canonical_json, hash_of, hash_of_arrays, plain
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import robot_from

from .entries import ARM, CART, POINT, Entry, circle, make_problem, position_goal, problem_entry

# A change of this value changes every problem's identity, and no old run could be compared with a new one.
PINNED_HASH = "9dd5ba4156a8a09ae1bdd72bf79d07e402f2195945bc7aa13d335c626cafbce4"


def example() -> Entry:
    return problem_entry(goal=[position_goal([4.0, 0.2])], obstacles=[circle(2.0, 0.2, 1.0)], q=[0.1, 1e-9])


def test_the_pinned_hash() -> None:
    assert Problem.from_dict(example()).problem_hash == PINNED_HASH


def reversed_keys(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: reversed_keys(value[key]) for key in reversed(list(value))}
    return [reversed_keys(item) for item in value] if isinstance(value, list) else value


def test_the_hash_ignores_what_is_no_part_of_the_problem() -> None:
    entry = example()
    for key, value in {"tags": ["x"], "description": "new", "seed": 5, "success": {"hold_time": 9.0}}.items():
        assert Problem.from_dict({**entry, key: value}, "other").problem_hash == PINNED_HASH
    assert Problem.from_dict(reversed_keys(entry)).problem_hash == PINNED_HASH
    assert Problem.from_dict(json.loads(json.dumps(entry))).problem_hash == PINNED_HASH


CHANGES: dict[str, Callable[[Entry], Any]] = {
    "robot": lambda e: e["robot"].update(body_radius=0.2 + 1e-16 + 1e-15),
    "environment": lambda e: e["environment"].update(dt=0.01),
    "start": lambda e: e["start"].update(q=[0.1, 2e-9]),
    "goal": lambda e: e["goal"][0].update(tolerance=0.2),
    "obstacles": lambda e: e["obstacles"][0].update(radius=1.1),
    "order of obstacles": lambda e: e["obstacles"].insert(0, circle(5.0, 5.0, 1.0, "new")),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_the_hash_follows_every_part(change: Callable[[Entry], Any]) -> None:
    entry = copy.deepcopy(example())
    change(entry)
    assert Problem.from_dict(entry).problem_hash != PINNED_HASH


def test_the_hash_is_the_same_in_any_process() -> None:
    program = (
        "import json, sys; from pytest_lpb.problem.problem import Problem;"
        "print(Problem.from_dict(json.load(sys.stdin)).problem_hash)"
    )
    environment = {**os.environ, "PYTHONHASHSEED": "7"}
    result = subprocess.run(
        [sys.executable, "-c", program],
        input=json.dumps(example()),
        capture_output=True,
        text=True,
        check=True,
        env=environment,
    )
    assert result.stdout.strip() == PINNED_HASH


@pytest.mark.parametrize("robot", [POINT, ARM, CART], ids=["point", "arm", "cart"])
def test_a_problem_is_its_dictionary(robot: Entry) -> None:
    entry = problem_entry(robot, obstacles=[circle(9.0, 9.0, 0.5)], seed=3)
    kept = copy.deepcopy(entry)
    problem = Problem.from_dict(entry, "x")
    assert problem.to_dict() == kept
    again = Problem.from_dict(json.loads(json.dumps(problem.to_dict())), "x")
    assert again.to_dict() == kept
    assert again.problem_hash == problem.problem_hash
    assert_array_equal(again.start_q, problem.start_q)
    assert entry == kept  # reading changes nothing


def test_settings() -> None:
    problem = make_problem(
        dt=0.1, duration=2.0, success={"hold_time": 0.25, "rate": ">= 0.8", "clearance_min_m": ">= 0"}
    )
    assert (problem.steps, problem.hold_rows, problem.dimension) == (20, 3, 2)
    assert problem.times[-1] == pytest.approx(2.0)
    assert problem.criteria == {"clearance_min_m": ">= 0"}
    assert make_problem(success={"hold_time": "end"}).hold_rows is None


def test_rounding_of_steps() -> None:
    assert make_problem(dt=0.1, duration=0.3).steps == 3  # 0.3 / 0.1 is a rounding error below 3


def test_an_unknown_model() -> None:
    with pytest.raises(ScenarioError, match=r"unknown 'pointt'; did you mean 'point'.*allowed: "):
        robot_from({**POINT, "model": "pointt"})


def test_canonical_json() -> None:
    assert canonical_json({"b": [1.5, None], "a": "é"}) == '{"a":"\\u00e9","b":[1.5,null]}'
    with pytest.raises(ValueError, match="not JSON compliant"):
        canonical_json(float("nan"))
    assert hash_of({"a": 1}) != hash_of({"a": 2})


def test_hashes_of_arrays() -> None:
    flat, square = np.arange(4.0), np.arange(4.0).reshape(2, 2)
    assert hash_of_arrays([flat]) != hash_of_arrays([square])
    assert hash_of_arrays([square.T]) == hash_of_arrays([np.ascontiguousarray(square.T)])
    assert hash_of_arrays([flat]) == hash_of_arrays([flat.astype(">f8")])  # byte order is the machine's affair
    assert hash_of_arrays([flat]) != hash_of_arrays([np.nextafter(flat, 9.0)])


def test_plain_says_what_json_cannot() -> None:
    value = {"gain": inf, "path": Path("a/b"), "pair": (1, 2.5), 3: None}
    assert plain(value) == {"gain": "inf", "path": "a/b", "pair": [1, 2.5], "3": None}
