"""The PyBullet engine: exact motion, determinism, gymnasium's rules, simulated forces, and what it leaves behind."""

from __future__ import annotations

import subprocess
import sys
from math import cos, pi, sin, tan
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import pytest_lpb.environment  # noqa: F401 - registers lpb/Scenario-v0
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.errors import DivergedError, LpbError
from pytest_lpb.problem.spatial.library import known_robots
from pytest_lpb.problem.spatial.pool import close_idle_worlds
from tests.problem.spatial.entries import PANDA_START, panda_entry, point_entry, problem_of, scenario_entry

MOBILE = {"base_size": [0.7, 0.5, 0.3], "base_pose": {"position": [0.1, 0.0, 0.3]}}
EXAMPLE_ROBOTS = "example_robot_data"


def robot_entries() -> dict[str, dict[str, Any]]:
    """A scenario of every robot, fixed and moving."""
    entries = {
        "point_3d": point_entry(0.1, []),
        "arm_3d": scenario_entry({"model": "arm_3d", "links": 3}, joint="joint1"),
        "cart": scenario_entry({"model": "cart"}, joint="x"),
        "car": scenario_entry({"model": "car"}, joint="x"),
        "mobile panda": panda_entry(
            robot={"base": "differential_drive", **MOBILE}, start={"q": [0, 0, 0, *PANDA_START]}
        ),
        "holonomic panda": panda_entry(robot={"base": "holonomic", **MOBILE}, start={"q": [0, 0, 0, *PANDA_START]}),
        "panda on a car": panda_entry(robot={"base": "bicycle", **MOBILE}, start={"q": [0, 0, 0, 0, *PANDA_START]}),
    }
    middle = {"panda": PANDA_START}
    joints = dict.fromkeys(("husky", "racecar", "tiago", "tiago_dual", "tiago_no_hand"), "x")
    for name in known_robots():
        entries[name] = scenario_entry({"model": name}, joint=joints.get(name, ""))
        if name in ("tiago", "tiago_dual"):  # parts of a hand overlap in many configurations
            entries[name]["robot"]["self_collision_pairs"] = []
        if name in middle:
            entries[name]["start"] = {"q": middle[name]}
    return entries


ENTRIES = robot_entries()


def completed(entry: dict[str, Any]) -> dict[str, Any]:
    """An entry whose goal and start fit its robot, whatever joints it has."""
    from pytest_lpb.scenario.schema.robot import Robot
    from pytest_lpb.scenario.spatial import SpatialDescription

    description = SpatialDescription(Robot.model_validate(entry["robot"]))
    structure = description.structure
    limits = [limit or [-1.0, 1.0] for limit in structure.position_limits]
    start = entry.get("start", {}).get("q") or [0.5 * (low + high) for low, high in limits]
    goal = {"type": "joint", "joints": [structure.joints[0]], "target": [start[0] + 0.1], "tolerance": 0.2}
    limited = {
        "velocity": [[-1.0, 1.0]] * len(structure.actions),
        "acceleration": [[-1.0, 1.0]] * len(structure.actions),
    }
    robot = {**entry["robot"], "limits": limited}  # gymnasium's checker wants actions to be bounded
    # Without obstacles the clearance is NaN, which the checker finds unequal to itself.
    far = {"name": "far", "shape": "sphere", "radius": 0.1, "position": [5.0, 5.0, 5.0]}
    return {**entry, "robot": robot, "start": {"q": start}, "goal": [goal], "obstacles": [far]}


@pytest.mark.filterwarnings("ignore:.*WARN:UserWarning")
@pytest.mark.parametrize("name", ENTRIES)
def test_gymnasium_s_checker_passes_for_every_robot(name: str, tmp_path: Path) -> None:
    if name in ("double_pendulum", "kinova", "ur3", "ur5", "ur5_gripper", "ur10") or "tiago" in name:
        pytest.importorskip("importlib.metadata").distribution("example-robot-data")
    path = tmp_path / "scenario.yaml"
    path.write_text(dump_yaml(completed(ENTRIES[name])), encoding="utf-8")
    environment = gymnasium.make("lpb/Scenario-v0", scenario=path)
    check_env(environment.unwrapped, skip_render_check=True)
    environment.close()


def run(problem: Any, actions: Any, steps: int) -> list[tuple[list[float], list[float]]]:
    """States (q, u) after each of some steps."""
    environment = ScenarioEnvironment(problem=problem)
    states = []
    for step in range(steps):
        environment.step(actions(step))
        states.append((list(environment.running_engine.q), list(environment.running_engine.u)))
    environment.close()
    return states


