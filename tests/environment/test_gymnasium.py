"""`lpb/Scenario-v0` as users of gymnasium meet it."""

import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env
from numpy.testing import assert_array_equal

import pytest_lpb.environment  # noqa: F401 - registers the environment
from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.errors import LpbError, ScenarioError
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario
from tests.problem.entries import circle, make_problem

Content = dict[str, Any]
Write = Callable[[Content], Path]

ROBOTS: dict[str, tuple[Content, str, list[float]]] = {
    "point": (
        {"model": "point", "limits": {"velocity": [[-2, 2], [-1, 1]], "acceleration": [[-4, 3], None]}},
        "body",
        [2, 1],
    ),
    "planar_arm": ({"model": "planar_arm", "links": 3}, "end", [1.0, 1.5]),
    "differential_drive": ({"model": "differential_drive", "limits": {"velocity": [[-1, 1], [-2, 2]]}}, "base", [2, 1]),
}


def family(robot: str = "point", control: str = "acceleration", **changes: Any) -> Content:
    entry, link, target = ROBOTS[robot]
    return {
        "robot": {**entry, "control": control},
        "environment": {"duration": 2.0},
        "goal": [{"name": "reach", "type": "position", "link": link, "target": target, "tolerance": 0.1}],
        "obstacles": [{"name": "post", "shape": "circle", "radius": 0.2, "position": [-1.5, -1.5]}],
        "randomize": {"draw": ["goal"], "goal": [[1.2, 1.6], [0.5, 1.0]]},
        **changes,
    }


COUNTED = {
    "draw": ["obstacles"],
    "obstacles": {"count": [1, 4], "shape": "circle", "position": [[-5, -4], [-5, 5]], "radius": [0.1, 0.2]},
}


@pytest.fixture
def quiet() -> Iterator[None]:
    """Without gymnasium's advice on how to scale spaces: an unlimited robot has an unbounded one."""
    with warnings.catch_warnings():
        for text in (".*pace m(in|ax)imum value is -?infinity", ".*symmetric and normalized space"):
            warnings.filterwarnings("ignore", message=text, category=UserWarning)
        yield


@pytest.mark.parametrize("control", ["acceleration", "velocity"])
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.usefixtures("quiet")
def test_gymnasium_finds_no_fault(write: Write, robot: str, control: str) -> None:
    environment = gymnasium.make("lpb/Scenario-v0", scenario=str(write(family(robot, control))))
    check_env(environment.unwrapped, skip_render_check=True)
    environment.close()


@pytest.mark.usefixtures("quiet")
def test_gymnasium_finds_no_fault_with_a_drawn_number_of_obstacles(write: Write) -> None:
    environment = gymnasium.make("lpb/Scenario-v0", scenario=write(family(randomize=COUNTED)))
    check_env(environment.unwrapped, skip_render_check=True)


def test_importing_the_package_registers_it() -> None:
    for program in ("import gymnasium, pytest_lpb", "import gymnasium, pytest_lpb.environment"):
        code = f"{program}; print('lpb/Scenario-v0' in gymnasium.registry)"
        result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert result.stdout.strip() == "True"


def test_the_action_space_has_the_limits(write: Write) -> None:
    accelerating = ScenarioEnvironment(write(family())).action_space
    assert isinstance(accelerating, spaces.Box)
    assert_array_equal(accelerating.low, [-4.0, -np.inf])
    assert_array_equal(accelerating.high, [3.0, np.inf])
    moving = ScenarioEnvironment(write(family(control="velocity"))).action_space
    assert isinstance(moving, spaces.Box)
    assert_array_equal(moving.low, [-2.0, -1.0])
    assert moving.dtype == np.float64
    unlimited = ScenarioEnvironment(write(family("planar_arm"))).action_space
    assert isinstance(unlimited, spaces.Box)
    assert_array_equal(unlimited.high, [np.inf] * 3)


