"""Mesh files of strangers, checked before PyBullet sees them.

PyBullet's readers are C++ and trust what they read: an index beyond the vertices, a wrong count of triangles or an
empty file ends the process. What passes here is what they can read. A mesh may name materials, and those textures:
PyBullet opens them too.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path

from pytest_lpb.bounded import read_bounded
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.allowed import project_of, refusal
from pytest_lpb.problem.spatial.content import bounded_digest
from pytest_lpb.problem.spatial.library import is_installed
from pytest_lpb.problem.spatial.mesh_limits import (
    MAX_MATERIAL_BYTES,
    MAX_MESH_BYTES,
    MAX_TEXTURE_BYTES,
    MESH_SUFFIXES,
)
from pytest_lpb.problem.spatial.meshes_of_collada import check_collada
from pytest_lpb.problem.spatial.meshes_of_stl import check_stl
from pytest_lpb.problem.spatial.meshes_of_wavefront import check_wavefront, materials_of, textures_of
from pytest_lpb.problem.spatial.textures import check_texture

# Where PyBullet looks for materials and textures besides the folder of the file that names them.
LOOKED_FOR = (".", "data", "../data", "../../data", "../../../data", "../../../../data")
# What PyBullet takes for which kind of file it decides by the last letters, as here. Others it does not open.
_CHECKS: dict[str, Callable[[bytes, Path], None]] = {
    ".obj": check_wavefront,
    ".stl": check_stl,
    ".dae": check_collada,
}


def check_mesh(path: Path) -> None:
    """Check a mesh file and what it names; equal files are checked once.

    Meshes of installed packages that robots known by name come with are not checked.

    Raises ScenarioError, `file: ..` or `file:line: ..`, for what is no file or too large, is damaged, or names files
    outside of its project.
    """
    if is_installed(path):
        return
    for line, material in _checked(path, bounded_digest(path, MAX_MESH_BYTES)):
        for file in _named(material, path, line):
            _check_material(file)


def is_sound(path: Path) -> bool:
    """Whether a mesh file is there, of a kind that is read, and passes `check_mesh`."""
    if path.suffix.lower() not in MESH_SUFFIXES:
        return False
    try:
        check_mesh(path)
    except ScenarioError:
        return False
    return True


@lru_cache(maxsize=1024)
def _checked(path: Path, _digest: str) -> tuple[tuple[int, str], ...]:
    """Lines and names of the materials that a sound mesh names."""
    content = read_bounded(path, MAX_MESH_BYTES, ScenarioError)
    check = _CHECKS.get(path.suffix.lower())
    if check is None:
        return ()
    if not content:
        raise ScenarioError(f"{path}: has no triangles: the file is empty")
    check(content, path)
    return tuple(materials_of(content)) if path.suffix.lower() == ".obj" else ()


def _check_material(path: Path) -> None:
    for line, texture in _textures(path, bounded_digest(path, MAX_MATERIAL_BYTES)):
        for file in _named(texture, path, line):
            _check_texture(file, bounded_digest(file, MAX_TEXTURE_BYTES))


@lru_cache(maxsize=1024)
def _textures(path: Path, _digest: str) -> tuple[tuple[int, str], ...]:
    return tuple(textures_of(read_bounded(path, MAX_MATERIAL_BYTES, ScenarioError), path))


@lru_cache(maxsize=1024)
def _check_texture(path: Path, _digest: str) -> None:
    check_texture(path)


def _named(name: str, by: Path, line: int) -> Iterator[Path]:
    """The file that a mesh or material names, if it is there. Raises ScenarioError where it may not be named.

    PyBullet puts the name behind the folder's, even one that begins with a slash; what is not there it looks for around
    the working directory. Exporters name pictures of the machine that they ran on: what is nowhere is not opened.
    """
    home = project_of(by)
    for folder in (by.parent, *(Path.cwd() / place for place in LOOKED_FOR)):
        path = Path(f"{folder}/{name}")
        if not os.path.lexists(path):
            continue
        refused = refusal(path, home)
        if refused:
            raise ScenarioError(f"{by}:{line}: {name!r} {refused}")
        yield path
