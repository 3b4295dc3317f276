"""What a scenario file may not say, by the text of its error, line included."""

# ruff: noqa: E501 - tables of one case a line

from pathlib import Path
from typing import Any, get_args

import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.scenario.schema.success import Outcome
from pytest_lpb.scenario.spatial import spatial_models
from pytest_lpb.scenario.structure import MODELS
from pytest_lpb.trial.outcome import OUTCOMES

# One part per line: faults of a part are found in its line.
PARTS = {
    "version": "1",
    "robot": "{model: planar_arm, links: 3, limits: {position: [[-2, 2], null, [-2.9, 2.9]]}}",
    "environment": "{dt: 0.05, duration: 10}",
    "start": "{q: [0, 0, 0]}",
    "goal": "[{name: reach, type: position, link: end, target: [2, 1], tolerance: 0.1}]",
    "obstacles": "[{shape: circle, radius: 0.1, position: [3, 3]}]",
}
LINES = {name: line for line, name in enumerate([*PARTS, "other"], start=1)}
POINT = "{model: point}"
DRIVE = "{model: differential_drive}"
NO_ZERO = "{model: planar_arm, links: 1, limits: {position: [[1, 2]]}}"


@pytest.fixture(autouse=True)
def working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def faults(**changes: str | None) -> tuple[str, ...]:
    """What is wrong with the base scenario after replacing, adding or (None) removing parts."""
    parts = {**PARTS, **changes}
    Path("x.yaml").write_text("".join(f"{name}: {text}\n" for name, text in parts.items() if text is not None))
    with pytest.raises(ScenarioError) as caught:
        load_scenario(Path("x.yaml"))
    return caught.value.faults


def faults_if_any(path: Path) -> tuple[str, ...]:
    """What is wrong with a file; empty when it loads."""
    try:
        load_scenario(path)
    except ScenarioError as error:
        return error.faults
    return ()


def check(part: str, text: str, *messages: str, **others: str | None) -> None:
    """One part with the given text has exactly these faults, in its line."""
    line = LINES.get(part, LINES["other"])
    expected = tuple(f"x.yaml:{line}: {message}" for message in messages)
    assert faults(**{**others, part: text}) == expected


def test_the_base_scenario_is_right() -> None:
    Path("x.yaml").write_text("".join(f"{name}: {text}\n" for name, text in PARTS.items()))
    assert load_scenario(Path("x.yaml")).concrete["robot"]["model"] == "planar_arm"


ROBOT_KEYS = (
    "base, base_pose, base_size, body_radius, collision, control, joints, limits, links, locked_joints, model, name, "
    "self_collision_pairs, urdf, wheel_base"
)


