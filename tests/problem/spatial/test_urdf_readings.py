"""Where readers of URDF disagree: what is read here, and that PyBullet gets it so."""

from __future__ import annotations

from math import inf, pi
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pytest_lpb.environment.visuals import VisibleBodies
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.robot import robot_from
from pytest_lpb.problem.spatial.client import Client
from pytest_lpb.problem.spatial.library import installed_folders
from pytest_lpb.problem.spatial.meshes import mesh_vertices
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.tree import KinematicTree
from pytest_lpb.problem.spatial.urdf import UrdfModel
from pytest_lpb.problem.spatial.urdf_reader import check_meshes_present, load_urdf
from pytest_lpb.problem.spatial.urdf_writer import urdf_text
from pytest_lpb.problem.spatial.world import World
from pytest_lpb.report.replay.spatial import SpatialMotion
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.spatial import SpatialDescription
from tests.problem.spatial.problems import spatial_problem
from tests.problem.spatial.test_mesh_files import collada
from tests.scenario.urdfs import BOX, TETRAHEDRON, joint, link, mesh, write_urdf

LINKS = (link("a", ""), link("b"))
LINE = 8192  # bytes of a line that PyBullet reads at once


def read(folder: Path, *parts: str, head: str = '<robot name="r">') -> UrdfModel:
    path = write_urdf(folder / "r.urdf", parts)
    path.write_text(path.read_text("utf-8").replace('<robot name="robot">', head), "utf-8")
    return load_urdf(path)


def slide(name: str, parent: str, child: str, limit: str, more: str = "") -> str:
    return joint(name, parent, child, "prismatic", limit, more)


def robot_of(folder: Path, *parts: str, **keys: object) -> SpatialRobot:
    """The robot that a scenario has of these links and joints."""
    path = write_urdf(folder / "r.urdf", parts)
    robot = robot_from(SpatialDescription(Robot(urdf=str(path), **keys)).entry)  # type: ignore[arg-type] # by name
    assert isinstance(robot, SpatialRobot)
    return robot


# Orientation.


@pytest.mark.parametrize("quaternion", ["0 0 0.7071067811865476 0.7071067811865476", "0 0 -3 -3"])
def test_quaternions_turn_joints_shapes_and_centres_of_mass(quaternion: str, tmp_path: Path) -> None:
    origin = f'<origin xyz="0 0 0" quat_xyzw="{quaternion}"/>'
    body = f'<inertial>{origin}<mass value="1"/></inertial><collision>{origin}<geometry><box size="1 2 3"/></geometry>'
    turned = joint("j", "a", "b").replace('<origin xyz="0.5 0 0"/>', origin)
    model = read(tmp_path, link("a", ""), link("b", f"{body}</collision>"), turned, head='<robot version="1.1">')
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    inertial = model.link("b").inertial
    assert inertial is not None
    for pose in (model.joint("j").origin, model.link("b").collisions[0].origin, inertial.origin):
        assert pose[:3, :3] == pytest.approx(quarter)


@pytest.mark.parametrize(
    ("version", "origin", "message"),
    [
        ("1.1", 'rpy="0 0 0" quat_xyzw="0 0 0 1"', r"r\.urdf:1: found rpy and quat_xyzw; one of them is required"),
        ("1.1", 'quat_xyzw="0 0 0 0"', r"found a quaternion of zeros"),
        ("1.2", 'quat_xyzw="0 0 1"', r"quat_xyzw: found '0 0 1'; 4 finite numbers are required"),
        ("1.0", 'quat_xyzw="0 0 0 1"', r"found quat_xyzw, which readers of URDF 1\.0 pass over; write rpy, or"),
        ("2.0", "", r"r\.urdf:1: found the version '2\.0' of URDF; allowed: 1\.0, 1\.1"),
        ("one", "", r"found the version 'one' of URDF"),
    ],
)
def test_orientations_that_are_refused(version: str, origin: str, message: str, tmp_path: Path) -> None:
    turned = joint("j", "a", "b").replace("<origin", f"<origin {origin}")
    with pytest.raises(ScenarioError, match=message):
        read(tmp_path, *LINKS, turned, head=f'<robot version="{version}">')


