"""The files a problem is made of: digests that tell whether they changed, and copies that travel with a run."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.urdf_reader import load_urdf

ASSETS = "assets"  # folder of a run that holds copies


def asset_files(path: Path) -> tuple[Path, ...]:
    """A URDF and those of its meshes that are there, or a mesh alone; in a fixed order."""
    path = Path(path).absolute()
    return (path, *load_urdf(path).meshes) if path.suffix == ".urdf" else (path,)


def assets_digest(path: Path) -> str:
    """SHA-256 of a URDF with its meshes, or of a mesh: wherever they lie, the same files have the same digest."""
    digest = hashlib.sha256()
    for name, file in _relative_names(asset_files(path)).items():
        digest.update(f"{name}:{file_digest(file)};".encode())
    return digest.hexdigest()


def _relative_names(files: tuple[Path, ...]) -> dict[str, Path]:
    """Paths below the files' common folder, and the files."""
    common = Path(os.path.commonpath([file.parent for file in files]))
    return {file.relative_to(common).as_posix(): file for file in files}
