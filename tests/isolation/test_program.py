"""Programs that speak the protocol: the example in C, and some that do not."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from threading import Thread
from typing import IO, Any

import numpy as np
import pytest

from pytest_lpb import Planner, Preview
from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.far.stream import Stream
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import read_planner
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import circle, position_goal, problem_entry

from .test_faults import has_ended

EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "planner_in_c"
ANSWERS = """\
import json, sys, time
STARTED, READY = '{"type":"started"}', '{"type":"ready"}'
for kind, answer in ANSWERS:
    line = sys.stdin.buffer.readline()
    header = json.loads(line)
    sys.stdin.buffer.read(header["bytes"])
    assert header["type"] == kind, header
    sys.stdout.write(answer)
    sys.stdout.flush()
print("no more to say", file=sys.stderr)
"""
DEFAULT = [("start", '{"type":"started"}\n'), ("setup", '{"type":"ready"}\n'), ("observation", "")]


def run(configuration: PlannerConfiguration, **problem: Any) -> Trajectory:
    entry = problem_entry(**{"goal": [position_goal([4.0, 0.2])], **problem})
    return run_trial(TrialSpecification(problem=entry, planner=configuration, scenario="family"))


def answering(folder: Path, answers: list[tuple[str, str]], **limits: Any) -> Trajectory:
    """A trial of a program that gives certain answers."""
    script = folder / "program.py"
    script.write_text(f"ANSWERS = {answers!r}\n{ANSWERS}")
    isolation = Isolation(command=(sys.executable, str(script)), isolate=True, **limits)
    return run(PlannerConfiguration("it", "", isolation=isolation))


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example, compiled."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler (cc, gcc, clang)")
    folder = tmp_path_factory.mktemp("c")
    (folder / "planners").mkdir()
    shutil.copy(EXAMPLE / "planners" / "towards.yaml", folder / "planners")
    command = [
        compiler,
        "-O2",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-o",
        str(folder / "towards"),
        str(EXAMPLE / "towards.c"),
    ]
    subprocess.run(command, check=True)
    return folder / "planners" / "towards.yaml"


@pytest.mark.parametrize("obstacles", [[], [circle(0.0, 3.0, 0.5)]])
def test_the_example_in_c_does_what_pd_does(example: Path, obstacles: list[Any]) -> None:
    """Observations of different layouts; compilers may contract a*b + c, so not to the last bit."""
    duration = 8.0
    ours = run(PlannerConfiguration("pd", "pd"), obstacles=obstacles, duration=duration)
    theirs = run(read_planner(example, "towards"), obstacles=obstacles, duration=duration)
    assert theirs.outcome == ours.outcome == "success"
    np.testing.assert_allclose(theirs.action[:-1], ours.action[:-1], atol=1e-9)
    assert np.nanmax(theirs.solver_wall_ms) < 10.0
    assert np.nanmin(theirs.columns["planner_round_trip_ms"]) > 0.0


class Ahead(Planner):
    """The law of the example in C."""

    preview = Preview(steps=5, step_s=0.1)

    def compute_action(self, observation: Any) -> Any:
        return observation["goal_reach_preview"][-1] - observation["q"] - 2.0 * observation["u"]


@pytest.mark.parametrize("prediction", ["constant_velocity", "exact", "none"])
def test_previews_are_those_of_a_class(example: Path, prediction: str) -> None:
    """Of a goal that moves on a circle, beside an obstacle that moves."""
    goal, disc = (
        {key: value for key, value in entry.items() if key not in ("target", "position")}
        for entry in (position_goal([0.0, 0.0]), circle(5.0, 5.0, 0.2))
    )
    problem: dict[str, Any] = {
        "goal": [{**goal, "trajectory": ["2*cos(t)", "2*sin(t)"]}],
        "obstacles": [{**disc, "trajectory": ["5 + 0.1*t", "5"]}],
        "prediction": prediction,
        "duration": 2.0,
    }
    ours = run(PlannerConfiguration("it", f"{__name__}:Ahead"), **problem)
    theirs = run(read_planner(example, "towards"), **problem)
    assert theirs.outcome == ours.outcome == "timeout", theirs.metadata["message"]
    np.testing.assert_allclose(theirs.action[:-1], ours.action[:-1], atol=1e-9)
    without = read_planner(example, "towards")
    assert without.isolation is not None
    blind = replace(without, isolation=replace(without.isolation, preview={}))
    assert blind.parameters_hash != without.parameters_hash
    assert (run(blind, **problem).action[0] == ours.action[0]).all() == (prediction == "none")


def test_its_parameters_reach_it(example: Path) -> None:
    configuration = read_planner(example, "towards")
    strong = PlannerConfiguration("it", "", parameters={"p": 3.0}, isolation=configuration.isolation)
    assert run(strong).action[0].tolist() == [12.0, pytest.approx(0.6)]


def test_arguments_that_are_files_of_the_working_directory_are_its_source(tmp_path: Path) -> None:
    isolation = Isolation(command=(sys.executable, "program.py"), working_dir=str(tmp_path), isolate=True)
    hashes = set()
    for content in ("1\n", "2\n"):
        (tmp_path / "program.py").write_text(content)
        hashes.add(PlannerConfiguration("it", "", isolation=isolation).source_hash)
    assert len(hashes) == 2


def test_it_says_what_it_cannot_do(example: Path) -> None:
    arm = {"model": "planar_arm", "name": "planar_arm_2", "base": "fixed", "links": [1.0, 1.0], "body_radius": 0.05}
    trajectory = run(
        read_planner(example, "towards"),
        robot=arm,
        goal=[
            {"name": "fold", "type": "joint", "joints": ["joint1"], "target": [1.0], "primary": True, "tolerance": 0.1}
        ],
    )
    assert trajectory.metadata["message"] == (
        "planner error at t = 0 s: towards moves a point or base to a position, nothing else"
    )


def test_a_program_that_is_not_there() -> None:
    with pytest.raises(ConfigurationError, match="command: /no/such is no program that can be run"):
        PlannerConfiguration("it", "", isolation=Isolation(command=("/no/such",), isolate=True)).check()


@pytest.mark.parametrize(
    ("answers", "message"),
    [
        ([], "the planner's process ended with exit code 0; its last words: no more to say"),
        ([("start", "hello\n")], "wrote what is no message: Expecting value"),
        ([("start", "[1]\n")], "wrote what is no message: a header is a JSON mapping"),
        ([("start", '{"bytes":-1}\n')], "wrote what is no message: `bytes` is -1; allowed are 0 to 100000000"),
        ([("start", "{}\n")], "answered with a header without `type`"),
        ([*DEFAULT, ("call", '{"type":"ready"}\n')], "answered a call with 'ready'; `action` is expected"),
        ([*DEFAULT, ("call", '{"type":"action","bytes":3}\nabc')], "buffer size must be a multiple of element size"),
        ([*DEFAULT, ("call", '{"type":"action","shape":[3],"bytes":8}\nabcdefgh')], "wrote an action of shape [3]"),
        ([*DEFAULT, ("call", '{"type":"action","bytes":8}\nabcdefgh')], "an array of shape (1,); expected (2,)"),
        ([*DEFAULT, ("call", '{"type":"error","message":"no idea"}\n')], "planner error at t = 0 s: no idea"),
        ([*DEFAULT, ("call", '{"type":"infeasible","message":"shut in"}\n')], "infeasible at t = 0 s: shut in"),
        ([*DEFAULT, ("call", '{"type":"action","diagnostics":3,"bytes":16}\n' + "a" * 16)], "diagnostics"),
        ([*DEFAULT, ("call", '{"type":"action","wall_ns":"x","bytes":16}\n' + "a" * 16)], "wall_ns"),
        ([*DEFAULT, ("call", '{"type":"action","wall_ns":1%s,"bytes":16}\n' % ("0" * 400) + "a" * 16)], "wall_ns"),
        ([*DEFAULT, ("call", '{"type":"error","message":5,"details":[1]}\n')], "planner error at t = 0 s: 5"),
        ([*DEFAULT, ("call", "[" * 100_000 + "\n")], "wrote what is no message: its header goes too deep"),
        ([*DEFAULT[:1], ("setup", '{"type":"action"}\n')], "answered a setup with 'action'; `ready` is expected"),
    ],
)
def test_wrong_answers(tmp_path: Path, answers: list[tuple[str, str]], message: str) -> None:
    trajectory = answering(tmp_path, answers)
    assert trajectory.outcome in ("planner_error", "infeasible")
    assert message in trajectory.metadata["message"]


ACTION = '{"type":"action","bytes":16}\n' + "\0" * 16


@pytest.mark.parametrize(
    ("answers", "rows"),
    [
        ([*DEFAULT, ("call", ACTION * 2), ("call", ACTION)], 2),  # its first action counts; what comes next is in doubt
        ([*DEFAULT[:1], ("setup", '{"type":"ready"}\n' * 2), ("observation", "")], 1),
    ],
)
def test_answers_that_nobody_asked_for(tmp_path: Path, answers: list[tuple[str, str]], rows: int) -> None:
    """Otherwise each of them would be taken for the answer to the next call."""
    trajectory = answering(tmp_path, answers)
    assert trajectory.outcome == "planner_error"
    assert "it wrote more than one answer, or before it was asked" in trajectory.metadata["message"]
    assert len(trajectory.t) == rows


@pytest.mark.parametrize("wrapped", [False, True], ids=["itself", "its child"])
def test_it_ends_with_whoever_started_it(tmp_path: Path, wrapped: bool) -> None:
    """Even killed, and even while the program does not read; a shell's script may have started it."""
    file, script = tmp_path / "pid", tmp_path / "program.py"
    script.write_text(f"import os, time\nopen({str(file)!r}, 'w').write(f'{{os.getpid()}} ')\ntime.sleep(60.0)\n")
    command: tuple[str, ...] = (sys.executable, str(script))
    if wrapped:
        command = ("sh", "-c", f"{sys.executable} {script}; echo done")
    isolation = Isolation(command=command, isolate=True)
    program = f"from pytest_lpb.isolation.session import *\nSession({isolation!r}, '', None).describe([])\n"
    with subprocess.Popen([sys.executable, "-c", f"from pytest_lpb.isolation.settings import *\n{program}"]) as process:
        until = time.monotonic() + 20.0
        while not (file.is_file() and file.read_text().endswith(" ")):
            assert time.monotonic() < until
            time.sleep(0.02)
        process.kill()
    assert has_ended(int(file.read_text()))