MODEL_NAMES = ", ".join(sorted({*MODELS, *spatial_models()}))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{model: point, limit: 3}", f"robot.limit: unknown key; did you mean 'limits'?; allowed: {ROBOT_KEYS}"),
        ("{model: planr_arm}", f"robot.model: unknown 'planr_arm'; did you mean 'planar_arm'?; allowed: {MODEL_NAMES}"),
        ("{name: a}", "robot: found neither of model and urdf; exactly one is required"),
        ("{model: point, urdf: a.urdf}", "robot: found both of model and urdf; exactly one is required"),
        ("{model: planar_arm}", "robot.links: is missing; planar_arm needs a count of links, or their lengths [m]"),
        ("{model: planar_arm, links: 0}", "robot.links: found 0 links; allowed are 1 to 100"),
        ("{model: planar_arm, links: true}", "robot.links: found the boolean true; a count of links, or a list of lengths [m], is required"),
        ("{model: planar_arm, links: [1, 1, -1]}", "robot.links[2]: found -1; allowed: greater than 0"),
        ("{model: planar_arm, links: 3, wheel_base: 1}", "robot.wheel_base: has no meaning for the model planar_arm; allowed: base, body_radius, collision, control, limits, links, model, name, self_collision_pairs"),
        ("{model: planar_arm, links: 3, base: holonomic}", "robot.base: holonomic is not available for the model planar_arm; allowed: fixed"),
        ("{model: planar_arm, links: 3, control: torque}", "robot.control: torque is not available with the engine planar; allowed: acceleration, velocity"),
        ("{model: planar_arm, links: 3, limits: {effort: [null, null, null]}}", "robot.limits.effort: has no meaning in the plane, where nothing is driven by forces"),
        ("{model: planar_arm, links: 3, control: speed}", "robot.control: found the text 'speed'; allowed: acceleration, velocity, torque"),
        ("{model: planar_arm, links: 3, body_radius: '0.1'}", "robot.body_radius: found the text '0.1'; a number is required"),
        ("{model: planar_arm, links: 3, body_radius: true}", "robot.body_radius: found the boolean true; a number is required"),
        ("{model: planar_arm, links: 3, body_radius: .nan}", "robot.body_radius: found nan; a finite number is required"),
        ("{model: planar_arm, links: 3, body_radius: 1e5}", "robot.body_radius: found 100000.0; allowed: at most 10000"),
        ("{model: planar_arm, links: 3, name: a b}", "robot.name: found the text 'a b'; a name is made of letters, digits, '_', '.' and '-', and does not begin with '.'"),
        ("{model: planar_arm, links: 3, limits: {position: [[1, -1], null, null]}}", "robot.limits.position[0]: found [1.0, -1.0]; the lower bound comes first"),
        ("{model: planar_arm, links: 3, limits: {position: [[-1, 1]]}}", "robot.limits.position: found 1 entries; 3 required: joint1, joint2, joint3"),
        ("{model: planar_arm, links: 3, limits: {velocity: [[-1, .inf], null, null]}}", "robot.limits.velocity[0][1]: found inf; a finite number is required"),
        ("{model: planar_arm, links: 3, collision: mesh}", "robot.collision: found the text 'mesh'; allowed: geometry, or a mapping with spheres or link_spheres"),
        ("{model: planar_arm, links: 3, collision: {}}", "robot.collision: found neither of spheres and link_spheres; exactly one is required"),
        ("{model: planar_arm, links: 3, collision: {spheres: {link4: [[0, 0, 0, 1]]}}}", "robot.collision.spheres.link4: unknown link 'link4'; did you mean 'link3' or 'link2' or 'link1'?; allowed: base, link1, link2, link3, end"),
        ("{model: planar_arm, links: 3, collision: {spheres: {link1: [[0, 0, 1, 1]]}}}", "robot.collision.spheres.link1[0]: found z = 1, r = 1; allowed: r > 0, and z = 0 for planar robots"),
        ("{model: planar_arm, links: 3, self_collision_pairs: [[base, end]]}", "robot.self_collision_pairs[0][1]: unknown body 'end'; allowed: base, link1, link2, link3"),
        ("{model: planar_arm, links: 3, self_collision_pairs: [[base, base]]}", "robot.self_collision_pairs[0]: found 'base' twice; each may be given once"),
        ("{model: planar_arm, links: 3, self_collision_pairs: [[base, link2], [link2, base]]}", "robot.self_collision_pairs[1]: found ['link2', 'base'] again; it is pair 0 already"),
    ],
)  # fmt: skip
def test_robot(text: str, message: str) -> None:
    check("robot", text, message)


