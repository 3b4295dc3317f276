"""The order of a robot's links and joints: a tree, parents before children."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial.urdf import Joint, Link


def in_tree_order(
    links: Mapping[str, Link], joints: Mapping[str, Joint], path: Path
) -> tuple[tuple[Link, ...], tuple[Joint, ...]]:
    """Links with parents before children, depth first, and the joints in the order of their children.

    Raises ScenarioError unless they make one tree.
    """
    below: dict[str, list[Joint]] = {}
    above: dict[str, str] = {}
    for joint in joints.values():
        if joint.child in above:
            raise ScenarioError(
                f"{path}: link {joint.child!r} is the child of two joints, {above[joint.child]!r} and {joint.name!r}"
            )
        above[joint.child] = joint.name
        below.setdefault(joint.parent, []).append(joint)
    roots = [name for name in links if name not in above]
    if not roots:
        raise ScenarioError(f"{path}: every link is the child of a joint; a tree has one root")
    if len(roots) > 1:
        raise ScenarioError(f"{path}: several links are no joint's child: {', '.join(roots)}; a tree has one root")
    ordered_links, ordered_joints = [links[roots[0]]], []
    waiting = list(reversed(below.get(roots[0], [])))
    while waiting:
        joint = waiting.pop()
        ordered_joints.append(joint)
        ordered_links.append(links[joint.child])
        waiting.extend(reversed(below.get(joint.child, [])))
    if len(ordered_links) < len(links):
        lost = sorted(set(links) - {link.name for link in ordered_links})
        raise ScenarioError(f"{path}: links in a loop: {', '.join(lost)}; a URDF robot is a tree")
    return tuple(ordered_links), tuple(ordered_joints)