def test_capsules_are_read_in_every_version(tmp_path: Path) -> None:
    capsule = link("b", '<collision><geometry><capsule radius="0.1" length="0.4"/></geometry></collision>')
    for head in ("<robot>", '<robot version="1"><!-- -->', '<robot version="1.2">'):
        model = read(tmp_path, link("a"), capsule, joint("j", "a", "b"), head=head)
        assert (model.link("b").collisions[0].kind, model.link("b").collisions[0].size) == ("capsule", (0.1, 0.4))


# Limits.


@pytest.mark.parametrize(
    ("kind", "limit", "expected"),
    [
        ("revolute", 'lower="-1" upper="2"', (-1.0, 2.0)),
        ("revolute", 'upper="1.5"', (0.0, 1.5)),  # the other bound is 0, as the format has it
        ("revolute", 'lower="-1.5"', (-1.5, 0.0)),
        ("revolute", "", (-inf, inf)),
        ("revolute", 'lower="0" upper="0"', (-inf, inf)),
        ("revolute", 'lower="1" upper="-1"', (-inf, inf)),
        ("continuous", 'lower="-1" upper="1"', (-inf, inf)),
        ("continuous", 'lower="1" upper="1"', (-inf, inf)),
        ("prismatic", 'lower="-1e38" upper="1e38"', (-1e38, 1e38)),
    ],
)
def test_limits_of_one_joint(kind: str, limit: str, expected: tuple[float, float], tmp_path: Path) -> None:
    model = read(tmp_path, *LINKS, joint("j", "a", "b", kind, limit))
    found = model.joint("j")
    assert (found.lower, found.upper) == expected
    assert (found.velocity, found.effort) == (inf, inf)  # absent, as in many files: none
    alone = len([word for word in ("lower", "upper") if word in limit]) == 1
    note = f"has the limit {limit[:5]} alone; the other is 0" if alone else ": limits of 0 and 0 stand for none"
    noted = alone or limit == 'lower="0" upper="0"'
    assert [found.partition("joint 'j'")[2].strip() for found in model.notes] == ([note.strip()] if noted else [])
    assert len(model.warnings) == ('upper="-1"' in limit)


def test_a_lower_bound_above_the_upper_is_a_warning(tmp_path: Path) -> None:
    model = read(tmp_path, *LINKS, joint("j", "a", "b", "revolute", 'lower="0.5"'))
    assert model.warnings == ("r.urdf:1: joint 'j': lower 0.5 is above upper 0; it is taken to be unlimited",)


@pytest.mark.parametrize(
    ("mimic", "follower", "expected"),
    [
        ('multiplier="1"', 'lower="-0.2" upper="0.3"', (-0.2, 0.3)),
        ('multiplier="-2" offset="0.1"', 'lower="-0.5" upper="0.5"', (-0.2, 0.3)),
        ('multiplier="0"', 'lower="-0.2" upper="0.3"', (-1.0, 1.0)),
        ("", 'lower="-2" upper="2"', (-1.0, 1.0)),
        ("", 'lower="0" upper="0"', (-1.0, 1.0)),
        ('offset="1"', 'lower="0" upper="1"', (-1.0, 0.0)),
    ],
)
def test_followers_narrow_what_they_follow(
    mimic: str, follower: str, expected: tuple[float, float], tmp_path: Path
) -> None:
    parts = [*LINKS, link("c"), slide("m", "a", "b", 'lower="-1" upper="1"')]
    parts.append(slide("f", "b", "c", follower, f'<mimic joint="m" {mimic}/>'))
    found = read(tmp_path, *parts).joint("m")
    assert (found.lower, found.upper) == pytest.approx(expected)
    robot = robot_of(tmp_path, *parts)
    assert robot.limits.position.tolist() == [pytest.approx(expected)]


@pytest.mark.parametrize(("limit", "multiplier"), [('lower="2" upper="3"', 1), ('lower="0" upper="0.5"', -1)])
def test_followers_that_leave_no_motion_are_warned_of(limit: str, multiplier: int, tmp_path: Path) -> None:
    """As in pr2.urdf, whose grippers would never move."""
    follower = slide("f", "b", "c", limit, f'<mimic joint="m" multiplier="{multiplier}"/>')
    model = read(tmp_path, *LINKS, link("c"), slide("m", "a", "b", 'lower="0" upper="0.5"'), follower)
    assert (model.joint("m").lower, model.joint("m").upper) == (0.0, 0.5)
    (warning,) = model.warnings
    assert warning.startswith("r.urdf: joint 'f' mimics 'm', whose range [0, 0.5] is no motion within its own, [")