@pytest.mark.parametrize(
    ("robot", "text", "message"),
    [
        (PARTS["robot"], "{q: [0, 0]}", "start.q: found 2 entries; 3 required: joint1, joint2, joint3"),
        (PARTS["robot"], "{q: [0, 0, 2.91]}", "start.q[2]: joint 3: 2.91 is outside [-2.9, 2.9]"),
        (PARTS["robot"], "{qd: [0]}", "start.qd: found 1 entries; 3 required: joint1, joint2, joint3"),
        (PARTS["robot"], "{u: [0, 0, 0]}", "start.u: has no meaning for the model planar_arm; its start velocity is qd: joint1, joint2, joint3"),
        (DRIVE, "{q: [0, 0]}", "start.q: found 2 entries; 3 required: x, y, theta"),
        (DRIVE, "{u: [0, 0, 0]}", "start.u: found 3 entries; 2 required: v, w"),
        (DRIVE, "{qd: [0, 0, 0]}", "start.qd: has no meaning for the model differential_drive; its start velocity is u: v, w"),
        (NO_ZERO, "{qd: [0]}", "start.q[0]: joint 1: 0 is outside [1, 2]; where start.q is not given, all joints start at 0"),
        (POINT, "{q: [0, 2e6]}", "start.q[1]: found 2000000.0; allowed: at most 1000000"),
        (POINT, "{q: [0, on]}", "start.q[1]: found the text 'on'; a number is required"),
    ],
)  # fmt: skip
def test_start(robot: str, text: str, message: str) -> None:
    link = {POINT: "body", DRIVE: "base"}.get(robot, "end")
    check("start", text, message, robot=robot, goal=PARTS["goal"].replace("end", link))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{engine: planer}", "environment.engine: found the text 'planer'; did you mean 'planar'?; allowed: planar, pybullet"),
        ("{dynamics: true}", "environment.dynamics: true is not available with the engine planar; allowed: false"),
        ("{substeps: 5}", "environment.substeps: has no meaning without dynamics: true"),
        ("{dynamics: on}", "environment.dynamics: found the text 'on'; true or false is required"),
        ("{dt: 0}", "environment.dt: found 0; allowed: at least 1e-05"),
        ("{dt: 0.3, duration: 1}", "environment.duration: 1 s is not a multiple of dt = 0.3 s; the nearest is 0.9"),
        ("{dt: 1, duration: 0.4}", "environment.duration: 0.4 s is not a multiple of dt = 1 s; the nearest is 1"),
        ("{dt: 1e-5, duration: 100}", "environment.duration: 100 s in steps of 1e-05 s are 10000000 steps; allowed are at most 1000000"),
        ("{end_at: [goal, goal]}", "environment.end_at: found 'goal' twice; each may be given once"),
        ("{end_at: [gaol]}", "environment.end_at[0]: found the text 'gaol'; did you mean 'goal'?; allowed: goal, violation"),
        ("{gravity: [0, 0]}", "environment.gravity: found a list of 2; at least 3 entries are required"),
        ("[1]", "environment: found a list of 1; a mapping is required"),
    ],
)  # fmt: skip
def test_environment(text: str, message: str) -> None:
    check("environment", text, message)


