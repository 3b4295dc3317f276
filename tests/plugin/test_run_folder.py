"""The run folder: its files, and every column of its tables, as the contract lists them."""

from __future__ import annotations

import json
import platform
import re
import socket
from pathlib import Path

import pyarrow.parquet
import pytest

from pytest_lpb.kpis.registry import default_registry
from pytest_lpb.run.folder import RunFolder

from .projects import DRAWN, UNSOLVED, Project, Row, read_run, read_table, text_of, trial_files

TRIAL_COLUMNS = [
    "node_id",
    "scenario",
    "planner",
    "seed",
    "outcome",
    "success",
    "failed_criteria",
    "steps",
    "problem_hash",
    "trajectory_hash",
    "wall_s",
    "attempt",
    "timing_contended",
]
SUMMARY_COLUMNS = [
    "scenario",
    "planner",
    "trials",
    "problems",
    "successes",
    "success_rate",
    "success_low",
    "success_high",
]
COMPARISON_COLUMNS = [
    "planner_a",
    "planner_b",
    "scenario",
    "kpi",
    "over",
    "pairs",
    "median_a",
    "median_b",
    "difference",
    "difference_low",
    "difference_high",
    "ratio",
    "p",
    "p_adjusted",
    "improvement_probability",
    "verdict",
]
SHA256 = re.compile("[0-9a-f]{64}")


@pytest.fixture
def run(project: Project) -> Path:
    """The folder of a run with all KPIs: two scenarios, two planners, two seeds."""
    project.scenario("scenarios/point/drawn.yaml", DRAWN)
    project.scenario("scenarios/far.yaml", UNSOLVED)
    result = project.run("--lpb-trials=2", "scenarios", planners="pd,potential_field", fast=False)
    result.assert_outcomes(passed=4, failed=4)
    assert result.ret == 1
    (folder,) = project.runs()
    return folder


def find(rows: list[Row], **values: str) -> Row:
    (row,) = [row for row in rows if all(row[key] == value for key, value in values.items())]
    return row


def test_content(run: Path) -> None:
    assert re.fullmatch(r"\d{8}T\d{6}Z-[0-9a-f]{6}", run.name)
    tables = {"trials.csv", "summary.csv", "comparisons.csv", "aggregates.csv"}
    expected = {"run.json", *tables, "report.html", "planners", "trials"}
    assert {path.name for path in run.iterdir()} == expected
    trials = [f"{s}/{p}/seed{k}" for s in ("far", "point/drawn") for p in ("pd", "potential_field") for k in (0, 1)]
    assert trial_files(run) == [f"{trial}.parquet" for trial in trials]
    everything = {path.relative_to(run / "trials").as_posix() for path in (run / "trials").rglob("*.*")}
    assert everything == {f"{trial}.{suffix}" for trial in trials for suffix in ("parquet", "yaml")}

    latest = run.parent / "latest"
    assert latest.is_symlink()
    assert latest.readlink() == Path(run.name)

    report = (run / "report.html").read_text("utf-8")
    assert "point/drawn" in report
    assert not re.search(r"""(?:src|href)=["']?(?:https?:)?//""", report)

    check_trials(read_table(run / "trials.csv"))
    check_summary(read_table(run / "summary.csv"))
    check_comparisons(read_table(run / "comparisons.csv"))
    for table in ("trials", "summary", "comparisons"):
        assert b"\r" not in (run / f"{table}.csv").read_bytes()
        assert b"nan" not in (run / f"{table}.csv").read_bytes().lower().replace(b"nan_", b"")