def test_followers_of_followers(tmp_path: Path) -> None:
    """g = 3 f + 0.1 and f = -2 m + 0.5: g = -6 m + 1.6, so that g's limits narrow m to [-0.4, 0.6]."""
    parts = [*LINKS, link("c"), link("d"), slide("m", "a", "b", 'lower="-1" upper="1"')]
    parts.append(slide("g", "c", "d", 'lower="-2" upper="4"', '<mimic joint="f" multiplier="3" offset="0.1"/>'))
    parts.append(slide("f", "b", "c", "", '<mimic joint="m" multiplier="-2" offset="0.5"/>'))
    robot = robot_of(tmp_path, *parts)
    assert robot.joint_names == ("m",)
    assert robot.limits.position.tolist() == [pytest.approx([-0.4, 0.6])]
    below = [robot.forward_kinematics([0.2], name)[2, 3] for name in "bcd"]
    assert below == pytest.approx([0.2, 0.2 + 0.1, 0.2 + 0.1 + 0.4])


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        ("f", "m", r"r\.urdf:1: mimics itself: m -> f -> m"),
        ("m", "m", r"r\.urdf:1: mimics itself: m -> m"),
        ("n", "m", r"r\.urdf:1: mimics 'n', which is no joint"),
    ],
)
def test_joints_that_follow_nothing(first: str, second: str, message: str, tmp_path: Path) -> None:
    parts = [*LINKS, link("c"), slide("m", "a", "b", "", f'<mimic joint="{first}"/>')]
    with pytest.raises(ScenarioError, match=message):
        read(tmp_path, *parts, slide("f", "b", "c", "", f'<mimic joint="{second}"/>'))


def test_equal_limits_hold_a_joint_and_its_followers(tmp_path: Path) -> None:
    """At 0.25 m the link stands 0.75 m from its parent along x; its follower, at -0.5 m, 0.5 m below z."""
    held = slide("m", "a", "b", 'lower="0.25" upper="0.25"').replace("0 0 1", "2 0 0")
    follower = slide("f", "b", "c", 'lower="-1" upper="1"', '<mimic joint="m" multiplier="-2"/>')
    turned = joint("j", "c", "d")
    robot = robot_of(tmp_path, *LINKS, link("c"), link("d"), held, follower, turned)
    assert robot.joint_names == ("j",)
    assert robot.forward_kinematics([0.0], "c")[:3, 3] == pytest.approx([1.25, 0.0, -0.5])
    assert robot.notes == ["r.urdf: joint 'm' is held at 0.25: its limits leave no motion"]
    message = "joint 'm' is fixed, or held by its limits; allowed: j"
    with pytest.raises(ScenarioError, match=message):
        robot_of(tmp_path, *LINKS, link("c"), link("d"), held, follower, turned, joints=["m"])


def test_a_follower_may_hold_what_it_follows(tmp_path: Path) -> None:
    follower = slide("f", "b", "c", 'lower="0.5" upper="0.5"', '<mimic joint="m" offset="0.2"/>')
    model = read(tmp_path, *LINKS, link("c"), slide("m", "a", "b", 'lower="-1" upper="1"'), follower)
    assert model.movable == ()
    assert model.joint("m").origin[2, 3] == pytest.approx(0.3)
    assert model.joint("f").origin[2, 3] == pytest.approx(0.5)


# Axes, joints, inertias.


def test_axes_are_normalised_for_slides_and_turns(tmp_path: Path) -> None:
    """A slide along "2 0 0" at 0.5 m moves by 0.5 m, here and in PyBullet, which reads 1 m in the original."""
    for kind, moved in (("prismatic", [1.0, 0.0, 0.0]), ("revolute", [0.5, 0.0, 0.0])):
        parts = (*LINKS, joint("j", "a", "b", kind).replace('"0 0 1"', '"2 0 0"'))
        robot = robot_of(tmp_path, *parts, limits={"acceleration": None})
        assert robot.forward_kinematics([0.5], "b")[:3, 3] == pytest.approx(moved)
        world = World(robot)
        world.set_q([0.5])
        assert world.frame(robot.link_index("b"))[:3] == pytest.approx(moved)
        world.close()


