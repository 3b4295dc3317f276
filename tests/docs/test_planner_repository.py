"""The example of a planner repository: in a fresh virtual environment its CI is green, and red for a worse planner."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import yaml

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs/examples/planner_repository"
WORKFLOW = EXAMPLE / ".github/workflows/benchmark.yml"

pytestmark = pytest.mark.skipif(
    find_spec("hatchling") is None or find_spec("pip") is None, reason="needs hatchling and pip to install packages"
)


def commands() -> dict[str, str]:
    """Shell commands of the workflow by the name of their step."""
    steps = yaml.safe_load(WORKFLOW.read_text("utf-8"))["jobs"]["benchmark"]["steps"]
    return {step["name"]: step["run"] for step in steps if "run" in step}


class Repository:
    """A copy of the example with a virtual environment of its own, which has this checkout's wheel installed."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "repository"
        shutil.copytree(EXAMPLE, self.path, ignore=shutil.ignore_patterns("reports", "__pycache__", ".*cache"))
        self._bin = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder / "venv")], check=True)
        script = f"from hatchling.build import build_wheel; build_wheel({str(folder)!r})"
        subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True, capture_output=True)
        (wheel,) = folder.glob("*.whl")
        self._pip("install", "--no-index", "--no-deps", "--no-compile", str(wheel))
        # What pytest-lpb depends on is not fetched again: it is there, where these tests run.
        (site,) = (folder / "venv").rglob("site-packages")
        found = dict.fromkeys(sysconfig.get_path(name) for name in ("purelib", "platlib"))
        lines = [f"import site; site.addsitedir({path!r})\n" for path in found]
        (site / "dependencies.pth").write_text("".join(lines), "utf-8")
        command = self._bin / "pytest"
        command.write_text(
            f"#!{self._bin / 'python'}\nimport pytest\nraise SystemExit(pytest.console_main())\n", "utf-8"
        )
        command.chmod(0o755)

    def _pip(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "pip", "--python", str(self._bin / "python"), "--quiet", *arguments]
        subprocess.run(command, check=True, capture_output=True, env=self.environment)

    @property
    def environment(self) -> dict[str, str]:
        """Of a fresh shell in which the virtual environment is active."""
        kept = {
            key: value
            for key, value in os.environ.items()
            if not key.startswith(("PYTEST_", "PYTHON", "VIRTUAL_ENV", "COV_", "PIP_"))
        }
        return {**kept, "PATH": f"{self._bin}{os.pathsep}{os.environ['PATH']}", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}

    def run(self, command: str) -> subprocess.CompletedProcess[str]:
        """A command line of the workflow."""
        return subprocess.run(
            command, shell=True, cwd=self.path, env=self.environment, capture_output=True, text=True, check=False
        )

    def edit(self, path: str, old: str, new: str) -> None:
        """Change a file at the one place where it says `old`."""
        text = (self.path / path).read_text("utf-8")
        assert text.count(old) == 1
        (self.path / path).write_text(text.replace(old, new), "utf-8")


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Repository:
    return Repository(tmp_path_factory.mktemp("example"))


@pytest.fixture
def repository(fresh: Repository) -> Iterator[Repository]:
    """The repository as it is committed."""
    yield fresh
    for path in ("dynamic_window", "planners"):
        shutil.copytree(EXAMPLE / path, fresh.path / path, dirs_exist_ok=True)


def verdicts(text: str) -> dict[str, str]:
    """Verdict by KPI."""
    rows = re.findall(r"^dynamic_window +(\w+) .* {2}(same or better|regressed|inconclusive)$", text, re.MULTILINE)
    return dict(rows)


def test_an_unchanged_planner_is_let_through(repository: Repository) -> None:
    where = repository.run(
        "command -v pytest; command -v lpb-report; python -c 'import pytest_lpb; print(pytest_lpb.__file__)'"
    )
    places = where.stdout.split()
    assert len(places) == 3
    assert all(Path(place).is_relative_to(repository.path.parent / "venv") for place in places), places

    result = repository.run(commands()["Run all trials, and compare with the baseline"])
    assert result.returncode == 0, result.stdout + result.stderr
    assert verdicts(result.stdout) == dict.fromkeys(
        ("success", "time_to_goal_s", "clearance_min_m"), "same or better"
    ), result.stdout
    assert "gate open: same or better in all that was asked" in result.stdout
    assert "not compared" not in result.stdout

    cases = list(ET.parse(repository.path / "junit.xml").iter("testcase"))
    assert len(cases) == 60
    outcomes = [case.find("properties/property[@name='lpb_outcome']") for case in cases]
    assert sum(entry is not None and entry.get("value") == "success" for entry in outcomes) == 56
    summary = repository.run(commands()["Summary"])
    assert summary.returncode == 0, summary.stderr
    text = (repository.path / "summary.md").read_text("utf-8")
    assert "**gate open" in text
    assert "| dynamic\\_window | 56/60 | 60 | 93 % |" in text


def test_a_planner_that_forgets_how_obstacles_move_is_stopped(repository: Repository) -> None:
    moving = 'observation["obstacle_velocity"]'
    repository.edit("dynamic_window/planner.py", moving, f"0.0 * {moving}")
    result = repository.run(commands()["Run all trials, and compare with the baseline"])
    assert result.returncode == 1, result.stdout + result.stderr
    assert verdicts(result.stdout)["success"] == "regressed"
    assert "GATE CLOSED" in result.stdout
    # It names the problems, those with moving obstacles, and the commands that show them again.
    lines = re.findall(r"^  (\w+) seed\d+: success -> collision   (pytest .*)$", result.stdout, re.MULTILINE)
    assert len(lines) >= 5
    assert {scenario for scenario, _ in lines} == {"traffic"}
    again = repository.run(f"{lines[0][1]} -n 0")
    assert again.returncode == 0  # counted, not failed: the repository says --lpb-assert=none
    assert "1 unsolved" in again.stdout
    assert "collision: 'body' hit obstacle" in again.stdout
    assert "regression gate" not in again.stdout


def test_a_slower_planner_is_stopped(repository: Repository) -> None:
    repository.edit("planners/dynamic_window.yaml", "period: 0.05  # [s]", "period: 0.05\nparameters: {speed: 0.9}")
    result = repository.run(commands()["Run all trials, and compare with the baseline"])
    assert result.returncode == 1
    assert verdicts(result.stdout)["time_to_goal_s"] == "regressed"
    summary = repository.run(commands()["Summary"])
    assert summary.returncode == 0
    text = (repository.path / "summary.md").read_text("utf-8")
    assert "❌ regressed" in text
    assert "**GATE CLOSED" in text


def test_the_readme_says_how_the_baseline_was_saved(repository: Repository) -> None:
    lines = re.findall(r"^    (pytest .*|lpb-report .*)$", (EXAMPLE / "README.md").read_text("utf-8"), re.MULTILINE)
    assert len(lines) == 2
    before = json.loads((repository.path / "baseline.json").read_text("utf-8"))
    for line in lines:
        assert repository.run(line).returncode == 0
    after = json.loads((repository.path / "baseline.json").read_text("utf-8"))
    assert after["columns"] == before["columns"]
    assert [line[:4] for line in after["planners"]["dynamic_window"]["trials"]] == [
        line[:4] for line in before["planners"]["dynamic_window"]["trials"]
    ]
    shutil.copy(EXAMPLE / "baseline.json", repository.path)