def test_constant_acceleration_has_its_closed_form(tmp_path: Path) -> None:
    entry = panda_entry(environment={"duration": 1.0, "end_at": []})
    entry["robot"]["limits"] = {"velocity": [None] * 7}
    acceleration = [0.5, -0.4, 0.3, 0.2, -0.3, 0.4, -0.5]
    states = run(problem_of(tmp_path, entry), lambda _: acceleration, 100)
    for step, (q, u) in enumerate(states, start=1):
        t = 0.01 * step
        expected = [q0 + 0.5 * a * t * t for q0, a in zip(PANDA_START, acceleration, strict=True)]
        assert np.abs(np.subtract(q, expected)).max() < 1e-9
        assert np.abs(np.subtract(u, [a * t for a in acceleration])).max() < 1e-9


def test_a_car_drives_its_circle(tmp_path: Path) -> None:
    entry = scenario_entry(
        {"model": "car", "control": "velocity"}, joint="x", start={"q": [0, 0, 0, 0.3]}, environment={"end_at": []}
    )
    states = run(problem_of(tmp_path, entry), lambda _: [1.5, 0.0], 100)
    radius, turn = 0.5 / tan(0.3), 1.5 * 1.0 * tan(0.3) / 0.5
    assert states[-1][0] == pytest.approx([radius * sin(turn), radius * (1.0 - cos(turn)), turn, 0.3], abs=1e-9)


def test_a_mobile_manipulator_drives_and_moves_its_arm(tmp_path: Path) -> None:
    robot = {"base": "differential_drive", "control": "velocity", **MOBILE}
    entry = panda_entry(robot=robot, start={"q": [0, 0, 0, *PANDA_START]}, environment={"end_at": []})
    action = [0.4, 0.5 * pi, *([0.1] * 7)]
    q, u = run(problem_of(tmp_path, entry), lambda _: action, 100)[-1]
    radius = 0.4 / (0.5 * pi)
    assert q[:3] == pytest.approx([radius, radius, 0.5 * pi], abs=1e-9)
    assert q[3:] == pytest.approx([start + 0.1 for start in PANDA_START], abs=1e-9)
    assert u == action


def test_same_actions_same_bits_after_others_and_in_another_process(tmp_path: Path) -> None:
    ball = {"name": "ball", "shape": "sphere", "radius": 0.15, "trajectory": ["0.7 - 0.2*t", "0.3", "0.6"]}
    entry = panda_entry([ball], environment={"end_at": []})
    problem = problem_of(tmp_path, entry)

    def course() -> list[Any]:
        environment = ScenarioEnvironment(problem=problem)
        rows: list[Any] = []
        for step in range(50):
            environment.step([sin(0.1 * step + joint) for joint in range(7)])
            monitor = environment.monitor
            rows.append((environment.running_engine.q, monitor.clearance, monitor.self_clearance, monitor.goal_errors))
        environment.close()
        return rows

    first = course()
    other = ScenarioEnvironment(problem=problem_of(tmp_path, point_entry(0.1, [ball])))
    again = course()
    other.close()
    close_idle_worlds()
    assert first == again == course()
    code = (
        "from pathlib import Path\n"
        "from math import sin\n"
        "from pytest_lpb.environment.environment import ScenarioEnvironment\n"
        f"environment = ScenarioEnvironment(Path({str(tmp_path / 'panda.yaml')!r}))\n"
        "for step in range(50):\n"
        "    environment.step([sin(0.1 * step + joint) for joint in range(7)])\n"
        "print(repr((environment.running_engine.q, environment.monitor.clearance)))\n"
    )
    (tmp_path / "panda.yaml").write_text(dump_yaml(entry), encoding="utf-8")
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert found.stdout.strip() == repr((first[-1][0], first[-1][1]))
    assert found.stderr == ""


def test_environments_beside_each_other_do_not_meet(tmp_path: Path) -> None:
    near = {"name": "ball", "shape": "sphere", "radius": 0.2, "position": [0.5, 0.0, 0.0]}
    free = problem_of(tmp_path, point_entry(0.1, []))
    blocked = problem_of(tmp_path, point_entry(0.1, [near]))
    environments = [ScenarioEnvironment(problem=problem) for problem in (free, blocked, free, blocked)]
    clearances = [environment.monitor.clearance[0] for environment in environments]
    assert clearances[1] == clearances[3] == pytest.approx(0.2, abs=1e-9)
    assert np.isnan(clearances[0])
    assert np.isnan(clearances[2])
    for environment in environments:
        environment.close()
        environment.close()
    with pytest.raises(LpbError, match="closed"):
        environments[0].reset()


def test_actions_beyond_measure_end_the_trial(tmp_path: Path) -> None:
    entry = point_entry(0.1, [], environment={"end_at": []})
    environment = ScenarioEnvironment(problem=problem_of(tmp_path, entry))
    with pytest.raises(DivergedError, match="beyond"):
        environment.step([1e12, 0.0, 0.0])
    environment.close()