def test_floating_and_planar_joints_are_refused(tmp_path: Path) -> None:
    for kind in ("floating", "planar"):
        with pytest.raises(
            ScenarioError, match=f"is of type '{kind}'; allowed: continuous, fixed, prismatic, revolute"
        ):
            read(tmp_path, *LINKS, joint("j", "a", "b", kind))


def test_links_without_inertial_weigh_next_to_nothing(tmp_path: Path) -> None:
    """PyBullet would give them 1 kg; a mass of 0 would fix them to the world."""
    world = World(robot_of(tmp_path, *LINKS, joint("j", "a", "b")))
    assert world.client.call("getDynamicsInfo", world.robot, world.bodies[0].link)[0] == pytest.approx(1e-3)
    world.close()


# Files.


def box_sizes(world: World) -> NDArray[np.float64]:
    shapes = [world.client.call("getCollisionShapeData", world.robot, body.link)[0] for body in world.bodies]
    return np.array([shape[3] for shape in shapes])


def test_links_of_many_shapes_and_visuals_are_loaded_as_they_are(tmp_path: Path) -> None:
    """PyBullet cuts lines of 8192 bytes: of a link in one line it would read other sizes, or refuse the file."""
    sizes = [f"{0.1 + 0.001 * index} 0.25 0.125" for index in range(60)]
    body = "".join(BOX.replace("0.1 0.1 0.1", size) for size in sizes)
    visuals = "".join(
        f'<visual><geometry><box size="{size}"/></geometry><material name="m{index}"><color rgba="1 0 0 1"/></material>'
        "</visual>"
        for index, size in enumerate(sizes)
    )
    robot = robot_of(tmp_path, link("a", ""), link("b", body + visuals), joint("j", "a", "b"))
    assert max(map(len, urdf_text(robot.urdf).splitlines())) < LINE
    world = World(robot)
    wanted = np.array([[float(number) for number in size.split()] for size in sizes]) + 0.002  # Bullet's margin
    assert box_sizes(world) == pytest.approx(wanted)
    world.close()


def test_blanks_before_the_declaration(tmp_path: Path) -> None:
    path = write_urdf(tmp_path / "r.urdf", (*LINKS, "\n", joint("j", "a", "b", "floating")))
    text = '<?xml version="1.0"?>\n' + path.read_text("utf-8")
    path.write_text(" \n\r\n\t" + text, "utf-8")
    with pytest.raises(ScenarioError, match=r"r\.urdf:5: joint 'j' is of type 'floating'"):
        load_urdf(path)
    path.write_text("\ufeff \n" + text.replace("floating", "fixed"), "utf-8")
    assert load_urdf(path).movable == ()


@pytest.mark.parametrize(
    ("visual", "note"),
    [
        ('<mesh filename="x.glb"/>', "the visual mesh 'x.glb' is no .dae, .obj, .stl file; it is not shown"),
        ('<mesh filename="none.stl"/>', "the visual mesh 'none.stl' is not there; it is not shown"),
        ('<mesh filename="package://p/no.stl"/>', "the visual mesh 'package://p/no.stl' is not there; it is not shown"),
        ("<mesh/>", "the visual mesh '' is not there; it is not shown"),
        ('<mesh filename="torn.obj"/>', "torn.obj: has no triangles (lines that begin with f); it is not shown"),
        ('<ellipsoid radii="1 1 1"/>', "allowed: box, capsule, cylinder, mesh, sphere; it is not shown"),
        ("", "<visual> has no <geometry> with a shape; it is not shown"),
    ],
)  # fmt: skip
def test_what_is_only_seen_need_not_be_there(visual: str, note: str, tmp_path: Path) -> None:
    (tmp_path / "x.glb").write_bytes(b"glTF")
    (tmp_path / "torn.obj").write_text("v 0 0 0\n")
    seen = f"{BOX}\n<visual><geometry>{visual}</geometry></visual>"
    robot = robot_of(tmp_path, link("a", ""), link("b", seen), joint("j", "a", "b"))
    (found,) = robot.notes
    assert found.startswith("r.urdf:2: ")
    assert found.endswith(note)
    World(robot).close()
    assert [part[0] for part in SpatialMotion().robot(robot)] == ["box"]  # in replays
    problem = spatial_problem(robot.entry)
    client = Client()
    assert len(VisibleBodies(client, problem).robot_ids) == 1  # and in pictures
    client.close()


