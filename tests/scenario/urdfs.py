"""URDF files for tests: small, and as different from each other as a test needs."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

BOX = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
LIMIT = 'lower="-1" upper="1" velocity="2" effort="3"'

TETRAHEDRON = """\
v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def link(name: str, content: str = BOX) -> str:
    """A link, by default with a box."""
    return f'<link name="{name}">{content}</link>'


def mesh(file: str) -> str:
    """Collision geometry from a file."""
    return f'<collision><geometry><mesh filename="{file}"/></geometry></collision>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", limit: str = LIMIT, more: str = "") -> str:
    """A joint 0.5 m along its parent's x that turns about z."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit {limit}/>{more}</joint>'
    )


def write_urdf(path: Path, parts: Iterable[str], name: str = "robot") -> Path:
    """A URDF file of these links and joints, with its folders."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<robot name="{name}">{"".join(parts)}</robot>', encoding="utf-8")
    return path


def write_arm(path: Path, geometry: str = BOX, limit: str = LIMIT) -> Path:
    """Two links on a base, with the joints j1 and j2."""
    parts = (link("base"), link("upper", geometry), link("lower", geometry))
    return write_urdf(path, (*parts, joint("j1", "base", "upper", limit=limit), joint("j2", "upper", "lower")))
