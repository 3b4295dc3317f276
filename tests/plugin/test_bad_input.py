"""What is wrong is said in one message with its place, without a traceback, and leaves nothing behind."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from .projects import SCENARIO, Project, text_of

OPTIONS = {
    "unknown planner": (("--lpb-planners=potential_feld",), "unknown planner 'potential_feld'; did you mean"),
    "repeated planner": (("--lpb-planners=pd,pd",), "planner 'pd' is named twice in pd, pd"),
    "no planner file": (("--lpb-planners=mine=none.yaml",), "planner 'mine': cannot read"),
    "class as planner": (("--lpb-planners=mod:Class",), "give it a name in a file `NAME.yaml`"),
    "unknown KPI": (
        ("--lpb-kpis=time_to_gaol_s",),
        "unknown KPI 'time_to_gaol_s'; did you mean 'time_to_goal_s'",
    ),
    "no KPI": (("--lpb-kpis=,",), "--lpb-kpis: found no name"),
    "no trials": (("--lpb-trials=0",), "--lpb-trials: found 0; allowed are 1 to 1000000"),
    "trials in words": (("--lpb-trials=many",), "--lpb-trials: invalid int value: 'many'"),
    "negative seed": (("--lpb-seed=-1",), "--lpb-seed: found -1; allowed are 0 to "),
    "assert what": (("--lpb-assert=maybe",), "argument --lpb-assert: invalid choice: 'maybe'"),
    "reports in a file": (
        ("--lpb-reports=taken",),
        "it is not a folder; choose another with --lpb-reports=DIR",
    ),
    "reports below a file": (("--lpb-reports=taken/a/b",), "taken: it is not a folder; choose another with"),
    "reports in /proc": (("--lpb-reports=/proc/lpb",), "cannot write to /proc"),
    "no such module": (
        ("-o", "lpb_plugins=no_such_module"),
        "lpb_plugins: cannot import 'no_such_module': No module",
    ),
    "module that raises": (
        ("-o", "lpb_plugins=raises"),
        "lpb_plugins: cannot import 'raises': ZeroDivisionError: division by zero (",
    ),
    "module with a syntax error": (
        ("-o", "lpb_plugins=no_python"),
        "lpb_plugins: cannot import 'no_python': SyntaxError: ",
    ),
    "abbreviation": (("--lpb-plan=pd",), "unrecognized arguments: --lpb-plan=pd"),
}


def fill(project: Project) -> None:
    project.scenario()
    project.write("taken", "a file\n")
    project.write("raises.py", "1 / 0\n")
    project.write("no_python.py", "def def\n")


def expect(project: Project, result: pytest.RunResult, code: int, message: str) -> None:
    text = text_of(result)
    assert message in text
    assert "Traceback" not in text
    assert "INTERNALERROR" not in text
    assert result.ret == code
    assert not (project.path / "reports").exists()


@pytest.mark.parametrize(("arguments", "message"), OPTIONS.values(), ids=list(OPTIONS))
def test_wrong_options(project: Project, arguments: tuple[str, ...], message: str) -> None:
    fill(project)
    expect(project, project.run(*arguments, "scenarios"), 4, message)


@pytest.mark.parametrize("name", ["unknown planner", "no trials", "module that raises"])
def test_wrong_options_with_workers(project: Project, name: str) -> None:
    fill(project)
    arguments, message = OPTIONS[name]
    result = project.run_workers(*arguments, "scenarios")
    expect(project, result, 4, message)
    assert text_of(result).count(message) == 1


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is read-only for root")
def test_a_reports_folder_without_permission(project: Project) -> None:
    fill(project)
    folder = project.path / "locked"
    folder.mkdir(mode=0o500)
    expect(project, project.run("--lpb-reports=locked/here", "scenarios"), 4, "cannot write to")


PLANNER_FILES = {
    "unknown key": ("planner: pd\nperid: 0.1\n", "mine.yaml:2: perid: unknown key; did you mean 'period'?"),
    "unknown parameter": (
        "planner: pd\nparameters: {gain: 1.0}\n",
        "mine.yaml:2: parameters: gain: unknown parameter; PD has ",
    ),
    "parameter of a robot": (
        "planner: pd\nper_robot: {point: {q: 1.0}}\n",
        "mine.yaml:2: per_robot: point: q: unknown",
    ),
    "wrong type": (
        "planner: pd\nparameters: {p: strong}\n",
        "p: Input should be a valid number, found 'strong'",
    ),
    "boolean as number": (
        "planner: pd\nparameters: {p: true}\n",
        "p: Input should be a valid number, found True",
    ),
    "text as period": ("planner: pd\nperiod: soon\n", "mine.yaml:2: period: "),
    "unknown class": ("planner: pdd\n", "unknown planner 'pdd'; did you mean 'pd'?"),
    "no module": ("planner: nowhere.to:Be\n", "cannot import 'nowhere.to'"),
    "no class in the module": ("planner: os:PD\n", "'os' has no 'PD'"),
    "no planner": ("planner: os:getcwd\n", "not a subclass of pytest_lpb.Planner"),
    "no key planner": ("period: 0.1\n", "planner: missing"),
    "duplicate key": ("planner: pd\nplanner: pd\n", "mine.yaml:2: planner: duplicate key"),
    "a list": ("- pd\n", "mine.yaml:1: "),
    "empty": ("", "mine.yaml:1: the file is empty"),
    "no YAML": ("planner: [pd\n", "mine.yaml:2: not YAML"),
}


@pytest.mark.parametrize(("content", "message"), PLANNER_FILES.values(), ids=list(PLANNER_FILES))
def test_wrong_planner_files(project: Project, content: str, message: str) -> None:
    project.scenario()
    project.write("planners/mine.yaml", content)
    expect(project, project.run("scenarios", planners="mine"), 4, message)


@pytest.mark.parametrize("key", ["period", "delay"])
def test_times_of_a_planner_that_do_not_suit_the_scenario(project: Project, key: str) -> None:
    project.scenario()
    project.write("planners/mine.yaml", f"planner: pd\n{key}: 0.07\n")
    message = f"{key}: 0.07 s is no multiple of this scenario's dt = 0.05 s; use 0.05"
    expect(project, project.run("scenarios", planners="mine"), 2, message)


ALIAS_BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join([f'*{before}'] * 9)}]\n" for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
OBSTACLE = "obstacles: [{name: rock, shape: circle, radius: 1.0, position: [%s]}]\n"
ARM = SCENARIO.replace("{model: point, body_radius: 0.2}", "{model: planar_arm, links: 2}").replace(
    "link: body, target: [0.05, 0.0]", "link: end, target: [5.0, 0.0]"
)

SCENARIOS: dict[str, tuple[str | bytes, str]] = {
    "unknown key": (SCENARIO + "colour: blue\n", "x.yaml:9: colour: unknown key"),
    "misspelt key": (SCENARIO + "obstacle: []\n", "x.yaml:9: obstacle: unknown key; did you mean 'obstacles'?"),
    "duplicate key": (SCENARIO + "version: 1\n", "x.yaml:9: version: duplicate key"),
    "text in a number": (SCENARIO.replace("dt: 0.05", "dt: fast"), "environment.dt: found the text 'fast'"),
    "boolean in a number": (SCENARIO.replace("dt: 0.05", "dt: true"), "environment.dt: found the boolean true"),
    "not a number": (SCENARIO.replace("dt: 0.05", "dt: .nan"), "x.yaml:4: environment.dt: found"),
    "wrong length": (SCENARIO.replace("q: [0, 0]", "q: [0, 0, 0]"), "x.yaml:5: start.q: "),
    "alias bomb": (ALIAS_BOMB, "(aliases expanded); that is too many"),
    "syntax error": (SCENARIO + "obstacles: [\n", "x.yaml:10: not YAML"),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\x00", "x.yaml:1: found the byte 0x89; it must be a text file in UTF-8"),
    "empty": ("", "x.yaml:1: the file is empty; a scenario is a mapping that begins with `version: 1`"),
    "start in collision": (SCENARIO + OBSTACLE % "0, 0.9", "x.yaml:5: start: "),
    "goal in collision": (SCENARIO.replace("[0.05, 0.0]", "[3.0, 0.0]") + OBSTACLE % "3, 0", "x.yaml:6: goal: "),
    "goal out of reach": (ARM, "x.yaml:6: goal: "),
    "unknown KPI": (
        SCENARIO.replace("{hold_time: 0.2}", "{clearance_mim_m: '>= 0.02'}"),
        "x.yaml:8: success: unknown KPI 'clearance_mim_m'; did you mean 'clearance_min_m' or",
    ),
    "criterion without a sign": (SCENARIO.replace("{hold_time: 0.2}", "{rate: 0.8}"), "x.yaml:8: success.rate: "),
}  # fmt: skip


def write_scenario(project: Project, content: str | bytes) -> None:
    file = project.scenario(content="")
    file.write_bytes(content.encode() if isinstance(content, str) else content)


@pytest.mark.parametrize(("content", "message"), SCENARIOS.values(), ids=list(SCENARIOS))
def test_wrong_scenarios(project: Project, content: str | bytes, message: str) -> None:
    write_scenario(project, content)
    result = project.run("scenarios")
    expect(project, result, 2, message)
    result.assert_outcomes(errors=1)


@pytest.mark.parametrize("name", ["unknown key", "goal out of reach"])
def test_wrong_scenarios_with_workers(project: Project, name: str) -> None:
    content, message = SCENARIOS[name]
    write_scenario(project, content)
    result = project.run_workers("scenarios")
    assert result.ret in (1, 2)
    expect(project, result, int(result.ret), message)


def test_several_faults_at_once(project: Project) -> None:
    project.scenario(content=SCENARIO.replace("dt: 0.05", "dt: fast").replace("q: [0, 0]", "p: [0]"))
    text = text_of(project.run("scenarios"))
    assert "x.yaml:4: environment.dt: " in text
    assert "x.yaml:5: start.p: unknown key" in text


def test_other_scenarios_do_not_run_when_one_is_wrong(project: Project) -> None:
    project.scenario()
    project.scenario("scenarios/wrong.yaml", "version: 2\n")
    expect(project, project.run("scenarios"), 2, "wrong.yaml:1: version: ")


def test_other_scenarios_run_when_asked_to_continue(project: Project) -> None:
    project.scenario()
    project.scenario("scenarios/wrong.yaml", "version: 2\n")
    result = project.run("--continue-on-collection-errors", "scenarios")
    result.assert_outcomes(passed=1, errors=1)
    assert project.row()["scenario"] == "point/x"


def test_a_missing_file_is_what_pytest_says(project: Project) -> None:
    expect(
        project,
        project.run(Path("scenarios/none.yaml")),
        4,
        "file or directory not found: scenarios/none.yaml",
    )


def test_a_run_folder_that_cannot_be_made_is_a_usage_error(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    project.scenario()
    monkeypatch.setattr("pytest_lpb.plugin.places.check_writable", lambda reports: None)
    project.write("reports", "a file\n")
    result = project.run("scenarios")
    assert result.ret == 4
    assert "cannot make " in text_of(result)
    assert "Traceback" not in text_of(result)
