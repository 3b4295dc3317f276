"""Keys of planner files that ask for a process: what they mean, and what is wrong with them."""

from __future__ import annotations

import pickle
import shlex
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.interpreter import gateway_spec
from pytest_lpb.isolation.settings import Isolation, faults_here, isolation_of
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import read_planner
from pytest_lpb.run.inputs import planner_file, write_planner_files


def read(folder: Path, text: str, name: str = "mine") -> PlannerConfiguration:
    path = folder / "planners" / f"{name}.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    return read_planner(path, name)


def test_without_the_keys_a_planner_runs_here(tmp_path: Path) -> None:
    assert read(tmp_path, "planner: pd\n").isolation is None
    assert read(tmp_path, "planner: pd\nisolate: false\n").isolation is None


@pytest.mark.parametrize("line", ["isolate: true", "deadline_s: 0.5", "setup_deadline_s: 5", "memory_mb: 900"])
def test_any_limit_asks_for_a_process_of_this_interpreter(tmp_path: Path, line: str) -> None:
    isolation = read(tmp_path, f"planner: pd\n{line}\n").isolation
    assert isolation is not None
    assert isolation.isolate
    assert isolation.same_interpreter


def test_paths_are_relative_to_the_planner_file(tmp_path: Path) -> None:
    text = "planner: m:C\npython: ../venv/bin/python\nworking_dir: ../work\nenvironment: {A: b}\n"
    isolation = read(tmp_path, text).isolation
    assert isolation is not None
    assert Path(isolation.python or "").resolve() == (tmp_path / "venv/bin/python").resolve()
    assert Path(isolation.working_dir or "").resolve() == (tmp_path / "work").resolve()
    assert isolation.environment == {"A": "b"}


def test_programs_without_a_slash_are_found_in_path_and_commands_split_like_a_shell(tmp_path: Path) -> None:
    assert isolation_of({"python": "python3.9"}, tmp_path) == Isolation(python="python3.9", isolate=True)
    isolation = read(tmp_path, "command: ./pd --gain '1 2'\n").isolation
    assert isolation is not None
    assert isolation.command == (str(tmp_path / "planners" / "pd"), "--gain", "1 2")
    isolation = read(tmp_path, "command: [./p d, x]\n").isolation
    assert isolation is not None
    assert isolation.command == (str(tmp_path / "planners" / "p d"), "x")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("planner: pd\ndeadline_s: 0\n", "mine.yaml:2: deadline_s: Input should be greater than 0"),
        ("planner: pd\nmemory_mb: 1.5\n", "mine.yaml:2: memory_mb: Input should be a valid integer"),
        ("planner: pd\nisolate: maybe\n", "mine.yaml:2: isolate: Input should be a valid boolean"),
        ("planner: pd\nisolate: false\ndeadline_s: 1\n", "mine.yaml:2: isolate: found false, but other keys ask"),
        ("planner: pd\ncommand: ./x\n", "mine.yaml:1: planner: a program (`command`) has no class"),
        ("command: ./x\npython: y\n", "mine.yaml:1: command: a program needs no `python` or `ssh`"),
        ("planner: pd\nenvironment: {A: 1}\n", "mine.yaml:2: environment.A: Input should be a valid string"),
        ("planner: pd\npyhton: x\n", "mine.yaml:2: pyhton: unknown key; did you mean 'python'?"),
        ("planner: m:C\nssh: -Z me@robot\n", "mine.yaml:2: ssh: found '-Z me@robot': option -Z not recognized"),
        ("planner: m:C\nssh: -p 22\n", "mine.yaml:2: ssh: found '-p 22', which names 0 hosts; write user@host"),
        ("planner: m:C\nssh: robot python3\n", "mine.yaml:2: ssh: found 'robot python3', which names 2 hosts"),
        ("planner: pd\npreview: {steps: 3, step_s: 0.1}\n", "mine.yaml:2: preview: is for programs (`command`)"),
        ("command: ./x\npreview: {steps: 0, step_s: 0.1}\n", "mine.yaml:2: preview.steps: Input should be greater"),
        ("command: ./x\npreview: {steps: 3}\n", "mine.yaml:2: preview.step_s: Field required"),
        ("isolate: true\n", "mine.yaml:1: planner: missing; name the planner's class here"),
    ],
)
def test_faults_have_their_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        read(tmp_path, text)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("planner: m:C\npython: ../no/python\n", "2: python: no/python is no program that can be run"),
        ("planner: m:C\npython: mine.yaml\n", "2: python: mine.yaml is no program that can be run"),
        ("planner: m:C\nworking_dir: ../nowhere\n", "2: working_dir: nowhere is no folder"),
        ("command: ./nothing --fast\nworking_dir: .\n", "1: command: planners/nothing is no program that can be run"),
        ("command: [sh]\nworking_dir: mine.yaml\n", "2: working_dir: planners/mine.yaml is no folder"),
    ],
)
def test_what_is_not_on_this_host_has_its_line(tmp_path: Path, text: str, message: str) -> None:
    line, key, what = message.split(": ")
    with pytest.raises(ConfigurationError) as caught:
        read(tmp_path, text).check()
    told = str(caught.value)
    assert told.startswith(f"{tmp_path}/planners/mine.yaml:{line}: {key}: ")
    assert told.endswith(what)


