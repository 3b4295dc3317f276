"""The files of a problem in a run folder: copies that travel with the run, named relative to it.

A URDF with its meshes, or the mesh of an obstacle, is copied once to RUN/assets/<sha256>/; robots known by name stay
where they are installed. Copies are as the files were, below the same folders, so that they have the same digest, and
their problem the same hash.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from pytest_lpb.documents.atomic import recording_error
from pytest_lpb.errors import RecordingError, ScenarioError
from pytest_lpb.problem.allowed import project_of, refusal
from pytest_lpb.problem.packages import write_index
from pytest_lpb.problem.paths import with_paths

PACKAGE_FILE = "package.xml"  # tells a ROS package, whatever its folder is called


def recorded(problem: Mapping[str, Any], run: Path) -> dict[str, Any]:
    """A concrete problem as a run records it: its files copied into the run folder, and named relative to it.

    Of a certified path its length is kept. Raises RecordingError when a file cannot be copied.
    """
    content = dict(problem)
    if "certified" in content:
        content["certified"] = {key: value for key, value in content["certified"].items() if key != "path"}
    result: dict[str, Any] = with_paths(content, lambda path: _copied(Path(path), run.absolute()))
    return result


def recorded_beside(problem: Mapping[str, Any], run: Path, folder: Path) -> dict[str, Any]:
    """The same with files named relative to a folder of the run, for a scenario file that lies there."""

    def relative(path: str) -> str:
        return path if Path(path).is_absolute() else Path(os.path.relpath(run / path, folder)).as_posix()

    result: dict[str, Any] = with_paths(recorded(problem, run), relative)
    return result


def restored(problem: Mapping[str, Any], run: Path) -> dict[str, Any]:
    """A recorded problem with absolute paths again.

    Raises RecordingError when a file is not there, or lies outside of the run folder and of the project it is in.
    """

    def absolute(path: str) -> str:
        found = Path(os.path.normpath(run.absolute() / path))
        home = project_of(run.absolute())
        refused = refusal(found, home, [run.resolve()])
        if refused:
            raise RecordingError(f"the file {found} of its problem {refused}")
        if not found.is_file():
            raise RecordingError(f"the file {found} of its problem is missing; a run folder keeps them in assets/")
        if found.suffix == ".urdf":
            _check_meshes(found, home, run)
        return str(found)

    result: dict[str, Any] = with_paths(dict(problem), absolute)
    return result


def _check_meshes(urdf: Path, home: Path, run: Path) -> None:
    from pytest_lpb.problem.spatial.robot_files import escaping_meshes

    for text in escaping_meshes(urdf, home, [run.resolve()]):
        raise RecordingError(text)


def _copied(path: Path, run: Path) -> str:
    """Where a file's copy is in a run folder; its own path where a copy cannot stand for it."""
    # Imported late: most problems have no files.
    from pytest_lpb.problem.spatial.assets import assets_digest

    try:
        return _copy_once(path, assets_digest(path), run)
    except OSError as error:
        raise recording_error(f"cannot copy {path} into {run}", error) from error
    except ScenarioError as error:
        raise RecordingError(f"cannot copy {path} into {run}: {error}") from error


@lru_cache(maxsize=256)
def _copy_once(path: Path, digest: str, run: Path) -> str:
    from pytest_lpb.problem.spatial.assets import ASSETS, asset_files

    folder = run / ASSETS / digest
    files = asset_files(path)
    common = Path(os.path.commonpath([file.parent for file in files]))
    if not folder.is_dir():
        _copy_files(files, common, folder, digest)
    wanted = files[0].relative_to(common).parts
    copies = [copy for copy in folder.rglob("*") if copy.parts[-len(wanted) :] == wanted]
    if not copies:
        return str(path)
    return min(copies, key=lambda copy: len(copy.parts)).relative_to(run).as_posix()


def _copy_files(files: Sequence[Path], common: Path, folder: Path, digest: str) -> None:
    """Copy files below `common` to `folder`, which appears whole; nothing where the copies do not find each other.

    Meshes may be named by package://PACKAGE/..: then folders above `common` are kept too, as many as it takes.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".", suffix=".part") as work:
        top, tree = common, Path(work) / "0"  # `tree` is to be what `top` is
        for file in files:
            _copy_with_package_files(file, common, tree)
        _write_index(files, common, tree)
        while not _stand_alone(tree / files[0].relative_to(top), tree, digest):
            if top == top.parent:
                return
            above = tree.with_name(str(int(tree.name) + 1))
            above.mkdir()
            tree.rename(above / top.name)
            top, tree = top.parent, above
            _copy_package_file(top, tree)
        _publish(tree, folder)


def _write_index(files: Sequence[Path], common: Path, tree: Path) -> None:
    """Where copies of packages that ROS knows are: its environment variables lead to the originals."""
    from pytest_lpb.problem.spatial.urdf_reader import load_urdf

    located = load_urdf(files[0]).located if files[0].suffix == ".urdf" else {}
    if located:
        write_index(tree, {name: file.relative_to(common).as_posix() for name, file in located.items()})


def _copy_with_package_files(file: Path, common: Path, tree: Path) -> None:
    copy = tree / file.relative_to(common)
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, copy)
    for parent in file.parents:
        if not parent.is_relative_to(common):
            break
        _copy_package_file(parent, tree / parent.relative_to(common))


def _copy_package_file(source: Path, target: Path) -> None:
    if (source / PACKAGE_FILE).is_file():
        shutil.copyfile(source / PACKAGE_FILE, target / PACKAGE_FILE)


def _stand_alone(copy: Path, tree: Path, digest: str) -> bool:
    """Whether a copy finds the copies of the files that belong to it, and has the digest of the original."""
    from pytest_lpb.problem.spatial.assets import asset_files, assets_digest

    try:
        found = asset_files(copy)
    except ScenarioError:
        return False
    return all(file.is_relative_to(tree.resolve()) for file in found) and assets_digest(copy) == digest


def _publish(tree: Path, folder: Path) -> None:
    try:
        tree.rename(folder)
    except OSError:
        # Another worker was first: the content is the same.
        if not folder.is_dir():
            raise