def check_trials(rows: list[Row]) -> None:
    kpis = [kpi.name for kpi in default_registry]
    assert list(rows[0]) == [*TRIAL_COLUMNS, *kpis, "contended_kpis"]
    assert len(kpis) > 30
    assert len(rows) == 8
    assert [(row["scenario"], row["planner"], row["seed"]) for row in rows] == sorted(
        (row["scenario"], row["planner"], row["seed"]) for row in rows
    )
    row = find(rows, scenario="point/drawn", planner="pd", seed="1")
    assert row["node_id"] == "scenarios/point/drawn.yaml::pd::seed1"
    assert (row["outcome"], row["success"], row["failed_criteria"], row["attempt"]) == (
        "success",
        "true",
        "",
        "1",
    )
    assert SHA256.fullmatch(row["problem_hash"])
    assert SHA256.fullmatch(row["trajectory_hash"])
    assert 0.0 < float(row["wall_s"]) < 10.0
    assert row["timing_contended"] in ("true", "false")
    assert float(row["time_to_goal_s"]) >= 0.0
    assert row["clearance_min_m"] == ""  # no obstacle: not applicable, an empty cell
    failed = find(rows, scenario="far", planner="pd", seed="0")
    assert (failed["outcome"], failed["success"], failed["steps"]) == ("timeout", "false", "10")
    assert failed["time_to_goal_s"] == ""
    # Planners are given the same problems; seeds draw different ones.
    drawn = [row for row in rows if row["scenario"] == "point/drawn"]
    assert len({row["problem_hash"] for row in drawn}) == 2
    assert len({row["trajectory_hash"] for row in drawn}) == 4


def check_summary(rows: list[Row]) -> None:
    figures = [f"{kpi.name}_{figure}" for kpi in default_registry for figure in ("median", "q1", "q3", "n")]
    assert list(rows[0])[: len(SUMMARY_COLUMNS) + len(figures)] == [*SUMMARY_COLUMNS, *figures]
    assert {(row["scenario"], row["planner"]) for row in rows} == {
        (scenario, planner) for scenario in ("all", "far", "point/drawn") for planner in ("pd", "potential_field")
    }
    far = find(rows, scenario="far", planner="pd")
    assert [far[key] for key in ("trials", "problems", "successes", "success_rate")] == ["2", "1", "0", "0.0"]
    drawn = find(rows, scenario="point/drawn", planner="pd")
    assert [drawn[key] for key in ("trials", "problems", "successes", "success_rate")] == [
        "2",
        "2",
        "2",
        "1.0",
    ]
    overall = find(rows, scenario="all", planner="pd")
    assert [overall[key] for key in ("trials", "problems", "successes", "success_rate")] == [
        "4",
        "3",
        "2",
        "0.5",
    ]
    assert float(overall["success_low"]) < 0.5 < float(overall["success_high"])


def check_comparisons(rows: list[Row]) -> None:
    assert list(rows[0]) == COMPARISON_COLUMNS
    assert {(row["planner_a"], row["planner_b"]) for row in rows} == {("pd", "potential_field")}
    assert {row["scenario"] for row in rows} == {"all", "far", "point/drawn"}
    assert {row["kpi"] for row in rows} == {"success", *(kpi.name for kpi in default_registry)}
    assert {row["verdict"] for row in rows} <= {"better", "worse", "same", "inconclusive", ""}
    solved = find(rows, scenario="all", kpi="path_length_m")
    assert (solved["over"], solved["pairs"]) == ("solved", "2")
    assert find(rows, scenario="all", kpi="success")["pairs"] == "3"


