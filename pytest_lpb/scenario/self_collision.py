"""The self-collision pairs of a scenario file: listed, or the default ones but those of a list or an SRDF file.

SRDF is MoveIt's: https://docs.ros.org/en/noetic/api/moveit_tutorials/html/doc/urdf_srdf/urdf_srdf_tutorial.html
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from pytest_lpb.bounded import read_bounded
from pytest_lpb.errors import ScenarioError
from pytest_lpb.names import suggestion
from pytest_lpb.problem.spatial.content import bounded_digest
from pytest_lpb.problem.spatial.xml_reader import Element, parse_xml
from pytest_lpb.scenario.schema.robot import ExceptPairs, Robot

MAX_SRDF_BYTES = 10_000_000
SRDF_SUFFIX = ".srdf"
Pair = tuple[str, str]


def concrete_pairs(robot: Robot, links: Sequence[str], bodies: Sequence[str]) -> Any:
    """What a concrete problem has: a list of pairs, None for the default, or {except: [[body, body], ..]}.

    Pairs of an SRDF file stand there by name, so that a problem needs the file no more.

    Args:
        robot: with an absolute path in `srdf`.
        links: names of the robot's links.
        bodies: those of them that collide.

    Raises ScenarioError for an SRDF file that cannot be used.
    """
    given = robot.self_collision_pairs
    if not isinstance(given, ExceptPairs):
        return given
    pairs = [tuple(pair) for pair in given.except_ or ()]
    if given.srdf is not None:
        pairs += srdf_pairs(Path(given.srdf), links, bodies)
    unique = {frozenset(pair): list(pair) for pair in reversed(pairs)}
    return {"except": list(reversed(unique.values()))}


def srdf_pairs(path: Path, links: Sequence[str], bodies: Sequence[str]) -> list[Pair]:
    """Pairs of bodies between which an SRDF file disables collisions.

    Links without collision geometry are skipped. `disable_default_collisions` stands for all pairs of a link, but
    those that `enable_collisions` names.

    Raises ScenarioError, `file:line: ..`, for a file that is no SRDF, or for links that the robot does not have.
    """
    if path.suffix != SRDF_SUFFIX:
        raise ScenarioError(f"found {path.name!r}; the name of an SRDF file ends in {SRDF_SUFFIX}")
    if not path.is_file():
        raise ScenarioError(f"there is no file {path}")
    root = _root(path, bounded_digest(path, MAX_SRDF_BYTES))
    known = {*links}
    disabled = [_pair(element, path, known) for element in root.all("disable_collisions")]
    enabled = {frozenset(_pair(element, path, known)) for element in root.all("enable_collisions")}
    for element in root.all("disable_default_collisions"):
        link = _link(element, "link", path, known)
        others = [(link, other) for other in bodies if other != link]
        disabled += [pair for pair in others if frozenset(pair) not in enabled]
    return [(one, other) for one, other in disabled if one in bodies and other in bodies]


@lru_cache(maxsize=16)
def _root(path: Path, _digest: str) -> Element:
    root = parse_xml(read_bounded(path, MAX_SRDF_BYTES, ScenarioError), path, "SRDF")
    if root.tag != "robot":
        raise ScenarioError(f"{path}:{root.line}: found <{root.tag}>; an SRDF file has a <robot>")
    if root.find("link") is not None or root.find("joint") is not None:
        raise ScenarioError(f"{path}:{root.line}: found links or joints; this is a URDF, not an SRDF file")
    return root


def _pair(element: Element, path: Path, links: Collection[str]) -> Pair:
    return _link(element, "link1", path, links), _link(element, "link2", path, links)


def _link(element: Element, key: str, path: Path, links: Collection[str]) -> str:
    name = element.attributes.get(key)
    if name is None:
        raise ScenarioError(f"{path}:{element.line}: <{element.tag}> has no {key}")
    if name not in links:
        raise ScenarioError(f"{path}:{element.line}: <{element.tag}> {key}: no link {name!r}{suggestion(name, links)}")
    return name
