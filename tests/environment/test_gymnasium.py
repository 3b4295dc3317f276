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
from numpy.testing import assert_allclose, assert_array_equal

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
    """Without gymnasium's advice on how to scale spaces."""
    with warnings.catch_warnings():
        for text in (".*observation space m(in|ax)imum value is -?infinity", ".*symmetric and normalized space"):
            warnings.filterwarnings("ignore", message=text, category=UserWarning)
        yield


@pytest.mark.parametrize("control", ["acceleration", "velocity"])
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.usefixtures("quiet")
def test_gymnasium_finds_no_fault(write: Write, robot: str, control: str) -> None:
    some: Content = {} if control == "acceleration" else {"obstacles": []}
    environment = gymnasium.make("lpb/Scenario-v0", scenario=str(write(family(robot, control, **some))))
    check_env(environment.unwrapped, skip_render_check=True)
    environment.close()


SPATIAL: dict[str, Content] = {
    "point_3d": {"model": "point_3d"},
    "arm_3d": {"model": "arm_3d", "links": 3, "control": "velocity"},
    "cart": {"model": "cart"},
    "car": {"model": "car", "control": "velocity"},
    "panda": {"model": "panda", "control": "torque"},
    "carried": {"model": "arm_3d", "links": 2, "base": "holonomic", "base_size": [0.4, 0.4, 0.2]},
}
SHAPES: list[Content] = [
    {"shape": "sphere", "radius": 0.2, "position": [9, 9, 9]},
    {"shape": "box", "size": [0.1, 0.2, 0.3], "position": [9, -9, 9]},
    {"shape": "cylinder", "radius": 0.2, "length": 1.0, "position": [-9, 9, 9]},
    {"shape": "capsule", "radius": 0.2, "length": 1.0, "position": [-9, -9, 9]},
    {"shape": "mesh", "file": "wedge.obj", "scale": 2.0, "position": [9, 9, 5]},
]
WEDGE = "v -0.1 0 0\nv 0.3 0 0\nv 0 0.2 0\nv 0 0 0.4\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


@pytest.mark.parametrize("robot", SPATIAL)
@pytest.mark.usefixtures("quiet")
def test_gymnasium_finds_no_fault_in_space(write: Write, tmp_path: Path, robot: str) -> None:
    entry = SPATIAL[robot]
    (tmp_path / "wedge.obj").write_text(WEDGE, "utf-8")
    content = {
        "robot": entry,
        "environment": {"engine": "pybullet", "duration": 0.5, "dynamics": entry.get("control") == "torque"},
        "start": {"q": PANDA} if robot == "panda" else {},
        "goal": [{"type": "orientation", "link": LINKS.get(robot, "base"), "target": [1, 0, 0, 0], "tolerance": 0.1}],
        "obstacles": SHAPES,
    }
    environment = gymnasium.make("lpb/Scenario-v0", scenario=write(content))
    check_env(environment.unwrapped, skip_render_check=True)
    observation, info = environment.reset(seed=1)
    expected = [[0.4] * 3, [0.1, 0.2, 0.3], [0.4, 0.4, 1.0], [0.4, 0.4, 1.4], [1.2, 0.8, 1.6]]
    assert_allclose(observation["obstacle_size"], expected, rtol=1e-6)
    assert info["robot_radius"] == {"point_3d": 0.2, "cart": 0.2, "car": 0.0, "panda": 0.0}.get(robot, 0.05)
    environment.close()


PANDA = [0.0, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8]
LINKS = {"point_3d": "body", "panda": "panda_hand"}


@pytest.mark.usefixtures("quiet")
def test_gymnasium_finds_no_fault_with_a_drawn_number_of_obstacles(write: Write) -> None:
    environment = gymnasium.make("lpb/Scenario-v0", scenario=write(family(randomize=COUNTED)))
    check_env(environment.unwrapped, skip_render_check=True)


def test_importing_the_package_registers_it() -> None:
    for program in ("import gymnasium, pytest_lpb", "import gymnasium, pytest_lpb.environment"):
        code = f"{program}; print('lpb/Scenario-v0' in gymnasium.registry)"
        result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert result.stdout.strip() == "True"


def box_of(path: Path, **keywords: Any) -> spaces.Box:
    space = ScenarioEnvironment(path, **keywords).action_space
    assert isinstance(space, spaces.Box)
    assert space.is_bounded("both")
    assert space.dtype == np.float64
    return space


def test_the_action_space_is_finite_and_has_the_limits(write: Write) -> None:
    accelerating = box_of(write(family()))
    assert_array_equal(accelerating.low, [-4.0, -10.0])
    assert_array_equal(accelerating.high, [3.0, 10.0])
    assert_array_equal(box_of(write(family(control="velocity"))).low, [-2.0, -1.0])
    assert_array_equal(box_of(write(family()), action_bound=2.0).high, [3.0, 2.0])
    arm = write(family("planar_arm"))
    assert_array_equal(box_of(arm).high, [10.0] * 3)
    assert_array_equal(box_of(arm, action_bound=[1, 2.5, 3]).low, [-1.0, -2.5, -3.0])
    wrong: tuple[Any, ...] = (0.0, -1, np.inf, np.nan, [1.0, 2.0], "wide", None)
    for bound in wrong:
        with pytest.raises(LpbError, match=r"action_bound: found .*; allowed: a positive number, or a list of 3"):
            ScenarioEnvironment(arm, action_bound=bound)