def resident_mib() -> float:
    """Memory of this process."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * 4096 / 2**20


@pytest.mark.skipif(not Path("/proc/self/statm").is_file(), reason="memory is read from /proc")
def test_resets_and_environments_leave_nothing_behind(tmp_path: Path) -> None:
    ball = {"name": "ball", "shape": "sphere", "radius": 0.15, "position": [0.7, 0.3, 0.6]}
    problem = problem_of(tmp_path, panda_entry([ball]))
    environment = ScenarioEnvironment(problem=problem)
    for _ in range(500):
        environment.reset()
    before = resident_mib()
    for _ in range(3000):
        environment.reset()
    environment.close()
    assert resident_mib() - before < 5.0
    for _ in range(20):
        ScenarioEnvironment(problem=problem).close()
        close_idle_worlds()
    before = resident_mib()
    for _ in range(100):
        ScenarioEnvironment(problem=problem).close()
        close_idle_worlds()
    assert resident_mib() - before < 10.0


def test_motors_follow_velocities_and_accelerations(tmp_path: Path) -> None:
    entry = panda_entry(environment={"dynamics": True, "end_at": []}, robot={"control": "velocity"})
    q, u = run(problem_of(tmp_path, entry), lambda _: [0.2] * 7, 50)[-1]
    assert q == pytest.approx([start + 0.1 for start in PANDA_START], abs=0.01)
    assert u == pytest.approx([0.2] * 7, abs=0.01)
    entry = panda_entry(environment={"dynamics": True, "end_at": []})
    q, u = run(problem_of(tmp_path, entry), lambda _: [0.4] * 7, 50)[-1]
    assert q == pytest.approx([start + 0.5 * 0.4 * 0.25 for start in PANDA_START], abs=0.01)
    assert u == pytest.approx([0.2] * 7, abs=0.01)


@pytest.mark.parametrize("substeps", [1, 10])
def test_frames_after_simulated_steps_are_those_of_the_joints(substeps: int, tmp_path: Path) -> None:
    settings = {"dynamics": True, "end_at": [], "substeps": substeps}
    problem = problem_of(tmp_path, panda_entry(environment=settings, robot={"control": "velocity"}))
    environment = ScenarioEnvironment(problem=problem)
    for _ in range(5):
        environment.step([0.5] * 7)
        engine = environment.running_engine
        for index, expected in enumerate(problem.robot.frames(engine.q)):
            assert engine.frames[index][:3] == pytest.approx(expected[:3], abs=1e-9)
    environment.close()


def test_a_simulated_cart_follows_its_velocities(tmp_path: Path) -> None:
    entry = scenario_entry(
        {"model": "cart", "control": "velocity"}, joint="x", environment={"dynamics": True, "end_at": []}
    )
    q, u = run(problem_of(tmp_path, entry), lambda _: [0.5, 0.5], 100)[-1]
    assert q == pytest.approx([sin(0.5), 1.0 - cos(0.5), 0.5], abs=0.02)
    assert u == pytest.approx([0.5, 0.5], abs=0.01)


def test_without_torques_an_arm_falls_and_gravity_is_there_after_each_reset(tmp_path: Path) -> None:
    settings = {"dynamics": True, "end_at": [], "duration": 0.3}
    robot = {"model": "arm_3d", "links": [0.5, 0.5], "control": "torque"}
    entry = scenario_entry(robot, joint="joint1", environment=settings)
    environment = ScenarioEnvironment(problem=problem_of(tmp_path, entry))
    falls = []
    for _ in range(2):
        environment.reset()
        for _ in range(20):
            environment.step([0.0, 0.0])
        falls.append(list(environment.running_engine.q))
    environment.close()
    assert falls[0][1] > 0.05  # about y, a positive angle lowers what lies along x
    assert falls[0] == pytest.approx(falls[1], abs=1e-12)


def test_torques_accelerate_a_joint_by_its_inertia(tmp_path: Path) -> None:
    settings = {"dynamics": True, "end_at": [], "gravity": [0, 0, 0], "substeps": 50}
    robot = {"model": "arm_3d", "links": [0.5], "control": "torque"}
    problem = problem_of(tmp_path, scenario_entry(robot, joint="joint1", environment=settings))
    inertial = problem.robot.urdf.link("link1").inertial  # type: ignore[attr-defined] # spatial
    moment = inertial.inertia[0, 0] + inertial.mass * 0.25**2
    q, _ = run(problem, lambda _: [0.1], 20)[-1]
    assert q[0] == pytest.approx(0.5 * 0.1 / moment * 0.2**2, rel=0.05)
