"""Planners and KPIs of users: conftest.py, `module:Class`, NAME=PATH, `lpb_plugins`."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

from .projects import SCENARIO, Project, read_run, read_table, text_of

PLANNER = """
from dataclasses import dataclass
import numpy as np
from pytest_lpb import Planner

class Mine(Planner):
    name = "mine"

    @dataclass(frozen=True)
    class Parameters:
        push: float = 0.25

    def compute_action(self, observation):
        self.diagnostics["calls"] = float(observation["t"][()])
        return np.array([self.parameters.push, 0.0])
"""
KPI = """
from pytest_lpb import kpi

@kpi(name="x_max_m", unit="m", direction="higher", over="all")
def x_max(trajectory):
    return trajectory.link("body")[:, 0].max()
"""
RAISING = """
from pytest_lpb import kpi

@kpi(name="broken_m", unit="m", direction="higher", over="all")
def broken(trajectory):
    raise ValueError("no such thing")
"""


def test_a_planner_and_a_kpi_of_conftest(project: Project) -> None:
    project.write("conftest.py", PLANNER + KPI)
    project.scenario(content=SCENARIO)
    project.run("--lpb-kpis=x_max_m,time_to_goal_s", "scenarios", planners="mine").assert_outcomes(passed=1)
    row = project.row()
    # Two kinds of arithmetic give the same: 0.25 m/s^2 for 0.2 s.
    assert 0.0 < float(row["x_max_m"]) < 0.01
    run = project.runs()[-1]
    (summary, _) = read_table(run / "summary.csv")
    assert summary["x_max_m_median"] == row["x_max_m"]
    (aggregate,) = (line for line in read_table(run / "aggregates.csv") if line["kpi"] == "x_max_m")
    assert aggregate["iqm"] == aggregate["mean_of_scenarios"] == row["x_max_m"]
    info = read_run(run)
    assert info["plugins"] == [{"module": "conftest", "file": str(project.path / "conftest.py")}]
    assert info["planners"]["mine"]["parameters"] == {"push": 0.25}


@pytest.mark.parametrize(
    ("planners", "name"),
    [
        ("tuned", "tuned"),
        ("planners/tuned.yaml", "tuned"),
        ("other=planners/tuned.yaml", "other"),
        ("./planners/../planners/tuned.yaml", "tuned"),
    ],
)
def test_a_class_of_a_module_beside_the_ini_file(project: Project, planners: str, name: str) -> None:
    project.ini()
    project.write("my_package/__init__.py", "")
    project.write("my_package/planners.py", PLANNER)
    project.write("planners/tuned.yaml", "planner: my_package.planners:Mine\nparameters: {push: 0.5}\n")
    project.scenario()
    project.run("scenarios", planners=planners).assert_outcomes(passed=1)
    assert project.row()["planner"] == name
    planner = read_run(project.runs()[-1])["planners"][name]
    assert planner["parameters"] == {"push": 0.5}
    assert planner["planner"] == "my_package.planners:Mine"


def test_planners_of_the_ini_file(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    project.ini("lpb_planners = pd strong=tuning/strong.yaml", "lpb_planners_dir = tuning")
    project.write("tuning/strong.yaml", "planner: pd\nparameters: {p: 5.0}\n")
    project.write("tuning/weak.yaml", "planner: pd\nparameters: {p: 0.1}\n")
    project.scenario()
    monkeypatch.chdir(project.path / "scenarios")
    project.run(planners=None).assert_outcomes(passed=2)
    run = project.path / "scenarios"
    project.run("--lpb-reports=../reports", planners="weak").assert_outcomes(passed=1)
    assert project.row()["planner"] == "weak"
    assert len(list((run / "reports").glob("2*"))) == 1


def test_a_planner_of_the_repository_hides_a_shipped_one(project: Project) -> None:
    project.write("planners/pd.yaml", "planner: pd\nparameters: {p: 7.0}\n")
    project.scenario()
    project.run("scenarios").assert_outcomes(passed=1)
    assert read_run(project.runs()[-1])["planners"]["pd"]["parameters"]["p"] == 7.0


def test_parameters_of_a_robot(project: Project) -> None:
    project.write("planners/own.yaml", "planner: pd\nparameters: {p: 1.0}\nper_robot: {point: {p: 9.0}}\n")
    project.write("planners/nine.yaml", "planner: pd\nparameters: {p: 9.0}\n")
    project.scenario()
    project.run("scenarios", planners="own,nine,pd").assert_outcomes(passed=3)
    digests = {planner: digest for (_, planner, _), digest in project.hashes().items()}
    assert digests["own"] == digests["nine"] != digests["pd"]


def lpb_report(folder: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    script = f"import sys; from pytest_lpb.cli import main; sys.exit(main({[str(a) for a in arguments]!r}))"
    return subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("place", ["plain", "package"])
def test_lpb_plugins_are_loaded_again_by_the_report(
    project: Project, tmp_path_factory: pytest.TempPathFactory, place: str
) -> None:
    package = place == "package"
    module = "measures.kpis" if package else "my_kpis"
    # The module leans on a neighbour, which the report has to find as well.
    project.write("measures/__init__.py", "")
    project.write("measures/base.py" if package else "neighbour.py", "OFFSET = 5.0\n")
    source = f"from {'.base' if package else 'neighbour'} import OFFSET\n{KPI.replace('.max()', '.max() + OFFSET')}"
    project.write(f"{module.replace('.', '/')}.py", source)
    project.ini(f"lpb_plugins = {module}")
    project.scenario()
    project.run("--lpb-kpis=x_max_m", "scenarios").assert_outcomes(passed=1)
    value = project.row()["x_max_m"]
    assert float(value) > 5.0
    run = project.runs()[-1]
    (run / "trials.csv").unlink()
    result = lpb_report(tmp_path_factory.mktemp("elsewhere"), run)
    assert (result.returncode, result.stderr) == (0, "")
    assert project.row()["x_max_m"] == value


def test_kpis_of_two_conftest_files(project: Project, tmp_path: Path) -> None:
    project.write("conftest.py", KPI)
    project.write("scenarios/conftest.py", KPI.replace("x_max", "y_max").replace("[:, 0]", "[:, 1]"))
    project.scenario()
    project.run("--lpb-kpis=x_max_m,y_max_m", "scenarios").assert_outcomes(passed=1)
    before = project.row()
    files = {entry["file"] for entry in read_run(project.runs()[-1])["plugins"]}
    assert files == {str(project.path / "conftest.py"), str(project.path / "scenarios/conftest.py")}
    result = lpb_report(tmp_path, project.runs()[-1])
    assert (result.returncode, result.stderr) == (0, "")
    assert project.row() == before


def test_a_plot_of_conftest_is_recorded(project: Project) -> None:
    project.write(
        "conftest.py",
        """