def test_the_bound_of_the_space_limits_no_action(write: Write) -> None:
    environment = gymnasium.make("lpb/Scenario-v0", scenario=write(family("planar_arm")), action_bound=0.5).unwrapped
    assert isinstance(environment, ScenarioEnvironment)
    environment.reset(seed=0)
    environment.step([40.0, 0.0, 0.0])
    assert (environment.applied[0], environment.saturated_steps) == (40.0, 0)


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


def test_without_a_seed_problems_differ(write: Write) -> None:
    environment, other = (ScenarioEnvironment(write(family(seed=11))) for _ in range(2))
    environment.reset()
    other.reset()
    assert environment.problem.seed != other.problem.seed
    environment.reset(seed=5)
    environment.reset()
    after = environment.problem.seed
    other.reset(seed=5)
    other.reset()
    assert other.problem.seed == after != 5


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_parallel_environments_start_with_different_problems(write: Write, mode: str) -> None:
    path = write(family())
    # As gymnasium.make_vec does, with environments in processes of their own under `async`.
    vector = gymnasium.make_vec("lpb/Scenario-v0", num_envs=3, vectorization_mode=mode, scenario=str(path))
    try:
        goals = vector.reset()[0]["goal_reach"]
        assert len({tuple(goal) for goal in goals.tolist()}) == 3
        seeded, _ = vector.reset(seed=7)
        expected = [draw_problem(load_scenario(path), seed).to_dict()["goal"][0]["target"] for seed in (7, 8, 9)]
        assert_array_equal(seeded["goal_reach"], expected)
        assert {array.dtype for array in seeded.values()} == {np.dtype(np.float64)}
        assert list(seeded) == list(vector.single_observation_space.spaces)  # type: ignore[attr-defined] # a Dict
    finally:
        vector.close()


def test_the_order_of_an_observation_is_ours(write: Write) -> None:
    environment = ScenarioEnvironment(write(family(randomize=COUNTED)))
    observation, _ = environment.reset(seed=1)
    space = environment.observation_space
    assert list(space.spaces) == list(observation) == ORDER
    flat = spaces.flatten(space, observation)
    assert isinstance(flat, np.ndarray)
    assert_array_equal(flat, np.concatenate([observation[key].ravel() for key in ORDER]))
    wrapped = gymnasium.wrappers.RescaleAction(
        gymnasium.wrappers.FlattenObservation(environment), np.float64(-1.0), np.float64(1.0)
    )
    assert wrapped.reset(seed=1)[0].shape == flat.shape
    assert isinstance(wrapped.action_space, spaces.Box)
    assert_array_equal(wrapped.action_space.high, [1.0, 1.0])


def test_what_is_said_of_the_robot_and_the_goal(write: Write) -> None:
    environment = ScenarioEnvironment(write(family()))
    _, info = environment.reset(seed=0)
    assert (info["robot_radius"], info["goal_tolerance"]) == (0.2, 0.1)
    assert environment.step([0.0, 0.0])[4]["robot_radius"] == 0.2
    turn = {"name": "turn", "type": "orientation", "link": "end", "target": [1.0], "primary": True}
    reach = {"type": "position", "link": "end", "target": [1.0, 1.5], "tolerance": 0.1}
    _, info = ScenarioEnvironment(write(family("planar_arm", goal=[reach, turn], randomize=None))).reset()
    assert info["robot_radius"] == 0.1
    assert info["goal_tolerance"] == np.inf


WRONG_OPTIONS: list[tuple[Any, str]] = [
    ({"problme": 1}, r"options: unknown 'problme'; did you mean 'problem'\?; allowed: problem"),
    ({"seed": 1}, "options: unknown 'seed'; allowed: problem"),
    ({3: 1}, "options: unknown 3; allowed: problem"),
    ([1], r"options: found \[1\]; a dict is needed"),
]


@pytest.mark.parametrize(("options", "message"), WRONG_OPTIONS)
def test_wrong_options(write: Write, options: Any, message: str) -> None:
    environment = ScenarioEnvironment(write(family()))
    environment.reset(seed=3, options={})
    with pytest.raises(LpbError, match=message):
        environment.reset(seed=4, options=options)
    assert environment.problem.seed == 3


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
ORDER = [
    *("t", "q", "qd", "u"),
    *("goal_reach", "goal_reach_velocity", "goal_reach_acceleration"),
    *("goal_position", "goal_velocity", "goal_acceleration"),
    *("obstacle_position", "obstacle_velocity", "obstacle_acceleration", "obstacle_orientation", "obstacle_size"),
    "obstacle_present",
]
KEYS = {*ORDER} - {"obstacle_present"}


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
        radii = [obstacle.radius or 0.0 for obstacle in environment.problem.obstacles]
        assert_array_equal(observation["obstacle_size"], [[2.0 * r] * 2 for r in [*radii, *[0.0] * (5 - number)]])
    assert counts == {2, 3, 4, 5}


def test_a_problem_in_place_of_a_scenario() -> None:
    problem = make_problem()
    environment = ScenarioEnvironment(problem=problem)
    observation, info = environment.reset(seed=99)  # one problem, whatever the seed
    assert environment.problem is problem
    assert observation["obstacle_position"].shape == (0, 2)
    assert info["outcome"] == "running"
    assert info["clearance"] == np.inf


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