def test_folders_of_another_host_are_looked_for_there(tmp_path: Path) -> None:
    isolation = read(tmp_path, "planner: m:C\nssh: cell\npython: ./no\nworking_dir: nowhere\n").isolation
    assert isolation is not None
    assert list(faults_here(isolation)) == []


def test_isolation_alone_is_no_other_planner_but_a_limit_is(tmp_path: Path) -> None:
    texts = ["", "isolate: true\n", "deadline_s: 0.5\n"]
    here, isolated, limited = (read(tmp_path, f"planner: pd\n{text}").parameters_hash for text in texts)
    assert here == isolated != limited


def test_what_a_hash_says_holds_on_any_machine() -> None:
    first = Isolation(command=("/here/pd", "--fast"), isolate=True, working_dir="/here")
    assert first.hashed() == replace(first, command=("/there/pd", "--fast"), working_dir="/there").hashed()
    assert first.hashed() != replace(first, command=("/here/pd", "--slow")).hashed()


def test_the_run_folder_holds_the_keys(tmp_path: Path) -> None:
    configuration = read(tmp_path, "planner: pd\ndeadline_s: 0.5\nenvironment: {A: b}\nmemory_mb: 900\n")
    write_planner_files(tmp_path, [configuration])
    again = read_planner(planner_file(tmp_path, "mine"), "mine")
    assert again.isolation == configuration.isolation
    assert configuration.to_dict()["isolation"]["deadline_s"] == 0.5
    assert pickle.loads(pickle.dumps(configuration)).isolation == configuration.isolation


def test_what_execnet_is_told_to_start() -> None:
    spec = gateway_spec(Isolation(isolate=True))
    assert spec.popen
    assert spec.python is not None
    assert spec.python.startswith("env OMP_NUM_THREADS=1 ")
    assert spec.python.endswith(f" {sys.executable}")
    there = gateway_spec(Isolation(python="/a b/python", environment={"URL": "http://x", "OMP_NUM_THREADS": "2"}))
    assert there.python is not None
    assert there.python.startswith("env -u PYTHONPATH -u PYTHONHOME OMP_NUM_THREADS=2 ")
    assert "URL=http://x" in there.python
    assert there.python.endswith(" '/a b/python'")


def test_another_host_is_reached_by_ssh_without_asking_for_passwords() -> None:
    spec = gateway_spec(Isolation(ssh="-p 22 me@robot", environment={"A": "b c"}), "/tmp/x y")
    program, option, script = shlex.split(str(spec.python))
    assert (program, option) == ("sh", "-c")
    words = shlex.split(script.replace("trap '' INT; exec ", ""))
    assert words[:7] == ["ssh", "-T", "-o", "BatchMode=yes", "-p", "22", "me@robot"]
    assert "ConnectTimeout=10" in words[7:-2]
    assert words[-2].startswith("env OMP_NUM_THREADS=1 ")
    assert "'A=b c' python3 -u -c " in words[-2]
    assert words[-1] == "2>/tmp/x y"


def test_files_of_ssh_are_relative_to_the_planner_file(tmp_path: Path) -> None:
    isolation = read(tmp_path, "planner: m:C\nssh: -F ../cells/ssh me@robot -p 22 -i ~/key -o 'User=a b'\n").isolation
    assert isolation is not None
    assert isolation.place == "me@robot"
    words = shlex.split(isolation.ssh or "")
    assert Path(words[1]).resolve() == (tmp_path / "cells/ssh").resolve()
    assert words[2:] == ["-p", "22", "-i", str(Path("~/key").expanduser()), "-o", "User=a b", "me@robot"]
