"""The wheel: what it holds, and that it runs in an empty folder like the checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest

import pytest_lpb

from .projects import FAST, LEAN, SCENARIO, Project, read_run, read_table

ROOT = Path(pytest_lpb.__file__).parents[1]

pytestmark = [
    pytest.mark.skipif(find_spec("hatchling") is None, reason="hatchling, which builds the wheel, is not installed"),
    pytest.mark.skipif(not (ROOT / "pyproject.toml").is_file(), reason="the package is not used from a checkout"),
]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    script = f"from hatchling.build import build_wheel; build_wheel({str(folder)!r})"
    subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True, capture_output=True)
    (file,) = folder.glob("*.whl")
    return file


def test_content(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    for name in ("py.typed", "shipped_files/planners/pd.yaml", "report/templates/report.html.j2"):
        assert f"pytest_lpb/{name}" in names
    tops = {name.partition("/")[0] for name in names}
    assert tops == {"pytest_lpb", f"pytest_lpb-{pytest_lpb.__version__}.dist-info"}
    shipped = {path.relative_to(ROOT).as_posix() for path in (ROOT / "scenarios").rglob("*.yaml")}
    assert {f"pytest_lpb/shipped_files/{path}" for path in shipped} <= names


def test_scenarios_are_copied_from_it(wheel: Path, tmp_path: Path) -> None:
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    script = (
        f"import sys; sys.path.insert(0, {str(site)!r}); import pytest_lpb.scenarios_cli as cli;"
        f"assert cli.__file__.startswith({str(site)!r}), cli.__file__;"
        f"sys.exit(cli.main(['copy', 'scenarios']))"
    )
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True)
    copies = {path.relative_to(tmp_path): path.read_bytes() for path in (tmp_path / "scenarios").rglob("*.*")}
    assert copies == {path.relative_to(ROOT): path.read_bytes() for path in (ROOT / "scenarios").rglob("*.*")}


def test_a_run_in_an_empty_folder(wheel: Path, tmp_path: Path, project: Project) -> None:
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    folder = tmp_path / "empty"
    folder.mkdir()
    (folder / "x.yaml").write_text(SCENARIO)
    script = (
        f"import sys; sys.path.insert(0, {str(site)!r}); import pytest, pytest_lpb;"
        f"assert pytest_lpb.__file__.startswith({str(site)!r}), pytest_lpb.__file__;"
        f"sys.exit(pytest.main({['--lpb-planners=pd', FAST, *LEAN, 'x.yaml']!r}))"
    )
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    result = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stdout + result.stderr
    run = (folder / "reports/latest").resolve()
    planner = read_run(run)["planners"]["pd"]
    assert planner["file"] == str(site / "pytest_lpb/shipped_files/planners/pd.yaml")
    (row,) = read_table(run / "trials.csv")

    project.scenario("x.yaml")
    project.run("x.yaml").assert_outcomes(passed=1)
    own = read_run(project.runs()[-1])["planners"]["pd"]
    assert planner["parameters_hash"] == own["parameters_hash"]
    assert planner["source_hash"] == own["source_hash"]
    assert row["trajectory_hash"] == project.row()["trajectory_hash"]
    assert row["problem_hash"] == project.row()["problem_hash"]