REACH = "{name: reach, type: position, link: end, target: [2, 1], tolerance: 0.1}"
POSITION_KEYS = (
    "axes, link, name, periodic, point, primary, relative_to, spline, target, tolerance, trajectory, type, weight"
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[]", "goal: found a list of 0; at least 1 entry is required"),
        ("[5]", "goal[0]: found 5; a mapping is required"),
        ("[{link: end}]", "goal[0]: type is missing; allowed: alignment, joint, orientation, position"),
        ("[{type: positon}]", "goal[0]: type: found the text 'positon'; did you mean 'position'?; allowed: alignment, joint, orientation, position"),
        ("[{type: position, link: end, target: [2, 1], tolerence: 0.1}]", f"goal[0].tolerence: unknown key; did you mean 'tolerance'?; allowed: {POSITION_KEYS}"),
        ("[{type: position, target: [2, 1], tolerance: 1}]", "goal[0].link: is missing"),
        ("[{type: position, link: end, target: [2, 1], tolerance: 0}]", "goal[0].tolerance: found 0; allowed: greater than 0"),
        ("[{type: position, link: end, target: [2, 1]}]", "goal: no sub-goal has a tolerance; without one success is undefined"),
        ("[{type: position, link: tip, target: [2, 1], tolerance: 1}]", "goal[0].link: unknown link 'tip'; allowed: base, link1, link2, link3, end"),
        ("[{type: position, link: end, target: [2, 1, 0], tolerance: 1}]", "goal[0].target: found 3 coordinates; required 2: coordinates [m]"),
        ("[{type: position, link: end, target: [2, 1], axes: [1], tolerance: 1}]", "goal[0].target: found 2 coordinates; required 1: one per axis"),
        ("[{type: position, link: end, target: [2], axes: [2], tolerance: 1}]", "goal[0].axes[0]: found 2; allowed are 0 to 1"),
        ("[{type: position, link: end, target: [2, 1], point: [0, 0, 0], tolerance: 1}]", "goal[0].point: found 3 coordinates; 2 required in the link's frame"),
        ("[{type: position, link: end, target: [2, 1], relative_to: end, tolerance: 1}]", "goal[0].relative_to: found 'end', the sub-goal's own link; allowed: another one"),
        ("[{type: position, link: end, tolerance: 1}]", "goal[0]: found none of target, trajectory, spline; exactly one is required"),
        ("[{type: position, link: end, target: [2, 1], trajectory: [t, t], tolerance: 1}]", "goal[0]: found target and trajectory of target, trajectory, spline; exactly one is required"),
        ("[{type: position, link: end, target: [2, 1], periodic: true, tolerance: 1}]", "goal[0].periodic: has no meaning without a spline"),
        ("[{type: position, link: end, trajectory: [1/t, 1], tolerance: 1}]", "goal[0].trajectory: '1/t' has the value inf at t = 0 s; allowed are finite numbers within ±1e+06"),
        ("[{type: position, link: end, trajectory: [t, true], tolerance: 1}]", "goal[0].trajectory[1]: found the boolean true; text is required"),
        ("[{type: position, link: end, spline: [[0, 1, 1], [0, 2, 2]], tolerance: 1}]", "goal[0].spline: row 1 has the time 0.0, not after 0.0; times must increase"),
        ("[{type: position, link: end, spline: [[0, 1], [1, 2]], tolerance: 1}]", "goal[0].spline: found 1 coordinates after the time; required 2: coordinates [m]"),
        ("[{type: orientation, link: end, target: [0, 1, 0, 0], tolerance: 1}]", "goal[0].target: found 4 coordinates; required 1: an angle [rad]"),
        ("[{type: joint, joints: [joint3, joint3], target: [1, 1], tolerance: 1}]", "goal[0].joints: found 'joint3' twice; each may be given once"),
        ("[{type: joint, joints: [elbow], target: [1], tolerance: 1}]", "goal[0].joints[0]: unknown joint 'elbow'; allowed: joint1, joint2, joint3"),
        ("[{type: joint, joints: [joint1, joint2], target: [1], tolerance: 1}]", "goal[0].target: found 1 coordinates; required 2: one per joint"),
        ("[{type: alignment, link: end, axis: [1, 0], other_axis: [0, 0], tolerance: 1}]", "goal[0].other_axis: found a vector of zeros; it has no direction"),
        ("[{type: alignment, link: end, axis: [1, 0, 0], other_axis: [0, 1], tolerance: 1}]", "goal[0].axis: found 3 numbers; 2 required"),
        ("[{type: alignment, link: end, axis: [1, 0], other: wrld, other_axis: [0, 1], tolerance: 1}]", "goal[0].other: unknown link 'wrld'; did you mean 'world'?; allowed: base, link1, link2, link3, end, world"),
        (f"[{REACH}, {REACH}]", "goal[1].name: 'reach' is the name of goal[0] already; names are unique"),
        (f"[{REACH}, {REACH.replace('reach', 'reach_velocity')}]", "goal[1].name: 'reach_velocity' makes the observation goal_reach_velocity, which goal[0] (reach) has already"),
        (f"[{REACH}, {REACH.replace('reach', 'position')}]", "goal[1].name: 'position' makes the observation goal_position, which the primary goal has already"),
        (f"[{REACH[:-1]}, primary: true}}, {REACH.replace('reach', 'b')[:-1]}, primary: true}}]", "goal[1].primary: goal[0] is primary already; one is allowed"),
    ],
)  # fmt: skip
def test_goal(text: str, message: str) -> None:
    check("goal", text, message)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{shape: circle}", "obstacles: found a mapping; a list is required"),
        ("[{radius: 1, position: [0, 0]}]", "obstacles[0]: shape is missing; allowed: box, capsule, circle, cylinder, mesh, rectangle, sphere"),
        ("[{shape: cirle, radius: 1, position: [0, 0]}]", "obstacles[0]: shape: found the text 'cirle'; did you mean 'circle'?; allowed: box, capsule, circle, cylinder, mesh, rectangle, sphere"),
        ("[{shape: sphere, radius: 1, position: [0, 0]}]", "obstacles[0].shape: sphere is not available with the engine planar; did you mean 'circle'?; allowed: circle, rectangle"),
        ("[{shape: cylinder, radius: 1, length: 1, position: [0, 0]}]", "obstacles[0].shape: cylinder is not available with the engine planar; allowed: circle, rectangle"),
        ("[{shape: circle, size: [1, 1], radius: 1, position: [0, 0]}]", "obstacles[0].size: unknown key; did you mean 'spline'?; allowed: name, orientation, periodic, position, radius, shape, spline, trajectory"),
        ("[{shape: rectangle, size: [1], position: [0, 0]}]", "obstacles[0].size: found a list of 1; at least 2 entries are required"),
        ("[{shape: rectangle, size: [1, 1, 1], position: [0, 0]}]", "obstacles[0].size: found a list of 3; allowed: at most 2"),
        ("[{shape: circle, radius: 1, position: [0, 0, 0]}]", "obstacles[0].position: found 3 coordinates; required 2: coordinates [m]"),
        ("[{shape: circle, radius: 1}]", "obstacles[0]: found none of position, trajectory, spline; exactly one is required"),
        ("[{shape: circle, radius: 1, position: [0, 0], orientation: sqrt(t)}]", "obstacles[0].orientation: 'sqrt(t)' has the velocity inf at t = 0 s; allowed are finite numbers within ±1e+12"),
        ("[{shape: circle, radius: 1, position: [0, 0], orientation: [1, 0, 0, 0]}]", "obstacles[0].orientation: found a list of 4; in the plane an angle [rad] is required"),
        ("[{shape: circle, radius: 1, position: [0, 0], name: drawn7}]", "obstacles[0].name: 'drawn7' is kept for drawn obstacles; choose another name"),
        ("[{shape: circle, radius: 1, position: [0, 0], name: obstacle1}, {shape: circle, radius: 1, position: [0, 0]}]", "obstacles[1].name: 'obstacle1' is the name of obstacles[0] already; names are unique"),
        ("[" + "{shape: circle, radius: 1, position: [0, 0]}, " * 1001 + "]", "obstacles: found a list of 1001; allowed: at most 1000"),
    ],
)  # fmt: skip
def test_obstacles(text: str, message: str) -> None:
    check("obstacles", text, message)