from pytest_lpb import plot

@plot(name="mine", scope="trial")
def mine(trajectory, axes):
    axes.plot(trajectory.t, trajectory.t)
""",
    )
    project.scenario()
    project.run("scenarios").assert_outcomes(passed=1)
    (entry,) = read_run(project.runs()[-1])["plugins"]
    assert entry["file"] == str(project.path / "conftest.py")


def test_a_kpi_that_raises(project: Project, tmp_path: Path) -> None:
    project.write("conftest.py", RAISING)
    project.scenario()
    result = project.run("--lpb-kpis=broken_m,time_to_goal_s", "scenarios")
    result.assert_outcomes(passed=1)
    assert result.ret == 1
    row = project.row()
    assert row["broken_m"] == ""
    assert not math.isnan(float(row["time_to_goal_s"]))
    text = text_of(result)
    assert "warning: KPI broken_m is NaN for scenarios/point/x.yaml::pd::seed0: ValueError: no such thing" in text
    again = lpb_report(tmp_path, project.runs()[-1])
    assert again.returncode == 1
    assert "lpb-report: warning: KPI broken_m is NaN for" in again.stderr


@pytest.mark.parametrize("content", ["import gone_for_good\n", "1 / 0\n", None])
def test_a_module_that_is_gone_is_a_warning_of_the_report(
    project: Project, tmp_path: Path, content: str | None
) -> None:
    file = project.write("my_kpis.py", KPI)
    project.ini("lpb_plugins = my_kpis")
    project.scenario()
    project.pytester.runpytest_inprocess("--lpb-planners=pd", "scenarios").assert_outcomes(passed=1)
    assert project.row()["x_max_m"]
    if content is None:
        file.unlink()
    else:
        file.write_text(content)
    result = lpb_report(tmp_path, project.runs()[-1], "--output", tmp_path / "out")
    assert result.returncode == 1
    assert "warning: module 'my_kpis' and its KPIs are left out: " in result.stderr
    assert "Traceback" not in result.stderr
    assert "x_max_m" not in read_table(tmp_path / "out/trials.csv")[0]


def test_two_kpis_of_one_name(project: Project) -> None:
    project.write("my_kpis.py", KPI.replace("x_max_m", "clearance_min_m"))
    project.ini("lpb_plugins = my_kpis")
    project.scenario()
    result = project.run("scenarios")
    assert result.ret == 4
    assert "KPI 'clearance_min_m' is defined twice" in text_of(result)