def test_observations_are_in_their_space(write: Write) -> None:
    environment = ScenarioEnvironment(write(family("differential_drive")))
    observation, _ = environment.reset(seed=1)
    for _ in range(5):
        assert environment.observation_space.contains(observation)
        observation, *_ = environment.step(np.array([1.0, 1.0]))


def test_a_seed_is_a_problem(write: Write) -> None:
    path = write(family())
    environment = ScenarioEnvironment(path)
    first, info = environment.reset(seed=3)
    environment.step(np.array([1.0, 0.0]))
    again, info_again = environment.reset(seed=3)
    other, _ = environment.reset(seed=4)
    assert info == info_again
    for key in first:
        assert_array_equal(first[key], again[key])
    assert (first["goal_reach"] != other["goal_reach"]).any()
    environment.reset(seed=3)
    assert environment.problem.problem_hash == draw_problem(load_scenario(path), 3).problem_hash


def test_without_a_seed_the_scenarios_own_comes_first(write: Write) -> None:
    environment = ScenarioEnvironment(write(family(seed=11)))
    environment.reset()
    assert environment.problem.seed == 11
    environment.reset()
    assert environment.problem.seed != 11
    environment.reset()
    third = environment.problem.seed
    environment.reset(seed=5)
    environment.reset()
    after = environment.problem.seed
    environment.reset(seed=5)
    environment.reset()
    assert environment.problem.seed == after != third


def test_observations_are_the_callers_own(write: Write) -> None:
    environment = ScenarioEnvironment(write(family()))
    before, _ = environment.reset(seed=0)
    kept = before["q"].copy()
    environment.step(np.array([1.0, 1.0]))
    assert_array_equal(before["q"], kept)
    before["q"][:] = 99.0
    after, *_ = environment.step(np.array([0.0, 0.0]))
    assert after["q"][0] < 1.0


def test_two_environments_side_by_side(write: Write) -> None:
    vector = gymnasium.make_vec("lpb/Scenario-v0", num_envs=2, vectorization_mode="sync", scenario=str(write(family())))
    observation, _ = vector.reset(seed=[3, 4])  # type: ignore[arg-type] # narrower than gymnasium's documentation
    single = ScenarioEnvironment(write(family()))
    for index, seed in enumerate((3, 4)):
        alone, _ = single.reset(seed=seed)
        assert_array_equal(observation["goal_reach"][index], alone["goal_reach"])
    stepped, reward, terminated, truncated, info = vector.step(np.array([[1.0, 0.0], [0.0, 1.0]]))
    assert stepped["q"].shape == (2, 2)
    assert stepped["q"][0, 0] == stepped["q"][1, 1] > 0.0
    assert reward.shape == (2,)
    assert not (terminated | truncated).any()
    assert info["goal_distance"].shape == (2,)
    vector.close()


# What an observation holds, of a point with one sub-goal, by section 4 of the contract.
KEYS = {
    *("t", "q", "qd", "u"),
    *("goal_reach", "goal_reach_velocity", "goal_reach_acceleration"),
    *("goal_position", "goal_velocity", "goal_acceleration"),
    *("obstacle_position", "obstacle_velocity", "obstacle_acceleration", "obstacle_orientation"),
}


def test_the_keys_of_an_observation(write: Write) -> None:
    assert set(ScenarioEnvironment(write(family())).reset(seed=0)[0]) == KEYS
    fixed_count = {**COUNTED, "obstacles": {**COUNTED["obstacles"], "count": 3}}  # type: ignore[dict-item]
    assert set(ScenarioEnvironment(write(family(randomize=fixed_count))).reset(seed=0)[0]) == KEYS