GROUP = "count: [3, 5], shape: circle, position: [[-1, 1], [-1, 1]], radius: [0.1, 1]"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{draw: [goal]}", "randomize.draw[0]: found goal, but randomize has no goal ranges"),
        ("{draw: [gaol], goal: [[0, 1], [0, 1]]}", "randomize.draw[0]: found the text 'gaol'; did you mean 'goal'?; allowed: start, goal, obstacles"),
        ("{start: {q: [[0, 1]]}}", "randomize.start.q: found 1 entries; 3 required: joint1, joint2, joint3"),
        ("{start: {q: [[0, 1], [0, 1], [0, 3]]}}", "randomize.start.q[2]: joint 3: [0, 3] reaches outside [-2.9, 2.9]"),
        ("{goal: {qq: [[0, 1], [0, 1], [0, 1]]}}", "randomize.goal.q: is missing"),
        ("{goal: [[0, 1]]}", "randomize.goal: found 1 ranges; 2 required, as the primary target has"),
        ("{obstacles: {count: 2, shape: circle}}", "randomize.obstacles.position: is missing"),
        (f"{{obstacles: {{{GROUP}, velocty: 1}}}}", "randomize.obstacles.velocty: unknown key; did you mean 'velocity'?; allowed: count, orientation, position, radius, shape, velocity"),
        (f"{{obstacles: [{{{GROUP.replace('circle', 'sphere')}}}]}}", "randomize.obstacles[0].shape: sphere is not available with the engine planar; did you mean 'circle'?; allowed: circle, rectangle"),
        (f"{{obstacles: [{{{GROUP.replace('circle', 'mesh')}}}]}}", "randomize.obstacles[0]: shape: found the text 'mesh'; allowed: box, capsule, circle, cylinder, rectangle, sphere"),
        (f"{{obstacles: [{{{GROUP.replace('[3, 5]', '[5, 3]')}}}]}}", "randomize.obstacles[0].count: found [5, 3]; the lower bound comes first"),
        (f"{{obstacles: [{{{GROUP.replace('[3, 5]', '[0, 1000]')}}}]}}", "randomize.obstacles: 1 listed and up to 1000 drawn obstacles; allowed are 1000 in total"),
        (f"{{obstacles: [{{{GROUP}, velocity: [[0, 0], [0, 1e6]]}}]}}", "randomize.obstacles[0].velocity: a drawn obstacle may go as far as 1e+07 m in 10 s; allowed are 1e+06 m"),
    ],
)  # fmt: skip
def test_randomize(text: str, message: str) -> None:
    found = faults(randomize=text)
    assert f"x.yaml:7: {message}" in found
    assert len(found) <= 2


