"""Run folders come from anybody: what they name is not started, unless it is the user's own or was trusted."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.cli import main
from pytest_lpb.commands import EXIT_USAGE
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.plugin.strange_code import refuse_strange_code
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.inputs import planner_file
from pytest_lpb.run.own_planners import own_isolation

from .projects import FAST, LEAN, SCENARIO, Project, read_run, text_of

OPTIONS = [["--retime", "2"], ["--reproduce"]]


@pytest.fixture
def run(finished_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of a run of pd and potential_field, seen from a folder of its own."""
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    copy = shutil.copytree(finished_run, tmp_path / "run")
    for name in ("pd", "potential_field"):
        planner_file(copy, name).parent.mkdir(exist_ok=True)
        planner_file(copy, name).write_text(f"planner: {name}\n")
    return copy


def tamper(run: Path, keys: dict[str, Any]) -> None:
    """Have a run say that its pd was started with these keys."""
    info = read_run(run)
    planner = {} if "command" in keys else {"planner": "pd"}
    info["planners"]["pd"] |= {"planner": "", **planner, "isolation": {"isolate": True, **keys}}
    (run / "run.json").write_text(json.dumps(info))
    planner_file(run, "pd").write_text(json.dumps({**planner, **keys}))


def touching(path: Path) -> Path:
    """A program that leaves a file, and is no planner."""
    program = path.with_suffix(".sh")
    program.write_text(f"#!/bin/sh\ntouch {path}\n")
    program.chmod(0o755)
    return program


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: options[0])
@pytest.mark.parametrize("key", ["python", "command", "ssh", "environment", "working_dir"])
def test_what_a_run_names_is_not_started(
    run: Path, key: str, options: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    touched = run.parent / "touched"
    program = touching(touched)
    values = {
        "python": str(program),
        "command": [str(program), "a b"],
        "ssh": f"-o ProxyCommand={program} nowhere",
        "environment": {"LD_PRELOAD": str(program)},
        "working_dir": str(run),
    }
    tamper(run, {key: values[key]})
    assert main([str(run), *options, "--planners=pd"]) == (EXIT_USAGE if options[0] == "--retime" else 1)
    told = capsys.readouterr()
    text = told.err + told.out
    assert f"planner 'pd' would be started with {key}=" in text.replace("'" + key, key)
    assert "no planners/pd.yaml in the current folder says the same; call it where yours is, or add --trust-run" in text
    assert not touched.exists()


@pytest.mark.parametrize(
    ("isolation", "message"),
    [({"ssh": "-Z cell"}, "option -Z not recognized"), ({"command": "'"}, "No closing quotation"), ({"python": 3}, "")],
)
def test_damaged_keys_are_told(
    run: Path, isolation: dict[str, Any], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    tamper(run, isolation)
    assert main([str(run), "--retime", "2", "--planners=pd", "--trust-run"]) == EXIT_USAGE
    assert f"run.json: planner 'pd': isolation: {message}" in capsys.readouterr().err


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: options[0])
def test_it_is_started_when_it_was_trusted(run: Path, options: list[str]) -> None:
    touched = run.parent / "touched"
    tamper(run, {"python": str(touching(touched))})
    main([str(run), *options, "--planners=pd", "--trust-run"])
    assert touched.exists()


@pytest.mark.parametrize(
    ("own", "started"),
    [
        ("planner: pd\npython: ../../touched.sh\ndeadline_s: 3.0\n", True),
        ("planner: pd\npython: ../../other.sh\n", False),
        ("planner: mine:Pd\npython: ../../touched.sh\n", False),
        ("planner: pd\npython: ../../touched.sh\nenvironment: {A: b}\n", False),
        ("planner: pd\n", False),
    ],
)
def test_it_is_started_when_it_is_the_users_own(run: Path, own: str, started: bool) -> None:
    touched = run.parent / "touched"
    tamper(run, {"python": str(touching(touched))})
    Path("planners").mkdir()
    Path("planners/pd.yaml").write_text(own)
    main([str(run), "--reproduce"])
    assert touched.exists() is started


@pytest.mark.parametrize("folder", [".", "trials", "../another"])
def test_a_run_folder_is_nobodys_own(run: Path, folder: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even for whoever is in it, nor is another run's."""
    touched = run.parent / "touched"
    tamper(run, {"python": str(touching(touched))})
    if folder == "../another":
        shutil.copytree(run, run.parent / "another")
    shutil.copytree(run / "planners", run / "trials" / "planners")
    monkeypatch.chdir(run / folder)
    main([str(run), "--reproduce"])
    assert not touched.exists()


def test_modules_in_the_run_folder_are_not_imported(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even when it is the current folder, where Python and pytest would look for them."""
    for name in ("pytest", "conftest", "sneaky"):
        (run / f"{name}.py").write_text(f"open({str(run.parent / 'touched')!r}, 'w')\n")
    info = read_run(run)
    info["planners"]["pd"]["planner"] = "sneaky:Planner"
    (run / "run.json").write_text(json.dumps(info))
    planner_file(run, "pd").write_text("planner: sneaky:Planner\n")
    monkeypatch.chdir(run)
    assert main([".", "--reproduce"]) == 1
    assert main([".", "--retime", "2", "--planners=pd"]) == EXIT_USAGE
    assert main([".", "--retime", "2", "--planners=potential_field"]) == 0
    assert not (run.parent / "touched").exists()


def test_ones_own_interpreter_has_the_limits_of_the_run(run: Path) -> None:
    """And is started as it is written here, not there."""
    Path("planners").mkdir()
    Path("planners/far.yaml").write_text("planner: pd\npython: ../venv/../venv/bin/python\ndeadline_s: 3.0\n")
    recorded = Isolation(python=str(run.parent / "here/venv/bin/python"), isolate=True, memory_mb=900)
    isolation = own_isolation(RunFolder.open(run), "far", "pd", recorded, trusted=False)
    own = str(run.parent / "here/planners/../venv/../venv/bin/python")
    assert isolation == Isolation(python=own, isolate=True, memory_mb=900)


@pytest.mark.parametrize("name", ["conftest.py", "__init__.py", "pytest.ini"])
@pytest.mark.parametrize("folder", ["", "trials/a"])
def test_code_and_settings_on_the_way_to_a_file_are_refused(run: Path, name: str, folder: str) -> None:
    (run / "trials/a").mkdir()
    (run / folder / name).write_text("")
    with pytest.raises(pytest.UsageError, match=f"/{name}, which pytest would use; no run writes it: remove it"):
        refuse_strange_code([run / "trials/a/seed0.yaml"])
    refuse_strange_code([run.parent / "x.yaml", *([run / "run.json"] if folder else [])])


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_runs_in_other_encodings_are_runs(run: Path, encoding: str) -> None:
    (run / "run.json").write_text((run / "run.json").read_text("utf-8"), encoding=encoding)
    assert RunFolder.open(run).info()
    (run / "conftest.py").write_text("")
    with pytest.raises(pytest.UsageError, match="which pytest would use"):
        refuse_strange_code([run / "trials"])


def test_whose_problems_are_repeated_is_a_run_whatever_it_says(run: Path) -> None:
    (run / "run.json").write_text("{}")
    (run / "conftest.py").write_text("")
    latest = run.parent / "latest"
    latest.write_text("run\n")  # as where links are refused
    for named in (run, latest):
        with pytest.raises(pytest.UsageError, match="which pytest would use"):
            refuse_strange_code([], named)


@pytest.mark.parametrize("isolation", [{"python": "x", "environment": [1]}, {"deadline_s": "long"}, [1]])
def test_damaged_isolation_is_told(run: Path, isolation: Any, capsys: pytest.CaptureFixture[str]) -> None:
    info = read_run(run)
    info["planners"]["pd"]["isolation"] = isolation
    (run / "run.json").write_text(json.dumps(info))
    assert main([str(run), "--retime", "2", "--planners=pd"]) == EXIT_USAGE
    assert "run.json: planner 'pd': isolation: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        ("conftest.py", "--lpb-problems=../run"),
        ("pytest.ini", "../run/trials/seed0.yaml"),
        ("conftest.py", "../run"),
    ],
)
def test_pytest_uses_no_code_of_a_run_folder(run: Path, name: str, asked: str) -> None:
    """Nor settings, which could choose planners there."""
    touched = run.parent / "touched"
    (run / "planner.yaml").write_text(f"command: {touching(touched)}\n")
    (run / "trials/seed0.yaml").write_text(SCENARIO)
    text = f"[pytest]\naddopts = --lpb-planners={run}/planner.yaml\n"
    (run / name).write_text(text if name == "pytest.ini" else f"open({str(touched)!r}, 'w')\n")
    command = [sys.executable, "-m", "pytest", *LEAN, "-n", "0", FAST, asked]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert not touched.exists()
    assert result.returncode == EXIT_USAGE, result.stdout + result.stderr
    assert f"/{name}, which pytest would use; no run writes it: remove it" in result.stderr


def test_other_files_of_that_name_are_none_of_ours(project: Project) -> None:
    project.write("run.json", '{"scripts": {}}')
    project.write("conftest.py", "")
    project.run(project.scenario()).assert_outcomes(passed=1)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"options": {"lpb_planners": "pd,x=RUN/planners/pd.yaml"}}, "planners/pd.yaml"),
        ({"arguments": ["RUN/test_sneaky.py"]}, "test_sneaky.py"),
    ],
)
def test_a_run_to_finish_names_nothing_of_its_own(project: Project, change: dict[str, Any], named: str) -> None:
    project.scenario()
    project.run("scenarios")
    (run,) = project.runs()
    info = read_run(run)
    for key, value in change.items():
        text = json.dumps(value).replace("RUN", f"reports/{run.name}")
        info[key] = info[key] | json.loads(text) if isinstance(value, dict) else json.loads(text)
    (run / "run.json").write_text(json.dumps(info))
    result = project.run(f"--lpb-resume={run}", planners=None)
    assert result.ret == EXIT_USAGE
    assert f"names reports/{run.name}/{named}, which lies in the run folder itself" in text_of(result)


def test_a_run_to_finish_starts_what_is_configured(project: Project) -> None:
    """Paths are no part of a planner's hash."""
    touched = project.path / "touched"
    project.write("planners/far.yaml", f"planner: pd\npython: {sys.executable}\n")
    project.scenario()
    project.run("scenarios", planners="far").assert_outcomes(passed=1)
    (run,) = project.runs()
    info = read_run(run)
    info["planners"]["far"]["isolation"]["python"] = str(touching(touched))
    (run / "run.json").write_text(json.dumps(info))
    result = project.run(f"--lpb-resume={run}", planners=None)
    assert "changed since the run began: planner 'far' (isolation)" in text_of(result)
    assert not touched.exists()


def test_a_run_to_finish_sets_no_other_options(project: Project) -> None:
    project.scenario()
    project.run("scenarios")
    (run,) = project.runs()
    info = read_run(run)
    info["options"]["collectonly"] = True
    (run / "run.json").write_text(json.dumps(info))
    project.run(f"--lpb-resume={run}", planners=None).assert_outcomes(passed=1)
