"""The meshes that a URDF of a stranger names: where they lie, and whether they are sound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.allowed import refusal
from pytest_lpb.problem.spatial.library import installed_folders
from pytest_lpb.problem.spatial.mesh_files import check_mesh
from pytest_lpb.problem.spatial.urdf_reader import load_urdf


def escaping_meshes(urdf: Path, home: Path, more: Sequence[Path] = ()) -> Iterator[str]:
    """What is wrong with each mesh that may not be named, `urdf:line: ..`; meshes are not read.

    Besides those of the project, meshes of installed packages that have robots are allowed.

    Args:
        urdf: the file.
        home: the project whose files it may name.
        more: further folders that are allowed.

    Raises ScenarioError for a file that is no URDF.
    """
    for line, mesh in _meshes(urdf):
        refused = refusal(mesh, home, [*more, *installed_folders()])
        if refused:
            yield f"{urdf}:{line}: the mesh {mesh} {refused}"


def check_meshes(urdf: Path) -> None:
    """Check every mesh of a URDF, seen or touched. Raises ScenarioError, `urdf:line: mesh: ..`."""
    for line, mesh in _meshes(urdf):
        try:
            check_mesh(mesh)
        except ScenarioError as error:
            raise ScenarioError(f"{urdf}:{line}: {error}") from None


def _meshes(urdf: Path) -> Iterator[tuple[int, Path]]:
    """Lines that name meshes, and the meshes; each mesh once."""
    named = {
        shape.file: shape.line
        for link in reversed(load_urdf(urdf).links)
        for shape in (*link.collisions, *link.visuals)
        if shape.file is not None
    }
    yield from sorted((line, file) for file, line in named.items())