@pytest.mark.parametrize(
    ("part", "text", "message"),
    [
        ("success", "{hold_time: long}", "success.hold_time: found the text 'long'; allowed: end, or a number [s]"),
        ("success", "{hold_time: -1}", "success.hold_time: found -1; allowed: at least 0"),
        ("success", "{hold_time: 11}", "success.hold_time: found 11 s; allowed: at most the duration, 10 s"),
        ("success", "{holdtime: 1}", "success.holdtime: found 1; a criterion such as '>= 0.02' is required; did you mean 'hold_time'?"),
        ("success", "{rate: '>= 80'}", "success.rate: found 80; a success rate lies between 0 and 1"),
        ("success", "{jerk: '== 1'}", "success.jerk: found the text '== 1'; a criterion is < <= > or >= and a number, such as '>= 0.02'"),
        ("success", "{a b: '> 1'}", "success.a b: is no name of a KPI; allowed: hold_time, rate, and names of KPIs"),
        ("seed", "-1", "seed: found -1; allowed: at least 0"),
        ("seed", "9223372036854775808", "seed: found 9223372036854775808; allowed: at most 9223372036854775807"),
        ("trials", "1.5", "trials: found 1.5; a whole number is required"),
        ("trials", "'5'", "trials: found the text '5'; a whole number is required"),
        ("trials", "1000001", "trials: found 1000001; allowed: at most 1000000"),
        ("tags", "[flaky]", "tags[0]: found 'flaky'; it means something to pytest itself: not allowed are filterwarnings, flaky, parametrize, skip, skipif, usefixtures, xdist_group, xfail"),
        ("tags", "[a, a]", "tags: found 'a' twice; each may be given once"),
        ("tags", "[not]", "tags[0]: found 'not'; -m cannot select and, or, not, nor names with a leading underscore"),
        ("tags", "[two words]", "tags[0]: found the text 'two words'; a name is made of letters, digits, '_', '.' and '-', and does not begin with '.'"),
        ("xfail", "{pd: {reason: a, outcomes: [crash]}}", "xfail.pd.outcomes[0]: found the text 'crash'; allowed: success, collision, self_collision, joint_limit, timeout, stalled, planner_error, infeasible, deadline, worker_crash, environment_error"),
        ("xfail", "{pd: {outcomes: [collision]}}", "xfail.pd.reason: is missing"),
        ("xfail", "{pd: {reason: a, seeds: [1, -2]}}", "xfail.pd.seeds[1]: found -2; allowed: at least 0"),
        ("xfail", "{pd: 5}", "xfail.pd: found 5; a mapping is required"),
        ("name", "a", "name: unknown key; allowed: certified, description, environment, goal, obstacles, randomize, robot, seed, source, start, success, tags, trials, version, xfail"),
    ],
)  # fmt: skip
def test_other_parts(part: str, text: str, message: str) -> None:
    check(part, text, message)


def test_a_moving_goal_cannot_be_drawn() -> None:
    moving = REACH.replace("target: [2, 1]", "trajectory: [sin(t), 1]")
    check("randomize", "{goal: [[0, 1], [0, 1]]}", "randomize.goal: goal[0] moves; only fixed targets can be drawn",
          goal=f"[{moving}]")  # fmt: skip
    check("randomize", "{goal: {q: [[0, 1], [0, 1], [0, 1]]}}",
          "randomize.goal: goal[1] moves; only fixed targets can be drawn",
          goal=f"[{REACH}, {moving.replace('reach', 'b')}]")  # fmt: skip


