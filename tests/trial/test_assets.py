"""Files of a problem in a run folder: copied once, as they are, and found wherever the folder goes."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import RecordingError
from pytest_lpb.problem.spatial.assets import asset_files, assets_digest
from pytest_lpb.trial.assets import _copy_once, recorded, recorded_beside, restored
from tests.scenario.urdfs import BOX, TETRAHEDRON, mesh, write_arm


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return tmp_path / "run"


def problem_with(urdf: Path) -> dict[str, Any]:
    return {"robot": {"urdf": str(urdf), "name": "arm"}, "obstacles": []}


def write_mesh(path: Path, content: str = TETRAHEDRON) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    return path


def plain(folder: Path) -> Path:
    return write_arm(folder / "arm.urdf", BOX)


def beside(folder: Path) -> Path:
    write_mesh(folder / "meshes" / "a.obj")
    return write_arm(folder / "arm.urdf", mesh("meshes/a.obj"))


def above(folder: Path) -> Path:
    write_mesh(folder / "meshes" / "a.obj")
    return write_arm(folder / "urdf" / "arm.urdf", mesh("../meshes/a.obj"))


def package_above(folder: Path) -> Path:
    write_mesh(folder / "my_arm" / "meshes" / "a.obj")
    return write_arm(folder / "my_arm" / "urdf" / "arm.urdf", mesh("package://my_arm/meshes/a.obj"))


def package_far_above(folder: Path) -> Path:
    write_mesh(folder / "my_arm" / "robots" / "left" / "a.obj")
    return write_arm(folder / "my_arm" / "robots" / "left" / "arm.urdf", mesh("package://my_arm/robots/left/a.obj"))


def package_of_another_name(folder: Path) -> Path:
    write_mesh(folder / "checkout" / "package.xml", "<package/>")
    write_mesh(folder / "checkout" / "meshes" / "a.obj")
    return write_arm(folder / "checkout" / "urdf" / "arm.urdf", mesh("package://my_arm/meshes/a.obj"))


def package_of_another_name_far_above(folder: Path) -> Path:
    write_mesh(folder / "checkout" / "package.xml", "<package/>")
    write_mesh(folder / "checkout" / "robots" / "left" / "a.obj")
    urdf = folder / "checkout" / "robots" / "left" / "arm.urdf"
    return write_arm(urdf, mesh("package://my_arm/robots/left/a.obj"))


def two_packages(folder: Path) -> Path:
    write_mesh(folder / "parts" / "a.obj")
    return write_arm(folder / "my_arm" / "arm.urdf", mesh("package://parts/a.obj"))


LAYOUTS = (
    plain,
    beside,
    above,
    package_above,
    package_far_above,
    package_of_another_name,
    package_of_another_name_far_above,
    two_packages,
)


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.__name__)
def test_a_urdf_and_its_meshes_travel_with_the_run(layout: Callable[[Path], Path], tmp_path: Path, run: Path) -> None:
    urdf = layout(tmp_path / "robots")
    digest, count = assets_digest(urdf), len(asset_files(urdf))
    content = recorded(problem_with(urdf), run)
    name = content["robot"]["urdf"]
    assert name.startswith(f"assets/{digest}/")
    assert [path.name for path in (run / "assets").iterdir()] == [digest]  # nothing is left behind
    shutil.rmtree(tmp_path / "robots")
    moved = tmp_path / "elsewhere"
    run.rename(moved)
    copy = Path(restored(content, moved)["robot"]["urdf"])
    assert copy == moved / name
    assert assets_digest(copy) == digest
    assert len(asset_files(copy)) == count
    assert all(file.is_relative_to(moved) for file in asset_files(copy))


def test_a_run_folder_within_the_package_does_not_lean_on_it(tmp_path: Path) -> None:
    urdf = package_above(tmp_path)
    run = tmp_path / "my_arm" / "reports" / "run"
    copy = run / recorded(problem_with(urdf), run)["robot"]["urdf"]
    assert all(file.is_relative_to(run) for file in asset_files(copy))


def test_meshes_named_by_absolute_paths_stay_where_they_are(tmp_path: Path, run: Path) -> None:
    file = write_mesh(tmp_path / "meshes" / "a.obj")
    urdf = write_arm(tmp_path / "robots" / "arm.urdf", mesh(str(file)))
    problem = problem_with(urdf)
    assert recorded(problem, run) == problem
    assert recorded_beside(problem, run, run / "trials") == problem
    assert restored(problem, run) == problem
    assert list((run / "assets").iterdir()) == []


def test_meshes_of_obstacles(tmp_path: Path, run: Path) -> None:
    files = [write_mesh(tmp_path / folder / "rock.obj", f"# {folder}\n{TETRAHEDRON}") for folder in "ab"]
    obstacles = [{"name": str(i), "file": str(file)} for i, file in enumerate([*files, files[0]])]
    problem: dict[str, Any] = {"robot": {"model": "panda"}, "obstacles": [*obstacles, {"name": "ball", "radius": 1.0}]}
    content = recorded(problem, run)
    names = [entry.get("file") for entry in content["obstacles"]]
    assert names == [f"assets/{assets_digest(files[i])}/rock.obj" for i in (0, 1, 0)] + [None]
    assert (run / str(names[1])).read_bytes() == files[1].read_bytes()
    assert len(list((run / "assets").iterdir())) == 2
    assert problem["obstacles"][0] == obstacles[0]  # what is recorded is a copy


def test_a_scenario_file_in_the_run_names_files_relative_to_itself(tmp_path: Path, run: Path) -> None:
    urdf = beside(tmp_path)
    folder = run / "trials" / "group" / "x" / "pd"
    name = recorded_beside(problem_with(urdf), run, folder)["robot"]["urdf"]
    assert name == f"../../../../assets/{assets_digest(urdf)}/arm.urdf"
    folder.mkdir(parents=True)
    assert (folder / name).read_bytes() == urdf.read_bytes()


def test_of_a_certified_path_the_length_is_kept(run: Path) -> None:
    problem = {
        "robot": {"model": "panda"},
        "obstacles": [],
        "certified": {"seed": 0, "length_m": 2.0, "path": "/a.csv"},
    }
    assert recorded(problem, run)["certified"] == {"seed": 0, "length_m": 2.0}
    assert recorded_beside(problem, run, run)["certified"] == {"seed": 0, "length_m": 2.0}
    assert not run.exists()


def test_a_problem_without_files_leaves_no_folder(run: Path) -> None:
    problem = {"robot": {"model": "point"}, "obstacles": [{"name": "disc", "radius": 1.0}]}
    assert recorded(problem, run) == problem
    assert not run.exists()


def test_what_was_copied_is_not_copied_again(tmp_path: Path, run: Path) -> None:
    urdf = beside(tmp_path / "robots")
    first = recorded(problem_with(urdf), run)
    stamps = {path: path.stat().st_mtime_ns for path in run.rglob("*")}
    _copy_once.cache_clear()  # as in another worker
    assert recorded(problem_with(urdf), run) == first
    assert {path: path.stat().st_mtime_ns for path in run.rglob("*")} == stamps


def test_changed_files_are_other_files(tmp_path: Path, run: Path) -> None:
    urdf = beside(tmp_path / "robots")
    first = recorded(problem_with(urdf), run)["robot"]["urdf"]
    write_mesh(tmp_path / "robots" / "meshes" / "a.obj", "# changed\n" + TETRAHEDRON)
    second = recorded(problem_with(urdf), run)["robot"]["urdf"]
    assert first != second
    assert not (run / first).parent.joinpath("meshes/a.obj").read_text().startswith("# changed")


def test_workers_copy_at_the_same_time(tmp_path: Path, run: Path) -> None:
    urdf = package_far_above(tmp_path / "robots")

    def copy(_: int) -> str:
        _copy_once.cache_clear()
        name: str = recorded(problem_with(urdf), run)["robot"]["urdf"]
        return name

    with ThreadPoolExecutor(8) as pool:
        names = set(pool.map(copy, range(32)))
    assert len(names) == 1
    assert (run / names.pop()).is_file()
    assert [path.name for path in (run / "assets").iterdir()] == [assets_digest(urdf)]


def test_a_copy_is_as_readable_as_other_files(tmp_path: Path, run: Path) -> None:
    copy = run / recorded(problem_with(beside(tmp_path)), run)["robot"]["urdf"]
    probe = tmp_path / "probe"
    probe.mkdir()
    assert copy.parent.stat().st_mode == probe.stat().st_mode


def test_a_file_that_is_gone(tmp_path: Path, run: Path) -> None:
    urdf = plain(tmp_path)
    content = recorded(problem_with(urdf), run)
    shutil.rmtree(run / "assets")
    with pytest.raises(
        RecordingError, match=r"the file .*arm\.urdf of its problem is missing; a run folder keeps them"
    ):
        restored(content, run)
    urdf.unlink()
    with pytest.raises(RecordingError, match=r"cannot copy .*arm\.urdf into .*run: .*"):
        recorded(problem_with(urdf), run)