def test_how_it_ends_is_told(tmp_path: Path) -> None:
    script = tmp_path / "program.py"
    script.write_text("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    isolation = Isolation(command=(sys.executable, str(script)), isolate=True)
    trajectory = run(PlannerConfiguration("it", "", isolation=isolation))
    assert "the planner's process was ended by SIGSEGV (signal 11)" in trajectory.metadata["message"]


def test_a_program_of_another_kind_of_machine(tmp_path: Path) -> None:
    program = tmp_path / "program"
    program.write_bytes(b"\x7fELF" + bytes(100))
    program.chmod(0o755)
    trajectory = run(PlannerConfiguration("it", "", isolation=Isolation(command=(str(program),), isolate=True)))
    message = f"ended with exit code 126; its last words: cannot run {program}: [Errno 8] Exec format error"
    assert message in trajectory.metadata["message"]


def test_last_words_are_told_once(tmp_path: Path) -> None:
    isolation = Isolation(command=(sys.executable, str(tmp_path / "nothing.py")), isolate=True)
    trajectory = run(PlannerConfiguration("it", "", isolation=isolation))
    assert "ended with exit code 2; its last words: " in trajectory.metadata["message"]
    assert "nothing.py" in trajectory.metadata["message"]
    assert trajectory.metadata["details"] == ""


def test_a_program_that_says_nothing(tmp_path: Path) -> None:
    script = tmp_path / "silent.py"
    script.write_text("import time\ntime.sleep(60)\n")
    isolation = Isolation(command=(sys.executable, str(script)), isolate=True, setup_deadline_s=0.5)
    trajectory = run(PlannerConfiguration("it", "", isolation=isolation))
    assert trajectory.outcome == "deadline"


@pytest.mark.parametrize("head", [b"", b'{"type":"ready","bytes":100000000}\n'], ids=["a line", "a payload"])
def test_a_program_that_never_ends_its_answer(tmp_path: Path, head: bytes) -> None:
    """Bytes that keep coming are no answer: the limit holds all the same."""
    script = tmp_path / "flood.py"
    flood = "while True:\n    sys.stdout.buffer.write(b'x' * 4096)\n    time.sleep(0.001)\n"
    script.write_text(f"import sys, time\nsys.stdout.buffer.write({head!r})\n{flood}")
    isolation = Isolation(command=(sys.executable, str(script)), isolate=True, setup_deadline_s=0.5)
    started = time.monotonic()
    assert run(PlannerConfiguration("it", "", isolation=isolation)).outcome == "deadline"
    assert time.monotonic() - started < 5.0


def test_long_answers_are_read_in_time_that_their_length_takes() -> None:
    """Not in its square: 100 MB without an end are refused within a second or so."""
    source, sink = os.pipe()
    with open(sink, "wb") as end:  # noqa: PTH123 - a descriptor
        writer = Thread(target=_written, args=(end, b"x" * 10**6, 101), daemon=True)
        writer.start()
        started = time.process_time()
        with pytest.raises(ValueError, match="it has more than 100000000 bytes"):
            Stream(source, source).receive(60.0)
        assert time.process_time() - started < 5.0
        os.close(source)
        writer.join(10.0)


def _written(end: IO[bytes], chunk: bytes, times: int) -> None:
    with suppress(BrokenPipeError):
        for _ in range(times):
            end.write(chunk)
            end.flush()


def test_memory_of_a_program(tmp_path: Path) -> None:
    script = tmp_path / "large.py"
    script.write_text("import sys\nsys.stdin.readline()\nlarge = b'x' * 10**9\n")
    isolation = Isolation(command=(sys.executable, str(script)), isolate=True, memory_mb=300)
    trajectory = run(PlannerConfiguration("it", "", isolation=isolation))
    assert trajectory.outcome == "planner_error"
    assert "ended with exit code 1 (memory_mb: 300); its last words: MemoryError" in trajectory.metadata["message"]