def test_a_box_is_for_positions() -> None:
    joint = "[{type: joint, joints: [joint1], target: [1], tolerance: 0.1}]"
    check("randomize", "{goal: [[0, 1]]}",
          "randomize.goal: a box is for a position, and the primary sub-goal is of type joint; allowed: {q: ranges}",
          goal=joint)  # fmt: skip


def test_the_engine_is_available() -> None:
    message = "environment.engine: pybullet does not have planar_arm; write environment: {engine: planar}"
    check("environment", "{engine: pybullet}", message, obstacles=None)


def test_rows_of_obstacles_are_bounded() -> None:
    check("randomize", f"{{obstacles: {{{GROUP.replace('[3, 5]', '500')}}}}}",
          "randomize.obstacles: 501 obstacles over 1000001 rows are 5.01e+08 recorded positions; allowed are 5e+07",
          environment="{dt: 1e-5, duration: 10}")  # fmt: skip


def test_version_is_required_and_known() -> None:
    assert faults(version="2") == ("x.yaml:1: version: found 2; allowed: 1",)
    assert faults(version=None) == ("x.yaml:1: version: is missing",)


def test_missing_parts() -> None:
    assert faults(robot=None, goal=None) == ("x.yaml:1: robot: is missing", "x.yaml:1: goal: is missing")


def test_the_last_seed_is_in_range_too() -> None:
    found = faults(seed=str(2**63 - 1), trials="2")
    assert found == (f"x.yaml:7: seed: 2 trials from seed {2**63 - 1} go beyond the largest seed, {2**63 - 1}",)


def test_faults_of_all_parts_come_at_once_in_the_order_of_lines() -> None:
    found = faults(
        robot="{model: planar_arm, links: 3, control: torque}",
        environment="{dt: 0.3, duration: 1}",
        start="{q: [0]}",
        goal="[{type: position, link: ende, target: [1, 1], tolerance: '1'}]",
        obstacles="[{shape: circle, radius: -1, position: [0, 0]}]",
    )
    assert found == (
        "x.yaml:2: robot.control: torque is not available with the engine planar; allowed: acceleration, velocity",
        "x.yaml:3: environment.duration: 1 s is not a multiple of dt = 0.3 s; the nearest is 0.9",
        "x.yaml:4: start.q: found 1 entries; 3 required: joint1, joint2, joint3",
        "x.yaml:5: goal[0].tolerance: found the text '1'; a number is required",
        "x.yaml:6: obstacles[0].radius: found -1; allowed: greater than 0",
    )


def test_many_faults_are_capped() -> None:
    found = faults(obstacles="[" + "{shape: circle, radius: -1, position: [0, 0]}, " * 30 + "]")
    assert len(found) == 21
    assert found[19] == "x.yaml:6: obstacles[19].radius: found -1; allowed: greater than 0"
    assert found[20] == "and 10 more"


def test_lines_of_nested_keys() -> None:
    Path("x.yaml").write_text(
        "version: 1\nrobot:\n  model: point\n  limits:\n    position:\n      - [0, 1]\n      - [0, one]\n"
        "goal:\n  - type: position\n    link: body\n    target:\n      - 1\n      - 1\n    tolerance: 0.1\n    tolerence: 1\n"
    )  # fmt: skip
    with pytest.raises(ScenarioError) as caught:
        load_scenario(Path("x.yaml"))
    assert [fault.split(": ")[:2] for fault in caught.value.faults] == [
        ["x.yaml:7", "robot.limits.position[1][1]"],
        ["x.yaml:15", "goal[0].tolerence"],
    ]


@pytest.mark.parametrize("value", ["null", "5", "text", "[]", "[[]]", "{}", "{a: 1}", "[null]", "[{}]", "true", ".nan"])
@pytest.mark.parametrize("part", [*PARTS, "randomize", "success", "xfail", "tags", "seed", "trials", "description"])
def test_no_value_of_a_part_breaks_loading(part: str, value: str) -> None:
    parts: dict[str, Any] = {**PARTS, part: value}
    Path("x.yaml").write_text("".join(f"{name}: {text}\n" for name, text in parts.items()))
    assert all(fault.startswith("x.yaml:") for fault in faults_if_any(Path("x.yaml")))


def test_outcomes_of_known_failures_are_those_of_trials() -> None:
    assert get_args(Outcome) == OUTCOMES
