"""How a robot is laid out for PyBullet: which links it loads, and which shapes are bodies of their own.

PyBullet measures a link as a whole, so each shape needs a link, or a body that is put where its link is before it is
measured. Convex hulls are such bodies, since PyBullet changes the vertices of those it loads with a robot. Robots
with more links than PyBullet can tell the state of have them for all further shapes of a link; where that is not
enough, links that move as one are merged.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.merging import merged_links
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.urdf import Geometry, Joint, Link, UrdfModel, identity
from pytest_lpb.problem.spatial.variants import driven_joints, with_locked_joints

MOST_JOINTS = 127  # of a body whose links PyBullet can tell the state of; fixed ones count
Places = Mapping[str, tuple[str, FloatArray]]  # by link of the robot: the link that carries it, its pose there (4, 4)

PART = "#"  # in the names of links made for further shapes of a link: `hand#1`


@dataclass(frozen=True, eq=False)
class Part:
    """A shape of the robot.

    Attributes:
        name: of the robot's link.
        shape: in that link's frame.
        host: PyBullet's link that carries it.
        pose: of the robot's link in the host's frame (4, 4).
        separate: whether it is a body of its own; else it is all the geometry that `host` has.
    """

    name: str
    shape: Geometry
    host: str
    pose: FloatArray
    separate: bool = False

    @property
    def placed(self) -> Geometry:
        """The shape in the host's frame."""
        return self.shape if self.host == self.name else replace(self.shape, origin=self.pose @ self.shape.origin)


@dataclass(frozen=True, eq=False)
class Layout:
    """What PyBullet loads.

    Attributes:
        model: links and joints, each link with the shapes that are not separate, or all where forces are simulated.
        parts: all shapes of the robot.
        places: of each link of the robot, PyBullet's link that it is part of and its pose in there (4, 4).
    """

    model: UrdfModel
    parts: tuple[Part, ...]
    places: Places


def layout_of(robot: SpatialRobot, *, simulated: bool) -> Layout:
    """The layout of a robot; with every shape on a link where forces are `simulated`.

    Separate shapes are carried by the first of the links that move as one, so that one pose serves them all.

    Raises ScenarioError for a robot with more moving joints than PyBullet can tell the state of.
    """
    model = with_locked_joints(robot.urdf, robot.locked)
    merged, carriers = merged_links(model, _moving(robot, model, simulated=simulated))
    places: Places = {link.name: (link.name, identity()) for link in model.links}
    layout = _laid_out(model, _parts(model, places), places, simulated=simulated, spread=True)
    if len(layout.model.joints) > MOST_JOINTS:
        original = model
        if len(model.joints) > MOST_JOINTS:
            model, places = merged, carriers
        if len(model.joints) > MOST_JOINTS:
            raise ScenarioError(
                f"the robot {robot.name!r} has {len(model.joints)} joints that move or join it to the world; "
                f"PyBullet takes up to {MOST_JOINTS}. Plan with fewer (`joints`), and lock the others (`locked_joints`)"
            )
        layout = _laid_out(model, _parts(original, places), places, simulated=simulated, spread=False)
    carried = [_carried(part, carriers) if part.separate else part for part in layout.parts]
    return replace(layout, parts=tuple(carried))


def _parts(model: UrdfModel, places: Places) -> list[Part]:
    """Each shape on the link that holds the one it belongs to."""
    return [Part(link.name, shape, *places[link.name]) for link in model.links for shape in link.collisions]


def _carried(part: Part, carriers: Places) -> Part:
    host, pose = carriers[part.name]
    return replace(part, host=host, pose=pose)


def _moving(robot: SpatialRobot, model: UrdfModel, *, simulated: bool) -> set[str]:
    """Joints that q moves; where forces are simulated, all that are not fixed."""
    if simulated:
        return {joint.name for joint in model.joints if joint.kind != "fixed"}
    planned, followers = driven_joints(robot)
    return {name for name, _ in planned} | {name for name, *_ in followers}


def _laid_out(model: UrdfModel, parts: list[Part], places: Places, *, simulated: bool, spread: bool) -> Layout:
    """The layout of parts on the links of a model.

    Args:
        model: links and joints; the shapes on its links do not matter.
        parts: each with the link that carries it as its host.
        places: of the robot's links.
        simulated: whether links keep shapes that are separate.
        spread: whether further shapes of a link get links of their own.
    """
    above = {joint.child: joint for joint in model.joints}
    links: list[Link] = []
    joints: list[Joint] = []
    laid: list[Part] = []
    for link in model.links:
        joints += [above[link.name]] if link.name in above else []
        carried = [part for part in parts if part.host == link.name]
        loaded = [part for part in carried if simulated or part.shape.kind != "mesh"]
        here = loaded if simulated and not spread else loaded[:1]
        links.append(replace(link, collisions=tuple(part.placed for part in here), visuals=()))
        hosts = {part: f"{link.name}{PART}{number}" for number, part in enumerate(loaded[1:], start=1) if spread}
        for part, host in hosts.items():
            links.append(Link(host, collisions=(part.placed,)))
            joints.append(Joint(f"{host}_joint", "fixed", link.name, host))
        for part in carried:
            alone = part in hosts or here == [part]
            laid.append(replace(part, host=hosts.get(part, link.name), separate=part.shape.kind == "mesh" or not alone))
    return Layout(replace(model, links=tuple(links), joints=tuple(joints)), tuple(laid), places)
