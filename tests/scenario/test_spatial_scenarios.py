"""Scenarios in space: what they may not say, by the text of its error, and what their concrete form says."""

# ruff: noqa: E501 - tables of one case a line

import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import MissingRobotsError, ScenarioError
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.spatial import library
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.scenario.json_schema import scenario_json_schema
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.scenario.robots import structure_of
from pytest_lpb.scenario.schema.robot import Robot

from .test_schema_errors import faults_if_any
from .urdfs import TETRAHEDRON, joint, link, write_arm, write_urdf

# One part per line: faults of a part are found in its line.
PARTS = {
    "version": "1",
    "robot": "{urdf: arm.urdf}",
    "environment": "{engine: pybullet, dt: 0.05, duration: 10}",
    "start": "{q: [0, 0]}",
    "goal": "[{name: reach, type: position, link: lower, target: [0.5, 0.5, 0], tolerance: 0.1}]",
    "obstacles": "[{shape: sphere, radius: 0.1, position: [3, 3, 3]}]",
}
LINES = {name: line for line, name in enumerate([*PARTS, "other"], start=1)}
VALIDATOR = jsonschema.Draft202012Validator(scenario_json_schema())
UPRIGHT = [1.0, 0.0, 0.0, 0.0]


@pytest.fixture(autouse=True)
def working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with a URDF and two meshes."""
    monkeypatch.chdir(tmp_path)
    write_arm(Path("arm.urdf"))
    Path("rock.obj").write_text(TETRAHEDRON)
    Path("rock.txt").write_text("v")
    Path("path.csv").write_text("t,q0,q1\n")


def text_with(**changes: str | None) -> str:
    parts = {**PARTS, **changes}
    return "".join(f"{name}: {text}\n" for name, text in parts.items() if text is not None)


def concrete(**changes: str | None) -> dict[str, Any]:
    """The concrete form of the base scenario with changed parts; it loads as itself, and suits the JSON Schema."""
    Path("x.yaml").write_text(text_with(**changes))
    form = load_scenario(Path("x.yaml")).concrete
    Path("again.yaml").write_text(dump_yaml(form))
    assert repr(load_scenario(Path("again.yaml")).concrete) == repr(form)
    VALIDATOR.validate(form)
    return form


def robot_of(text: str, joint_name: str, start: str | None = None) -> dict[str, Any]:
    """The concrete form of a robot."""
    goal = f"[{{type: joint, joints: [{joint_name}], target: [0], tolerance: 0.1}}]"
    robot: dict[str, Any] = concrete(robot=text, goal=goal, start=start)["robot"]
    return robot


def check(part: str, text: str, *messages: str, **others: str | None) -> None:
    """One part with the given text has exactly these faults, in its line."""
    line = LINES.get(part, LINES["other"])
    Path("x.yaml").write_text(text_with(**{**others, part: text}))
    with pytest.raises(ScenarioError) as caught:
        load_scenario(Path("x.yaml"))
    assert caught.value.faults == tuple(f"x.yaml:{line}: {message}" for message in messages)


def test_the_base_scenario_is_right() -> None:
    assert concrete()["robot"]["name"] == "arm"


JOINTS = "allowed: j1, j2"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{urdf: no.urdf}", "robot.urdf: there is no file {here}/no.urdf"),
        ("{urdf: .}", "robot.urdf: found '{here.name}'; the name of a URDF file ends in .urdf"),
        ("{urdf: arm.xml}", "robot.urdf: found 'arm.xml'; the name of a URDF file ends in .urdf"),
        ("{urdf: arm.xacro}", "robot.urdf: found 'arm.xacro'; the name of a URDF file ends in .urdf; run xacro on it first and use what it writes"),
        ("{urdf: arm.urdf, links: 2}", "robot.links: has no meaning for robot; only arm_3d is made of links to measure"),
        ("{urdf: arm.urdf, body_radius: 0.1}", "robot.body_radius: has no meaning for robot, whose geometry is given"),
        ("{urdf: arm.urdf, base_size: [1, 1, 1]}", "robot.base_size: has no meaning for a fixed base; see base_pose"),
        ("{urdf: arm.urdf, base: holonomic, base_size: [1, 1]}", "robot.base_size: found a list of 2; at least 3 entries are required"),
        ("{urdf: arm.urdf, wheel_base: 1}", "robot.wheel_base: has no meaning for the base fixed"),
        ("{urdf: arm.urdf, base: hover}", "robot.base: found the text 'hover'; allowed: fixed, holonomic, differential_drive, bicycle"),
        ("{urdf: arm.urdf, joints: [j3]}", f"robot.joints[0]: unknown joint 'j3'; {JOINTS}"),
        ("{urdf: arm.urdf, joints: [j1, j1]}", "robot.joints: found 'j1' twice; each may be given once"),
        ("{urdf: arm.urdf, joints: []}", "robot.joints: robot has no joint that moves, and its base is fixed"),
        ("{urdf: arm.urdf, locked_joints: {j1: 0, j2: 0}}", "robot.joints: robot has no joint that moves, and its base is fixed"),
        ("{urdf: arm.urdf, locked_joints: {j7: 0}}", f"robot.locked_joints.j7: unknown joint 'j7'; {JOINTS}"),
        ("{urdf: arm.urdf, joints: [j1], locked_joints: {j1: 0}}", "robot.locked_joints.j1: joint 'j1' is planned; lock or plan it"),
        ("{urdf: arm.urdf, base_pose: {orientation: [0, 0, 0, 0]}}", "robot.base_pose.orientation: found [0.0, 0.0, 0.0, 0.0]; a vector of zeros has no direction"),
        ("{urdf: arm.urdf, base_pose: {position: [0, 0]}}", "robot.base_pose.position: found a list of 2; at least 3 entries are required"),
        ("{urdf: arm.urdf, collision: {spheres: {upper: [[0, 0, 0.1, 0]]}}}", "robot.collision.spheres.upper[0]: found z = 0.1, r = 0; allowed: r > 0, and z = 0 for planar robots"),
        ("{urdf: arm.urdf, collision: {spheres: {uper: [[0, 0, 0, 1]]}}}", "robot.collision.spheres.uper: unknown link 'uper'; did you mean 'upper'?; allowed: base, upper, lower"),
        ("{urdf: arm.urdf, self_collision_pairs: [[base, lowr]]}", "robot.self_collision_pairs[0][1]: unknown body 'lowr'; did you mean 'lower'?; allowed: base, upper, lower"),
        ("{urdf: arm.urdf, limits: {position: [[-1, 1]]}}", "robot.limits.position: found 1 entries; 2 required: j1, j2"),
        ("{urdf: arm.urdf, limits: {effort: []}}", "robot.limits.effort: found 0 entries; 2 required: j1, j2"),
        ("{urdf: arm.urdf, control: torque}", "robot.control: torque needs simulated forces; write environment: {{dynamics: true}}"),
        ("{model: kuka_iiwa, joints: [lbr_iiwa_joint_11]}", "robot.joints[0]: unknown joint 'lbr_iiwa_joint_11'; did you mean 'lbr_iiwa_joint_1' or 'lbr_iiwa_joint_7' or 'lbr_iiwa_joint_6'?; allowed: lbr_iiwa_joint_1, lbr_iiwa_joint_2, lbr_iiwa_joint_3, lbr_iiwa_joint_4, lbr_iiwa_joint_5, lbr_iiwa_joint_6, lbr_iiwa_joint_7"),
        ("{model: point_3d, base: holonomic}", "robot.base: holonomic is not available for point_3d, which moves by itself; allowed: fixed"),
        ("{model: arm_3d}", "robot.links: is missing; arm_3d needs a count of links, or their lengths [m]"),
        ("{model: racecar, joints: [left_steering_hinge_joint]}", "robot.joints[0]: joint 'left_steering_hinge_joint' is turned by the base's steering angle, delta; it can be neither planned nor locked"),
        ("{model: racecar, locked_joints: {right_steering_hinge_joint: 0}}", "robot.locked_joints.right_steering_hinge_joint: joint 'right_steering_hinge_joint' is turned by the base's steering angle, delta; it can be neither planned nor locked"),
        ("{model: panda, joints: [panda_joint8]}", "robot.joints[0]: joint 'panda_joint8' is fixed, or held by its limits; allowed: panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7, panda_finger_joint1"),
        ("{model: panda, joints: [panda_finger_joint2]}", "robot.joints[0]: joint 'panda_finger_joint2' mimics 'panda_finger_joint1'; allowed: panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7, panda_finger_joint1"),
    ],
)  # fmt: skip
def test_robot(text: str, message: str, tmp_path: Path) -> None:
    check("robot", text, message.format(here=tmp_path))


@pytest.mark.parametrize(
    "robot", ["{urdf: arm.urdf, base: holonomic, control: torque}", "{model: cart, control: torque}"]
)
def test_torques_drive_no_base(robot: str) -> None:
    base = "holonomic" if "urdf" in robot else "differential_drive"
    check("robot", robot, f"robot.control: torque is not available for the base {base}; allowed: fixed",
          environment="{engine: pybullet, dynamics: true}")  # fmt: skip


LINKS = (link("a"), link("b"))
J1 = joint("j1", "a", "b")


@pytest.mark.parametrize(
    ("parts", "more", "message"),
    [
        ((link("a"),), "", "robot.joints: robot has no joint that moves, and its base is fixed"),
        ((*LINKS, joint("j1", "a", "b", "fixed")), "", "robot.joints: robot has no joint that moves, and its base is fixed"),
        ((*LINKS, joint("j1", "a", "c")), "", "robot.urdf: {here}/odd.urdf:1: joint 'j1': its child 'c' is no link"),
        ((link("a", '<collision><geometry><mesh filename="no.stl"/></geometry></collision>'), link("b"), J1), "", "robot.urdf: {here}/odd.urdf:1: the mesh 'no.stl' is not there; looked for it from {here}"),
        ((link("lpb_world"), link("b"), joint("j1", "lpb_world", "b")), "", "robot.urdf: robot has a link called 'lpb_world'; names in lpb_ are kept for bases: rename it"),
        ((*LINKS, joint("lpb_mount", "a", "b")), "", "robot.urdf: robot has a joint called 'lpb_mount'; names in lpb_ are kept for bases: rename it"),
        ((link("mobile_base"), link("b"), joint("j1", "mobile_base", "b")), ", base: holonomic, base_size: [1, 1, 1]", "robot.urdf: robot has a link called 'mobile_base', as the box of base_size is; rename it in the URDF"),
        ((*LINKS, joint("theta", "a", "b")), ", base: holonomic", "robot.urdf: robot has joints called theta, as its base has; rename them in the URDF"),
        ((*LINKS, joint("j 1", "a", "b")), "", "robot.urdf: robot has a joint called 'j 1'; rename it in the URDF: a name is made of letters, digits, '_', '.' and '-', does not begin with '.', and has at most 100 characters"),
    ],
)  # fmt: skip
def test_urdf(parts: tuple[str, ...], more: str, message: str, tmp_path: Path) -> None:
    write_urdf(Path("odd.urdf"), parts)
    check("robot", f"{{urdf: odd.urdf{more}}}", message.format(here=tmp_path))


def test_names_that_clash_with_a_base_are_no_matter_without_it() -> None:
    write_urdf(Path("odd.urdf"), (link("mobile_base"), link("b"), joint("x", "mobile_base", "b")))
    assert robot_of("{urdf: odd.urdf}", "x")["joints"] == ["x"]


def test_too_many_joints() -> None:
    links = [link(f"l{index}") for index in range(102)]
    joints = [joint(f"j{index}", f"l{index}", f"l{index + 1}") for index in range(101)]
    write_urdf(Path("odd.urdf"), (*links, *joints))
    check("robot", "{urdf: odd.urdf}", "robot.joints: robot has 101 joints that move; name those to plan, at most 100")
    assert len(robot_of("{urdf: odd.urdf, joints: [j7]}", "j7")["locked_joints"]) == 100


def test_a_file_whose_stem_is_no_name() -> None:
    write_arm(Path("my arm.urdf"))
    check(
        "robot",
        "{urdf: my arm.urdf}",
        "robot.urdf: 'my arm' cannot be the robot's name; give it another with the key name",
    )
    assert robot_of("{urdf: my arm.urdf, name: mine}", "j1")["name"] == "mine"


@pytest.mark.parametrize(
    ("robot", "engine", "message"),
    [
        ("{urdf: arm.urdf}", "planar", "planar does not have a URDF robot; write environment: {engine: pybullet}"),
        ("{model: point_3d}", "planar", "planar does not have point_3d; write environment: {engine: pybullet}"),
        ("{model: point}", "pybullet", "pybullet does not have point; write environment: {engine: planar}"),
        ("{model: differential_drive}", "pybullet", "pybullet does not have differential_drive; write environment: {engine: planar}"),
    ],
)  # fmt: skip
def test_robot_and_engine_fit(robot: str, engine: str, message: str) -> None:
    names = {"{model: point}": "x", "{urdf: arm.urdf}": "j1"}
    goal = f"[{{type: joint, joints: [{names.get(robot, 'x')}], target: [0], tolerance: 0.1}}]"
    others: dict[str, str | None] = {"robot": robot, "goal": goal, "start": None, "obstacles": None}
    check("environment", f"{{engine: {engine}}}", f"environment.engine: {message}", **others)


def test_the_engine_of_a_spatial_robot_is_not_chosen_silently() -> None:
    check(
        "environment",
        "{dt: 0.05}",
        "environment.engine: planar does not have a URDF robot; write environment: {engine: pybullet}",
        obstacles=None,
    )


@pytest.mark.parametrize(
    ("robot", "text", "message"),
    [
        ("{urdf: arm.urdf}", "{q: [0]}", "start.q: found 1 entries; 2 required: j1, j2"),
        ("{urdf: arm.urdf}", "{q: [0, 1.5]}", "start.q[1]: joint 2: 1.5 is outside [-1, 1]"),
        ("{urdf: arm.urdf}", "{u: [0, 0]}", "start.u: has no meaning for this URDF robot; its start velocity is qd: j1, j2"),
        ("{urdf: arm.urdf, base: holonomic}", "{q: [0, 0]}", "start.q: found 2 entries; 5 required: x, y, theta, j1, j2"),
        ("{urdf: arm.urdf, base: differential_drive}", "{u: [0, 0]}", "start.u: found 2 entries; 4 required: v, w, j1, j2"),
        ("{urdf: arm.urdf, base: differential_drive}", "{qd: [0, 0, 0, 0]}", "start.qd: has no meaning for this URDF robot; its start velocity is u: v, w, j1, j2"),
        ("{urdf: arm.urdf, base: bicycle}", "{u: [0]}", "start.u: found 1 entries; 4 required: v, delta_rate, j1, j2"),
        ("{urdf: arm.urdf, base: bicycle}", "{q: [0, 0, 0, 0, 0]}", "start.q: found 5 entries; 6 required: x, y, theta, delta, j1, j2"),
        ("{urdf: arm.urdf, limits: {position: [[0.2, 1], null]}}", "{}", "start.q[0]: joint 1: 0 is outside [0.2, 1]; where start.q is not given, all joints start at 0"),
    ],
)  # fmt: skip
def test_start(robot: str, text: str, message: str) -> None:
    check("start", text, message, robot=robot)


def test_the_steering_angle_of_a_car_is_limited() -> None:
    goal = "[{type: joint, joints: [delta], target: [0], tolerance: 0.1}]"
    check(
        "start",
        "{q: [0, 0, 0, 0.7]}",
        "start.q[3]: joint 4: 0.7 is outside [-0.6, 0.6]",
        robot="{model: car}",
        goal=goal,
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{engine: pybullet, substeps: 4}", "environment.substeps: has no meaning without dynamics: true"),
        ("{engine: pybullet, dynamics: true, substeps: 0}", "environment.substeps: found 0; allowed: at least 1"),
        ("{engine: pybullet, dynamics: true, substeps: 2.5}", "environment.substeps: found 2.5; a whole number is required"),
    ],
)  # fmt: skip
def test_environment(text: str, message: str) -> None:
    check("environment", text, message)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{shape: circle, radius: 1, position: [3, 3, 3]}", ".shape: circle is not available with the engine pybullet; did you mean 'sphere'?; allowed: box, capsule, cylinder, mesh, sphere"),
        ("{shape: rectangle, size: [1, 1], position: [3, 3, 3]}", ".shape: rectangle is not available with the engine pybullet; did you mean 'box'?; allowed: box, capsule, cylinder, mesh, sphere"),
        ("{shape: sphere, radius: 1, position: [3, 3]}", ".position: found 2 coordinates; required 3: coordinates [m]"),
        ("{shape: box, size: [1, 1], position: [3, 3, 3]}", ".size: found a list of 2; at least 3 entries are required"),
        ("{shape: capsule, radius: 1, position: [3, 3, 3]}", ".length: is missing"),
        ("{shape: sphere, radius: 1, position: [3, 3, 3], orientation: 0.3}", ".orientation: found 0.3; in space a quaternion wxyz or {{axis, angle}} is required"),
        ("{shape: sphere, radius: 1, position: [3, 3, 3], orientation: 2*t}", ".orientation: found '2*t'; in space a quaternion wxyz or {{axis, angle}} is required"),
        ("{shape: sphere, radius: 1, position: [3, 3, 3], orientation: [0, 0, 0, 0]}", ".orientation: found [0.0, 0.0, 0.0, 0.0]; a vector of zeros has no direction"),
        ("{shape: sphere, radius: 1, position: [3, 3, 3], orientation: [1, 0, 0]}", ".orientation: found a list of 3; at least 4 entries are required"),
        ("{shape: sphere, radius: 1, position: [3, 3, 3], orientation: {axis: [0, 0, 0], angle: 1}}", ".orientation.axis: found [0.0, 0.0, 0.0]; a vector of zeros has no direction"),
        ("{shape: sphere, radius: 1, position: [3, 3, 3], orientation: {axis: [0, 0, 1]}}", ".orientation.angle: is missing"),
        ("{shape: sphere, radius: 1, position: [3, 3, 3], orientation: {axis: [0, 0, 1], angel: 1, angle: 1}}", ".orientation.angel: unknown key; did you mean 'angle'?; allowed: angle, axis"),
        ("{shape: sphere, radius: 1, position: [3, 3, 3], orientation: {axis: [0, 0, 1], angle: t +}}", ".orientation.angle: 't +' is no expression in t (invalid syntax); allowed: numbers, t, pi, + - * / **, and the functions sin cos tan exp sqrt abs"),
        ("{shape: mesh, file: no.obj, position: [3, 3, 3]}", ".file: there is no file {here}/no.obj"),
        ("{shape: mesh, file: rock.txt, position: [3, 3, 3]}", ".file: found 'rock.txt'; allowed are files .obj, .stl"),
        ("{shape: mesh, file: rock.obj, scale: 0, position: [3, 3, 3]}", ".scale: found 0; allowed: greater than 0"),
        ("{shape: mesh, file: rock.obj, concave: 1, position: [3, 3, 3]}", ".concave: found 1; true or false is required"),
    ],
)  # fmt: skip
def test_obstacles(text: str, message: str, tmp_path: Path) -> None:
    check("obstacles", f"[{text}]", "obstacles[0]" + message.format(here=tmp_path))


def test_a_mesh_that_is_too_large() -> None:
    with Path("huge.stl").open("wb") as file:
        file.truncate(100_000_001)  # takes no space
    check("obstacles", "[{shape: mesh, file: huge.stl, position: [3, 3, 3]}]",
          "obstacles[0].file: huge.stl: has 100000001 bytes; allowed are 100000000")  # fmt: skip


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{type: position, link: lower, target: [1, 1], tolerance: 1}", ".target: found 2 coordinates; required 3: coordinates [m]"),
        ("{type: position, link: lower, target: [1, 1, 1], point: [0, 0], tolerance: 1}", ".point: found 2 coordinates; 3 required in the link's frame"),
        ("{type: position, link: lowr, target: [1, 1, 1], tolerance: 1}", ".link: unknown link 'lowr'; did you mean 'lower'?; allowed: base, upper, lower"),
        ("{type: orientation, link: lower, target: 0.3, tolerance: 1}", ".target: found 1 coordinates; required 4: a quaternion wxyz"),
        ("{type: orientation, link: lower, target: [0, 0, 0, 0], tolerance: 1}", ".target: a quaternion of zeros is no orientation; allowed is any other, at all times"),
        ("{type: orientation, link: lower, trajectory: ['5 - t', 0, 0, 0], tolerance: 1}", ".trajectory: a quaternion of zeros is no orientation; allowed is any other, at all times"),
        ("{type: alignment, link: lower, axis: [1, 0], other_axis: [0, 0, 1], tolerance: 1}", ".axis: found 2 numbers; 3 required"),
        ("{type: joint, joints: [x], target: [0], tolerance: 1}", ".joints[0]: unknown joint 'x'; allowed: j1, j2"),
    ],
)  # fmt: skip
def test_goal(text: str, message: str) -> None:
    check("goal", f"[{text}]", f"goal[0]{message}")


GROUP = "count: 2, shape: capsule, position: [[-1, 1], [-1, 1], [2, 3]], radius: 0.1, length: [0.1, 0.3]"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (GROUP.replace(", [2, 3]]", "]"), ".position: found 2 ranges; 3 required in space"),
        (GROUP + ", velocity: [[0, 1], [0, 1]]", ".velocity: found 2 ranges; 3 required in space"),
        (GROUP.replace("capsule", "circle").replace(", length: [0.1, 0.3]", ""), ".shape: circle is not available with the engine pybullet; did you mean 'sphere'?; allowed: box, capsule, cylinder, mesh, sphere"),
        (GROUP.replace(", length: [0.1, 0.3]", ""), ".length: is missing"),
        (GROUP + ", orientation: [1, 0, 0, 0]", ".orientation: found a list of 4; allowed: at most 2"),
    ],
)  # fmt: skip
def test_drawn_groups(text: str, message: str) -> None:
    place = "randomize.obstacles[0]" if ".shape" in message or "ranges" in message else "randomize.obstacles"
    check("randomize", f"{{obstacles: {{{text}}}}}", place + message)


def test_ranges_of_the_start_lie_within_the_limits_of_the_urdf() -> None:
    check(
        "randomize",
        "{start: {q: [[0, 1], [0, 1.5]]}}",
        "randomize.start.q[1]: joint 2: [0, 1.5] reaches outside [-1, 1]",
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{seed: 0, length_m: 1, path: no.csv}", ".path: there is no file {here}/no.csv"),
        ("{seed: 0, length_m: 0, path: path.csv}", ".length_m: found 0; allowed: greater than 0"),
        ("{length_m: 1, path: path.csv}", ".seed: is missing"),
        ("{seed: 0, length: 1}", ".length_m: is missing"),
    ],
)  # fmt: skip
def test_certified(text: str, message: str, tmp_path: Path) -> None:
    Path("x.yaml").write_text(text_with(certified=text))
    with pytest.raises(ScenarioError) as caught:
        load_scenario(Path("x.yaml"))
    assert caught.value.faults[0] == f"x.yaml:7: certified{message.format(here=tmp_path)}"


def test_a_robot_that_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "_example_robot_data_folder", lambda: None)
    Path("x.yaml").write_text(text_with(robot="{model: ur5}"))
    with pytest.raises(MissingRobotsError) as caught:
        load_scenario(Path("x.yaml"))
    assert caught.value.faults == (
        "x.yaml:2: robot.model: the robot ur5 comes with the package example-robot-data, which is not installed: "
        "pip install 'pytest-lpb[robots]'",
    )


VALUES = (
    "null",
    "5",
    "-1",
    "text",
    "''",
    '"\\0"',
    "[]",
    "[[]]",
    "{}",
    "{a: 1}",
    "[null]",
    "[{}]",
    "true",
    ".nan",
    "[1, 2, 3]",
)
ROBOT_KEYS = sorted(set(Robot.model_fields) - {"model", "urdf"})


@pytest.mark.parametrize("value", VALUES)
@pytest.mark.parametrize(
    "robot", ["{{urdf: {}}}", "{{model: {}}}", *(f"{{{{urdf: arm.urdf, {key}: {{}}}}}}" for key in ROBOT_KEYS)]
)
def test_no_value_of_a_robots_key_breaks_loading(robot: str, value: str) -> None:
    Path("x.yaml").write_text(text_with(robot=robot.format(value)))
    assert all(fault.startswith("x.yaml:") for fault in faults_if_any(Path("x.yaml")))


@pytest.mark.parametrize("value", VALUES)
@pytest.mark.parametrize("part", ["environment", "start", "goal", "obstacles", "randomize", "certified"])
def test_no_value_of_a_part_breaks_loading(part: str, value: str) -> None:
    Path("x.yaml").write_text(text_with(**{part: value}))
    faults = faults_if_any(Path("x.yaml"))
    assert all(fault.startswith("x.yaml:") for fault in faults)
    assert faults or value in ("null", "{}", "[]")


# What follows says what the concrete form is.


def test_every_key_of_a_urdf_robot_is_filled_in(tmp_path: Path) -> None:
    assert robot_of("{urdf: arm.urdf}", "j1") == {
        "urdf": str(tmp_path / "arm.urdf"),
        "name": "arm",
        "joints": ["j1", "j2"],
        "locked_joints": {},
        "base": "fixed",
        "base_pose": {"position": [0.0, 0.0, 0.0], "orientation": UPRIGHT},
        "base_size": None,
        "wheel_base": None,
        "control": "acceleration",
        "body_radius": None,
        "collision": "geometry",
        "limits": {
            "position": [[-1.0, 1.0], [-1.0, 1.0]],
            "velocity": [[-2.0, 2.0], [-2.0, 2.0]],
            "acceleration": [None, None],
            "effort": [[-3.0, 3.0], [-3.0, 3.0]],
        },
        "self_collision_pairs": None,
    }


def test_files_are_relative_to_the_scenario(tmp_path: Path) -> None:
    folder = Path("somewhere/else")
    folder.mkdir(parents=True)
    Path("pytest.ini").touch()  # what lies below belongs to one project
    obstacle = f"[{{shape: mesh, file: ../../rock.obj, position: [3, 3, 3]}}, {{shape: mesh, file: {tmp_path}/rock.obj, position: [4, 4, 4]}}]"
    certified = "{seed: 0, length_m: 1, path: ../../path.csv}"
    (folder / "x.yaml").write_text(text_with(robot="{urdf: ../../arm.urdf}", obstacles=obstacle, certified=certified))
    form = load_scenario(folder / "x.yaml").concrete
    assert form["robot"]["urdf"] == str(tmp_path / "arm.urdf")
    assert [entry["file"] for entry in form["obstacles"]] == [str(tmp_path / "rock.obj")] * 2
    assert form["certified"] == {"seed": 0, "length_m": 1.0, "path": str(tmp_path / "path.csv")}
    assert Problem.from_dict(form).certified_path_length_m == 1.0


def test_default_planned_joints() -> None:
    links = [link(name) for name in "abcde"]
    mimic = joint("follower", "a", "c", more='<mimic joint="j1"/>')
    wheel = joint("left_wheel", "a", "d", "continuous")
    turn = joint("turntable", "a", "e", "continuous")
    write_urdf(Path("odd.urdf"), (*links, J1, mimic, wheel, turn))
    robot = robot_of("{urdf: odd.urdf}", "j1")
    assert robot["joints"] == ["j1", "turntable"]
    assert robot["locked_joints"] == {"left_wheel": 0.0}
    robot = robot_of("{urdf: odd.urdf, locked_joints: {turntable: 2}}", "j1")
    assert (robot["joints"], robot["locked_joints"]) == (["j1"], {"left_wheel": 0.0, "turntable": 2.0})
    assert robot_of("{urdf: odd.urdf, joints: [left_wheel, j1]}", "j1")["joints"] == ["left_wheel", "j1"]


def test_the_panda_plans_seven_joints() -> None:
    start = "{q: [0, 0, 0, -1, 0, 1, 0]}"
    robot = robot_of("{model: panda}", "panda_joint1", start)
    assert robot["joints"] == [f"panda_joint{index}" for index in range(1, 8)]
    assert robot["locked_joints"] == {"panda_finger_joint1": 0.02}
    assert robot["limits"]["effort"][-1] == [-12.0, 12.0]
    six = robot_of("{model: panda, locked_joints: {panda_joint7: 0.5}}", "panda_joint1", "{q: [0, 0, 0, -1, 0, 1]}")
    assert six["joints"] == [f"panda_joint{index}" for index in range(1, 7)]
    assert six["locked_joints"] == {"panda_joint7": 0.5, "panda_finger_joint1": 0.02}


def test_a_joint_that_cannot_be_zero_is_locked_as_near_as_it_can_be() -> None:
    write_arm(Path("odd.urdf"), limit='lower="0.2" upper="1"')
    assert robot_of("{urdf: odd.urdf, joints: [j2]}", "j2")["locked_joints"] == {"j1": 0.2}


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("", [[-1.0, 1.0], [-1.0, 1.0]]),
        (", limits: {velocity: null}", [[-1.0, 1.0], [-1.0, 1.0]]),
        (", limits: {position: [null, [-2, 0.5]]}", [None, [-2.0, 0.5]]),
        (", limits: {position: null}", [None, None]),
    ],
)
def test_absent_limits_are_those_of_the_urdf_and_null_is_unlimited(given: str, expected: list[Any]) -> None:
    limits = robot_of(f"{{urdf: arm.urdf{given}}}", "j1")["limits"]
    assert limits["position"] == expected
    assert limits["velocity"] == ([None, None] if "velocity" in given else [[-2.0, 2.0], [-2.0, 2.0]])


@pytest.mark.parametrize(
    ("limit", "expected"),
    [
        ('lower="-1e16" upper="1e16" velocity="1e10" effort="1e9"', (None, None, None)),
        ('lower="-1e16" upper="0.5" velocity="0" effort="0"', ([-1e6, 0.5], None, None)),
    ],
)
def test_limits_beyond_what_a_scenario_can_say(limit: str, expected: tuple[Any, ...]) -> None:
    write_arm(Path("odd.urdf"), limit=limit)
    limits = robot_of("{urdf: odd.urdf}", "j1")["limits"]
    assert tuple(limits[key][0] for key in ("position", "velocity", "effort")) == expected


def test_the_limit_that_holds_is_the_one_of_the_file() -> None:
    robot = "{urdf: arm.urdf, limits: {position: [null, [-3, 3]]}}"
    assert concrete(robot=robot, start="{q: [9, 2.5]}")["start"]["q"] == [9.0, 2.5]


@pytest.mark.parametrize(
    ("text", "joints", "actions", "wheel_base"),
    [
        ("base: holonomic", ["x", "y", "theta", "j1", "j2"], ["x", "y", "theta", "j1", "j2"], None),
        ("base: differential_drive", ["x", "y", "theta", "j1", "j2"], ["v", "w", "j1", "j2"], 0.5),
        ("base: bicycle, wheel_base: 0.8", ["x", "y", "theta", "delta", "j1", "j2"], ["v", "delta_rate", "j1", "j2"], 0.8),
    ],
)  # fmt: skip
def test_moving_bases(text: str, joints: list[str], actions: list[str], wheel_base: float | None) -> None:
    robot = f"{{urdf: arm.urdf, {text}, base_size: [0.8, 0.5, 0.3], base_pose: {{position: [0, 0, 0.3]}}}}"
    goal = "[{type: joint, joints: [x, j2], target: [1, 0], tolerance: 0.1}]"
    form = concrete(robot=robot, goal=goal, start=None)
    key = "qd" if "holonomic" in text else "u"
    assert form["start"] == {"q": [0.0] * len(joints), key: [0.0] * len(actions)}
    assert form["robot"]["base_size"] == [0.8, 0.5, 0.3]
    assert form["robot"]["wheel_base"] == wheel_base
    structure = structure_of(Robot.model_validate({**form["robot"], "limits": None}))
    assert structure is not None
    assert (list(structure.joints), list(structure.actions)) == (joints, actions)
    assert structure.links == ("mobile_base", "base", "upper", "lower")


@pytest.mark.parametrize(
    ("model", "joint_name"),
    [("point_3d", "x"), ("cart", "x"), ("car", "delta"), ("husky", "x"), ("racecar", "delta"), ("kuka_iiwa", "lbr_iiwa_joint_1")],
)  # fmt: skip
def test_robots_known_by_name_load_as_themselves(model: str, joint_name: str) -> None:
    assert robot_of(f"{{model: {model}}}", joint_name)["model"] == model


def test_an_arm_of_links_is_named_by_their_number() -> None:
    robot = robot_of("{model: arm_3d, links: [0.5, 0.4]}", "joint1")
    assert (robot["name"], robot["links"], robot["body_radius"]) == ("arm_3d_2", [0.5, 0.4], 0.05)


@pytest.mark.parametrize(
    "text",
    [
        "{urdf: arm.urdf}",
        "{urdf: arm.urdf, base: bicycle, base_size: [1, 1, 1], collision: {link_spheres: 0.2}}",
        "{urdf: arm.urdf, base: holonomic, collision: {spheres: {lower: [[0, 0, 0, 0.1]]}}}",
        "{urdf: arm.urdf, base: differential_drive, base_size: [1, 1, 1]}",
    ],
)
def test_the_structure_is_that_of_the_robot(text: str) -> None:
    joint_name = "j1"
    form = robot_of(text, joint_name)
    structure, robot = structure_of(Robot.model_validate(form)), SpatialRobot(form)
    assert structure is not None
    assert structure.joints == robot.joint_names
    assert len(structure.actions) == robot.n_actions
    assert structure.links == robot.link_names
    assert structure.bodies == robot.body_names
    assert (structure.velocity_key == "u") == robot.non_holonomic


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("", UPRIGHT),
        (", orientation: [2, 0, 0, 0]", UPRIGHT),
        (", orientation: [0, 3, 4, 0]", [0.0, 0.6, 0.8, 0.0]),
        (", orientation: {axis: [0, 0, 2], angle: 0.3}", {"axis": [0.0, 0.0, 2.0], "angle": 0.3}),
        (", orientation: {axis: [0, 0, 1], angle: 0.5*t}", {"axis": [0.0, 0.0, 1.0], "angle": "0.5*t"}),
    ],
)
def test_orientations_of_obstacles(given: str, expected: Any) -> None:
    text = f"[{{shape: box, size: [1, 2, 3], position: [5, 5, 5]{given}}}]"
    assert concrete(obstacles=text)["obstacles"][0]["orientation"] == expected


@pytest.mark.parametrize("quaternion", [[1, 2, 3, 4], [0.1, -0.7, 0.3, 0.2], [1e-3, 1e6, 7, -3]])
def test_to_normalise_again_changes_nothing(quaternion: list[float]) -> None:
    text = f"[{{shape: box, size: [1, 2, 3], position: [9, 9, 9], orientation: {quaternion}}}]"
    robot = f"{{urdf: arm.urdf, base_pose: {{orientation: {quaternion}}}}}"
    form = concrete(robot=robot, obstacles=text)  # it loads as itself, by repr
    assert sum(x * x for x in form["obstacles"][0]["orientation"]) == pytest.approx(1.0, abs=1e-15)
    assert form["robot"]["base_pose"]["orientation"] == form["obstacles"][0]["orientation"]


@pytest.mark.parametrize(
    ("text", "substeps"),
    [
        ("{engine: pybullet}", None),
        ("{engine: pybullet, dynamics: true}", 20),
        ("{engine: pybullet, dynamics: true, substeps: 4}", 4),
    ],
)
def test_substeps_belong_to_dynamics(text: str, substeps: int | None) -> None:
    environment = concrete(environment=text)["environment"]
    assert environment.get("substeps") == substeps


def test_torque_control_with_dynamics() -> None:
    form = concrete(robot="{urdf: arm.urdf, control: torque}", environment="{engine: pybullet, dynamics: true}")
    assert form["robot"]["control"] == "torque"


def test_certified_paths_are_kept_and_do_not_count_for_the_hash() -> None:
    plain = concrete()
    certified = concrete(certified="{seed: 3, length_m: 1.25, path: path.csv}")
    assert certified["certified"]["seed"] == 3
    assert concrete(certified="{seed: 3, length_m: 1.25}")["certified"] == {"seed": 3, "length_m": 1.25}
    assert "certified" not in plain
    assert Problem.from_dict(plain).problem_hash == Problem.from_dict(certified).problem_hash


def test_drawn_groups_in_space() -> None:
    Path("x.yaml").write_text(text_with(randomize=f"{{obstacles: {{{GROUP}, orientation: [0, 1]}}}}"))
    (group,) = load_scenario(Path("x.yaml")).randomize["obstacles"]
    assert group["length"] == [0.1, 0.3]
    assert group["orientation"] == [0.0, 1.0]


def test_the_problem_of_a_moved_scenario_has_the_same_hash(tmp_path: Path) -> None:
    obstacles = "[{shape: mesh, file: rock.obj, position: [3, 3, 3]}]"
    first = Problem.from_dict(concrete(obstacles=obstacles)).problem_hash
    other = tmp_path / "other"
    other.mkdir()
    for name in ("arm.urdf", "rock.obj", "x.yaml"):
        (other / name).write_bytes(Path(name).read_bytes())
    assert Problem.from_dict(load_scenario(other / "x.yaml").concrete).problem_hash == first
    (other / "rock.obj").write_text(TETRAHEDRON.replace("0.1", "0.2"))
    assert Problem.from_dict(load_scenario(other / "x.yaml").concrete).problem_hash != first


def test_loading_a_spatial_scenario_loads_no_physics() -> None:
    Path("x.yaml").write_text(text_with())
    program = (
        "import sys; from pathlib import Path; from pytest_lpb.scenario.load import load_scenario;"
        "load_scenario(Path('x.yaml')); print('pybullet' in sys.modules)"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "False"
