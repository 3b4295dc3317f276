"""The meshes that a URDF of a stranger names: where they lie, and whether they are sound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from pytest_lpb.errors import ScenarioError
from pytest_lpb.names import listed
from pytest_lpb.problem.allowed import refusal
from pytest_lpb.problem.spatial.library import installed_folders
from pytest_lpb.problem.spatial.mesh_files import check_mesh
from pytest_lpb.problem.spatial.mesh_limits import MESH_SUFFIXES
from pytest_lpb.problem.spatial.urdf import Geometry, UrdfModel
from pytest_lpb.problem.spatial.urdf_reader import check_meshes_present, load_urdf


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
    """Check every mesh that collides. Raises ScenarioError, `urdf:line: mesh: ..`."""
    model = load_urdf(urdf)
    check_meshes_present(model)
    for fault in _faults_of([shape for link in reversed(model.links) for shape in link.collisions], str(urdf)):
        raise ScenarioError(fault)


def visual_faults(model: UrdfModel) -> list[str]:
    """What is wrong with meshes that would be seen only, `file:line: ..` with the file's name alone."""
    if model.path is None:
        return []
    visuals = [shape for link in reversed(model.links) for shape in link.visuals]
    return [f"{fault}; it is not shown" for fault in _faults_of(visuals, model.path.name)]


def replaced_faults(model: UrdfModel) -> list[str]:
    """What is wrong with collision meshes that a scenario replaces, likewise."""
    if model.path is None:
        return []
    shapes = [shape for link in reversed(model.links) for shape in link.collisions]
    missing = [shape.missing.removeprefix(f"{model.path.parent}/") for shape in shapes if shape.missing]
    faults = [*missing, *_faults_of(shapes, model.path.name)]
    return [f"{fault}; spheres are in its place" for fault in faults]


def _faults_of(shapes: Sequence[Geometry], name: str) -> Iterator[str]:
    for line, mesh in _lines(shapes):
        if mesh.suffix.lower() not in MESH_SUFFIXES:
            yield f"{name}:{line}: the mesh {mesh} is no {listed(MESH_SUFFIXES)} file"
            continue
        try:
            check_mesh(mesh)
        except ScenarioError as error:
            yield f"{name}:{line}: {error}"


def _meshes(urdf: Path) -> Iterator[tuple[int, Path]]:
    links = reversed(load_urdf(urdf).links)
    yield from _lines([shape for link in links for shape in (*link.collisions, *link.visuals)])


def _lines(shapes: Sequence[Geometry]) -> list[tuple[int, Path]]:
    """Lines that name meshes, and the meshes; each mesh once."""
    named = {shape.file: shape.line for shape in shapes if shape.file is not None}
    return sorted((line, file) for file, line in named.items())
