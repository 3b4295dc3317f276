"""Speed of trials in space. Run `pytest tests/benchmarks -n 0`; no time is ever asserted."""

from __future__ import annotations

from math import sin
from pathlib import Path

import numpy as np
import pybullet
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.spatial.pool import close_idle_worlds
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.spatial.entries import panda_entry, problem_of, scenario_entry

SPHERES = [[0.7, 0.3, 0.6], [-0.5, 0.3, 0.2], [0.2, 0.8, 0.5], [0.5, -0.5, 0.8], [0.0, 0.5, 1.2]]
STEPS = 500
SHIPPED = Path(__file__).parents[2] / "scenarios"


def problem(folder: Path, *, moving: bool = False, dynamics: bool = False) -> Problem:
    """The Panda among five spheres, for 500 steps."""
    obstacles = []
    for index, (x, y, z) in enumerate(SPHERES):
        place = {"trajectory": [f"{x} + 0.1*sin(t)", f"{y}", f"{z}"]} if moving else {"position": [x, y, z]}
        obstacles.append({"name": f"o{index}", "shape": "sphere", "radius": 0.1, **place})
    settings = {"duration": 0.01 * STEPS, "end_at": [], "dynamics": dynamics}
    return problem_of(folder, panda_entry(obstacles, environment=settings))


def waving(step: int) -> list[float]:
    """An acceleration that moves all joints to and fro."""
    return [0.5 * sin(0.03 * step + 1.5 * joint) for joint in range(7)]


@pytest.mark.parametrize("moving", [False, True], ids=["static", "moving"])
def test_step_of_the_panda_among_five_spheres(benchmark: BenchmarkFixture, tmp_path: Path, moving: bool) -> None:
    """Exact clearance, limits, goal, observation: all of a step but planner and recording."""
    environment = ScenarioEnvironment(problem=problem(tmp_path, moving=moving), reuse_observations=True)
    actions = [waving(step) for step in range(STEPS)]

    def course() -> None:
        environment.reset()
        for action in actions:
            environment.step(action)

    benchmark(course)
    assert environment.row == STEPS
    environment.close()
    if benchmark.stats:
        benchmark.extra_info["us_per_step"] = round(1e6 * benchmark.stats["median"] / STEPS, 1)


def test_trial_of_the_panda_outside_the_planner(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """A whole trial with PD: setting up, stepping, recording. What is not the planner, per step, is in extra_info."""
    made = TrialSpecification(problem(tmp_path).to_dict(), PlannerConfiguration("pd", "pd"), "panda/benchmark")
    outside = []

    def trial() -> None:
        trajectory = run_trial(made)
        planner_s = float(np.nansum(trajectory.solver_wall_ms)) / 1e3
        outside.append((trajectory.metadata["wall_s"] - planner_s) / (len(trajectory) - 1))

    benchmark(trial)
    benchmark.extra_info["us_per_step_outside_the_planner"] = round(1e6 * float(np.median(outside)), 1)
    assert len(outside) > 0


def test_yardstick_a_simulated_step_of_the_panda(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """dynamics: true with 20 substeps, in the same run."""
    environment = ScenarioEnvironment(problem=problem(tmp_path, dynamics=True), reuse_observations=True)
    benchmark(environment.step, [0.0] * 7)
    assert environment.row > 0
    environment.close()


def test_yardstick_raw_pybullet(benchmark: BenchmarkFixture) -> None:
    """20 steps of bare physics with the Panda and five spheres, nothing measured."""
    import pybullet_data

    client = pybullet.connect(pybullet.DIRECT)
    folder = Path(pybullet_data.getDataPath())
    pybullet.loadURDF(str(folder / "franka_panda" / "panda.urdf"), useFixedBase=True, physicsClientId=client)
    for place in SPHERES:
        shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1, physicsClientId=client)
        pybullet.createMultiBody(0, shape, basePosition=place, physicsClientId=client)

    def substeps() -> None:
        for _ in range(20):
            pybullet.stepSimulation(physicsClientId=client)

    benchmark(substeps)
    assert pybullet.isConnected(client)
    pybullet.disconnect(physicsClientId=client)


@pytest.mark.parametrize("shape", ["sphere", "box", "cylinder"])
def test_distances_of_the_panda_s_hulls_to_one_obstacle(
    benchmark: BenchmarkFixture, tmp_path: Path, shape: str
) -> None:
    """Each hull is put where its link is, and measured; nothing is known from before."""
    sizes: dict[str, dict[str, object]] = {
        "sphere": {"radius": 0.1},
        "box": {"size": [0.2] * 3},
        "cylinder": {"radius": 0.1, "length": 0.3},
    }
    obstacle = {"name": "o", "shape": shape, "position": SPHERES[0], **sizes[shape]}
    made = problem_of(tmp_path, panda_entry([obstacle]))
    space, q = made.robot.collision_space(made.obstacles), made.start_q.tolist()
    distance, *_ = benchmark(space.clearance, q)
    space.close()
    assert distance > 0.0


def test_step_of_a_cart_of_a_cylinder(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """Cylinder against boxes."""
    boxes = [
        {"name": f"o{i}", "shape": "box", "size": [0.2] * 3, "position": [x, y, 0.2]}
        for i, (x, y, _) in enumerate(SPHERES)
    ]
    entry = scenario_entry({"model": "cart"}, boxes, joint="x", environment={"duration": 0.01 * STEPS, "end_at": []})
    environment = ScenarioEnvironment(problem=problem_of(tmp_path, entry), reuse_observations=True)

    def course() -> None:
        environment.reset()
        for step in range(STEPS):
            environment.step([0.1 * sin(0.03 * step), 0.1])

    benchmark(course)
    assert environment.row == STEPS
    environment.close()


def test_reset_of_the_same_problem(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    environment = ScenarioEnvironment(problem=problem(tmp_path))
    benchmark(environment.reset)
    assert environment.row == 0
    environment.close()


def test_reset_to_other_positions(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """Another problem of the same bodies: start and obstacles elsewhere."""
    first = problem(tmp_path)
    entry = first.to_dict()
    moved = [{**o, "position": [x + 0.05 for x in o["position"]]} for o in entry["obstacles"]]
    other = Problem.from_dict({**entry, "obstacles": moved})
    environment = ScenarioEnvironment(problem=first)
    problems = [other, first]

    def reset() -> None:
        problems.reverse()
        environment.reset(options={"problem": problems[0]})

    benchmark(reset)
    assert environment.row == 0
    environment.close()


def test_loading_the_panda_into_a_new_world(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    made = problem(tmp_path)

    def load() -> None:
        close_idle_worlds()
        ScenarioEnvironment(problem=made).close()

    benchmark(load)
    close_idle_worlds()
    assert made.steps == STEPS


def test_drawing_random_spheres_and_goals_for_the_panda(benchmark: BenchmarkFixture) -> None:
    scenario = load_scenario(SHIPPED / "panda" / "random_spheres.yaml")
    seeds = iter(range(1_000_000))
    benchmark(lambda: draw_problem(scenario, next(seeds)))
    assert scenario.trials > 1


def test_kinematics_of_the_panda(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """Flange pose and Jacobian, as planners ask for them at each call."""
    robot, q = problem(tmp_path).robot, np.array([1.0, 0.0, 0.0, -1.5, 0.0, 1.8675, 0.0])
    pose, _ = benchmark(robot.frame_and_jacobian, q, "panda_link8")  # type: ignore[attr-defined] # spatial
    assert pose.shape == (4, 4)