def test_run_information(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    name = "secret-machine-name"
    monkeypatch.setattr(socket, "gethostname", lambda: name)
    monkeypatch.setattr(platform, "node", lambda: name)
    project.scenario()
    project.write("planners/slow.yaml", "planner: pd\nparameters: {p: 0.5}\nperiod: 0.1\n")
    arguments = ("--lpb-trials=2", "--lpb-seed=4", "scenarios")
    project.run(*arguments, planners="slow").assert_outcomes(passed=2)
    info = read_run(project.runs()[-1])
    assert info["schema_version"] == 1
    assert info["command"] == ["pytest", "--lpb-planners=slow", "--lpb-kpis=time_to_goal_s", *arguments]
    assert info["seeds"] == {"first": 4, "trials": 2}
    assert (info["random"], info["assert"], info["workers"]) == ([], "trial", 1)
    assert info["kpis"] == ["time_to_goal_s"]
    planner = info["planners"]["slow"]
    assert planner["parameters"] | {"p": 0.5, "k": 2.0} == planner["parameters"]
    assert planner["period"] == 0.1
    assert SHA256.fullmatch(planner["parameters_hash"])
    assert SHA256.fullmatch(planner["source_hash"])
    scenario = info["scenarios"]["point/x"]
    assert scenario["file"] == str(project.path / "scenarios/point/x.yaml")
    assert SHA256.fullmatch(scenario["hash"])
    assert info["packages"]["pytest-lpb"]
    assert info["packages"]["numpy"]
    assert info["machine"]["cores"] >= 1
    assert info["git"] is None
    assert name not in json.dumps(info)
    assert socket.gethostname() == name


def test_git_commit(project: Project) -> None:
    git = ["git", "-c", "user.name=A", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false"]
    project.scenario()
    for command in (["init", "-q"], ["add", "scenarios"], ["commit", "-q", "-m", "Begin"]):
        assert project.pytester.run(*git, *command).ret == 0
    commit = project.pytester.run("git", "rev-parse", "HEAD").stdout.str().strip()
    project.run("scenarios")
    assert read_run(project.runs()[-1])["git"] == {"commit": commit, "dirty": False}
    project.scenario(content=UNSOLVED)
    project.run("scenarios")
    assert read_run(project.runs()[-1])["git"] == {"commit": commit, "dirty": True}


def test_trial_file(project: Project) -> None:
    rock = "obstacles: [{name: rock, shape: circle, radius: 0.1, position: [1, 1]}]\n"
    project.scenario(content=UNSOLVED + rock)
    project.run("scenarios")
    file = project.runs()[-1] / "trials/point/x/pd/seed0.parquet"
    table = pyarrow.parquet.read_table(file)
    expected = {"t", "q0", "q1", "qd0", "qd1", "u0", "u1", "action0", "action1", "applied0", "applied1"}
    expected |= {"link_body_x", "link_body_y", "goal_reach_0", "goal_reach_1", "goal_reach_error"}
    expected |= {"obstacle_rock_x", "obstacle_rock_y", "clearance_m", "clearance_body", "clearance_obstacle"}
    expected |= {"self_clearance_m", "solver_wall_ms", "solver_cpu_ms"}
    assert expected <= set(table.column_names)
    assert table.num_rows == 11
    assert table.schema.field("action0").metadata == {b"unit": b"m/s^2"}
    metadata = json.loads(table.schema.metadata[b"pytest_lpb"])
    assert metadata["node_id"] == "scenarios/point/x.yaml::pd::seed0"
    assert metadata["outcome"] == "timeout"
    for key in ("message", "wall_s", "parameters", "problem_hash", "trajectory_hash", "parameters_hash"):
        assert metadata[key]


def test_latest_leads_to_the_newest(project: Project) -> None:
    project.scenario()
    for _ in range(2):
        project.run("scenarios")
    first, second = project.runs()
    assert first != second
    assert (project.path / "reports/latest").resolve() == second


def test_latest_is_a_file_where_links_are_refused(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object, **keywords: object) -> None:
        raise OSError(1, "Operation not permitted")

    monkeypatch.setattr(Path, "symlink_to", refuse)
    project.scenario()
    project.run("scenarios")
    project.run("scenarios")
    latest = project.path / "reports/latest"
    assert not latest.is_symlink()
    assert latest.read_text() == f"{project.runs()[-1].name}\n"
    assert RunFolder.open(latest).path == project.runs()[-1]


def test_summary_on_the_terminal(project: Project) -> None:
    project.scenario()
    project.scenario("scenarios/far.yaml", UNSOLVED)
    result = project.run("scenarios")
    text = text_of(result)
    assert "local planner benchmark" in text
    result.stdout.re_match_lines([r"pd +1/2 +2 +50 %"])
    assert "far :: pd :: seed0  timeout: reached" in text
    assert f"report: reports/{project.runs()[-1].name}/report.html" in text


@pytest.mark.parametrize("option", ["--lpb-reports=out/here", "ini"])
def test_reports_folder(project: Project, monkeypatch: pytest.MonkeyPatch, option: str) -> None:
    # Options are relative to the invocation directory, ini values to the ini file.
    project.scenario()
    project.ini(*(["lpb_reports = out/here"] if option == "ini" else []))
    monkeypatch.chdir(project.path / "scenarios")
    project.run(*([] if option == "ini" else [option]), ".").assert_outcomes(passed=1)
    assert len(project.runs("out/here" if option == "ini" else "scenarios/out/here")) == 1