def test_meshes_that_a_scenario_replaces_need_not_be_there(tmp_path: Path) -> None:
    (tmp_path / "torn.obj").write_text("v 0 0 0\n")
    (tmp_path / "x.glb").write_bytes(b"glTF")
    for name, why in (("none.stl", "is not there"), ("torn.obj", "no triangles"), ("x.glb", "is no .dae, .obj, .stl")):
        parts = (link("a", ""), link("b", mesh(name)), joint("j", "a", "b"))
        robot = robot_of(tmp_path, *parts, collision={"link_spheres": 0.1})
        (note,) = robot.notes
        assert why in note
        assert note.endswith("; spheres are in its place")
        World(robot).close()
        with pytest.raises(ScenarioError, match=why):
            robot_of(tmp_path, *parts)


def test_a_mesh_that_comes_later_is_found(tmp_path: Path) -> None:
    model = read(tmp_path, link("a", ""), link("b", mesh("late.obj")), joint("j", "a", "b"))
    with pytest.raises(ScenarioError, match=r"r\.urdf:1: the mesh 'late\.obj' is not there; looked for it from "):
        check_meshes_present(model)
    (tmp_path / "late.obj").write_text(TETRAHEDRON)
    check_meshes_present(load_urdf(tmp_path / "r.urdf"))


def test_colours_that_are_none_are_not_shown(tmp_path: Path) -> None:
    material = '<material name="red"><color rgba="1 0 0"/></material>'
    assert (
        "rgba: found '1 0 0'; 4 finite numbers are required; this colour is not shown"
        in read(tmp_path, material, *LINKS, joint("j", "a", "b")).notes[0]
    )


def test_units_of_collada_are_applied(tmp_path: Path) -> None:
    """As in PyBullet and RViz; pinocchio and yourdfpy read a file in centimetres 100 times as large."""
    path = tmp_path / "a.dae"
    path.write_text(collada().replace("<asset/>", '<asset><unit meter="0.01"/></asset>'), "utf-8")
    assert mesh_vertices(path, (1.0, 1.0, 1.0)).max() == pytest.approx(0.01)


def example_urdfs() -> list[Path]:
    """URDF files of example-robot-data, where it is installed: those that are read within 0.1 s."""
    files = sorted(path for folder in installed_folders()[1:] for path in folder.rglob("*.urdf"))
    return [path for path in files if path.stat().st_size < 20_000]


def test_frames_of_public_robots() -> None:
    """Each link of each file: our frames, the product of joint poses written out here, at one configuration."""
    refused = {"ur3.urdf": "found no <link>"}
    files = example_urdfs()
    for path in files:
        if path.name in refused:
            with pytest.raises(ScenarioError, match=refused[path.name]):
                load_urdf(path)
            continue
        model = load_urdf(path)
        q = np.random.default_rng(3).uniform(-1.0, 1.0, len(model.movable))
        tree = KinematicTree(model, model.movable, {})
        values = dict(zip(model.movable, q.tolist(), strict=True))
        frames: dict[str, NDArray[np.float64]] = {model.root: np.eye(4)}
        for one in model.joints:
            source, multiplier, offset = one.mimic or (one.name, 1.0, 0.0)
            value = multiplier * values.get(source, 0.0) + offset
            motion = np.eye(4)
            if one.kind == "prismatic":
                motion[:3, 3] = value * np.array(one.axis)
            elif one.kind == "revolute":
                motion[:3, :3] = rotation(np.array(one.axis), value)
            frames[one.child] = frames[one.parent] @ one.origin @ motion
        ours = tree.frames_along(q[None])[0]
        assert ours == pytest.approx(np.array([frames[name] for name in tree.names]), abs=1e-9), path.name
    assert not files or len(files) > 20


def rotation(axis: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """By the quaternion (cos(angle / 2), sin(angle / 2) axis)."""
    w, (x, y, z) = np.cos(0.5 * angle), np.sin(0.5 * angle) * axis
    u = np.array([x, y, z])
    result: NDArray[np.float64] = (
        (w * w - u @ u) * np.eye(3) + 2.0 * np.outer(u, u) + 2.0 * w * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    )
    assert np.linalg.det(result) == pytest.approx(1.0)
    assert abs(angle) <= pi
    return result