def test_padded_rows_can_be_told_from_obstacles(write: Write) -> None:
    environment = ScenarioEnvironment(write(family(randomize=COUNTED)))
    counts = set()
    for seed in range(12):
        observation, _ = environment.reset(seed=seed)
        assert set(observation) == KEYS | {"obstacle_present"}
        number = len(environment.problem.obstacles)
        counts.add(number)
        assert_array_equal(observation["obstacle_present"], [1.0] * number + [0.0] * (5 - number))
        assert observation["obstacle_position"].shape == (5, 2)
        expected = [obstacle.motion.evaluate(np.zeros(1))[0][0] for obstacle in environment.problem.obstacles]
        assert_array_equal(observation["obstacle_position"][:number], expected)
        assert not observation["obstacle_position"][number:].any()
    assert counts == {2, 3, 4, 5}


def test_a_problem_in_place_of_a_scenario() -> None:
    problem = make_problem()
    environment = ScenarioEnvironment(problem=problem)
    observation, info = environment.reset(seed=99)  # one problem, whatever the seed
    assert environment.problem is problem
    assert observation["obstacle_position"].shape == (0, 2)
    assert info["outcome"] == "running"
    assert np.isnan(info["clearance"])


def test_a_problem_among_the_options(write: Write) -> None:
    environment = ScenarioEnvironment(write(family()))
    problem = draw_problem(load_scenario(write(family())), 77)
    observation, _ = environment.reset(options={"problem": problem})
    assert_array_equal(observation["goal_reach"], problem.to_dict()["goal"][0]["target"])
    crowd = Problem.from_dict({**problem.to_dict(), "obstacles": [circle(9.0, 9.0, 1.0, f"o{i}") for i in range(2)]})
    with pytest.raises(LpbError, match="it has 2 obstacles; this environment has room for 1"):
        environment.reset(options={"problem": crowd})
    with pytest.raises(LpbError, match="observations or actions differ"):
        environment.reset(options={"problem": make_problem()})
    with pytest.raises(LpbError, match=r"a pytest_lpb\.Problem is needed"):
        environment.reset(options={"problem": {"robot": 1}})
    environment.step(np.zeros(2))  # what was refused has changed nothing
    assert environment.problem is problem


def test_wrong_arguments(write: Write, tmp_path: Path) -> None:
    with pytest.raises(LpbError, match="needs a scenario or a problem, and not both"):
        ScenarioEnvironment()
    with pytest.raises(LpbError, match="needs a scenario or a problem, and not both"):
        ScenarioEnvironment(write(family()), problem=make_problem())
    with pytest.raises(LpbError, match="render_mode 'ascii' is unknown; allowed: human, rgb_array, None"):
        ScenarioEnvironment(write(family()), render_mode="ascii")
    with pytest.raises(ScenarioError, match=r"missing\.yaml:1: cannot be read"):
        ScenarioEnvironment(tmp_path / "missing.yaml")


def test_after_close(write: Write) -> None:
    environment = ScenarioEnvironment(write(family()))
    environment.reset(seed=0)
    environment.close()
    environment.close()
    for use in (lambda: environment.step(np.zeros(2)), lambda: environment.reset(seed=0)):
        with pytest.raises(LpbError, match="this environment is closed; make a new one"):
            use()


WRONG_ACTIONS: dict[str, Any] = {
    "too long": np.zeros(3),
    "a number": 1.0,
    "nested": np.zeros((2, 2)),
    "nested lists": [[1.0], [2.0]],
    "NaN": np.array([0.0, np.nan]),
    "infinite": [np.inf, 0.0],
    "nothing": None,
    "text": "ab",
    "list of text": ["a", "b"],
    "list of nothing": [None, None],
}


@pytest.mark.parametrize("action", WRONG_ACTIONS.values(), ids=WRONG_ACTIONS)
def test_wrong_actions(write: Write, action: Any) -> None:
    environment = ScenarioEnvironment(write(family()))
    environment.reset(seed=0)
    with pytest.raises(LpbError, match=r"action .* must be 2 finite numbers"):
        environment.step(action)
    assert environment.row == 0
    environment.step([1, 2])  # whole numbers are numbers
    environment.step(np.array([1, 2], dtype=np.float32))
    assert environment.row == 2
