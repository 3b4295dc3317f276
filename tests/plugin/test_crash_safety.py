"""Whatever ends a run, finished trials stay readable, what is missing is told, and --lpb-resume finishes."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from pytest_lpb.cli import main

from .crashes import PATIENCE_S, CrashProject, check_finished, check_kept, end, expect
from .projects import DRAWN, FAST, LEAN, Project, hashes_of, read_table, text_of

WORKERS = pytest.mark.parametrize("workers", [0, 2], ids=["-n 0", "-n 2"])
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="a promise of Linux")
Hashes = Mapping[tuple[str, str, str], str]
HASHES: dict[tuple[str, str, str], str] = {}


@pytest.fixture
def crash(project: Project) -> CrashProject:
    return CrashProject(project)


@pytest.fixture
def undisturbed(project: Project) -> Hashes:
    """Trajectory hashes of the four trials when nothing happens; the same for all tests."""
    if not HASHES:
        crash = CrashProject(project)
        project.run("--lpb-trials=4", "scenarios", planners="held")
        HASHES.update(hashes_of(crash.run()))
        shutil.rmtree(crash.path / "reports")
        for marker in crash.path.glob("in_*"):
            marker.unlink()
    assert len(set(HASHES.values())) == 4
    return HASHES


def report_of(run: Path, capsys: pytest.CaptureFixture[str], code: int = 0) -> str:
    """What `lpb-report` says of a run."""
    capsys.readouterr()
    assert main([str(run)]) == code
    captured = capsys.readouterr()
    return captured.out + captured.err


def test_killed_worker(crash: CrashProject, undisturbed: Hashes) -> None:
    crash.mark("hold")
    killer = threading.Thread(target=kill_in_trial, args=(crash,))
    killer.start()
    result = crash.project.run_workers("--lpb-trials=4", "scenarios", planners="held", workers=1)
    killer.join()
    assert result.ret == 1
    expect("killed_worker", text_of(result))
    run = crash.run()
    found = hashes_of(run)
    assert found.pop(("point/x", "held", "2")) == ""
    assert found.items() < undisturbed.items()
    crash.unmark("hold")
    # In the process that finishes the run, it might end that too; a worker of its own gives it another chance: who
    # killed it may have meant the machine's memory, not the planner.
    again = crash.project.run(f"--lpb-resume={run}", planners=None)
    again.assert_outcomes(passed=3, failed=1)
    expect("killed_worker", text_of(again))
    crash.resume(workers=1)
    check_finished(run, undisturbed)


def kill_in_trial(crash: CrashProject) -> None:
    """Kill the process that runs the third trial."""
    crash.wait_for(crash.is_there("in_trial2"))
    os.kill(crash.pid("in_trial2"), signal.SIGKILL)


@LINUX
@WORKERS
def test_killed_controller(
    crash: CrashProject, undisturbed: Hashes, capsys: pytest.CaptureFixture[str], workers: int
) -> None:
    crash.mark("hold")
    process = crash.start(workers)
    try:
        crash.wait_for(lambda: crash.is_there("in_trial2")() and crash.recorded(0, 1)(), process)
        run = crash.run()
        # Nobody else can run its trials meanwhile.
        refused = crash.project.run(f"--lpb-resume={run}", planners=None)
        assert refused.ret == 4
        expect("two_that_finish_one_run", text_of(refused))
        in_trial = crash.pid("in_trial2")
        assert (in_trial != process.pid) == bool(workers)
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        wait_until_ended(in_trial)
    finally:
        end(process)
    assert "Traceback" not in crash.output()
    leave_unfinished_files(run)
    check_kept(run, 2)
    said = report_of(run, capsys)
    expect("killed_controller", said)
    assert "2 of 4 trials were run; " in said
    assert "2 of 4 trials were run; " in (run / "report.html").read_text()
    assert [row["seeds"] for row in read_table(run / "missing.csv")] == ["2-3"]
    crash.unmark("hold")
    crash.resume()
    check_finished(run, undisturbed)
    assert sorted(path.name for path in run.parent.iterdir()) == [".gitignore", run.name, "latest"]
    assert (run.parent / "latest").is_symlink()


def wait_until_ended(pid: int) -> None:
    """A worker whose controller is gone ends at once: its planner would go on for ever."""
    deadline = time.monotonic() + 5.0
    while not has_ended(pid):
        assert time.monotonic() < deadline, "the worker goes on"
        time.sleep(0.01)


def has_ended(pid: int) -> bool:
    try:
        status = Path(f"/proc/{pid}/stat").read_text()
    except FileNotFoundError:
        return True
    return status.rpartition(")")[2].split()[0] == "Z"


def leave_unfinished_files(run: Path) -> None:
    """What a process that is killed while it writes leaves behind."""
    (run / "trials/point/x/held/.seed2.parquet-0123abcd.part").write_bytes(b"PAR1")
    (run / "assets/.work.part/0").mkdir(parents=True)
    (run.parent / f".latest-{run.name}-0123abcd").symlink_to(run.name)


def test_interrupt_in_collection(crash: CrashProject) -> None:
    crash.mark("hold_collection")
    interrupt(crash, crash.start(0), "in_collection", signal.SIGTERM)
    expect("interrupt_in_collection", crash.output())
    assert not (crash.path / "reports").exists()


def test_interrupt_at_the_end(crash: CrashProject, undisturbed: Hashes) -> None:
    crash.mark("hold_kpi")
    process = crash.start(0, "--lpb-kpis=held_kpi")
    interrupt(crash, process, "in_kpi", signal.SIGINT)
    expect("interrupt_at_the_end", crash.output())
    run = crash.run()
    check_kept(run, 4)
    assert not (run / "trials.csv").exists()
    crash.unmark("hold_kpi")
    crash.resume()
    check_finished(run, undisturbed)


def interrupt(crash: CrashProject, process: subprocess.Popen[bytes], marker: str, number: signal.Signals) -> None:
    """Interrupt a run once a marker is there; it ends by itself, and says that it was interrupted."""
    try:
        crash.wait_for(crash.is_there(marker), process)
        # A terminal sends Ctrl-C to all processes of the run; `kill` and schedulers address the first.
        (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
        assert process.wait(PATIENCE_S) == 2, crash.output()
    finally:
        end(process)


@WORKERS
def test_full_disk(crash: CrashProject, undisturbed: Hashes, workers: int) -> None:
    crash.mark("full")
    arguments = ("--lpb-trials=4", "--lpb-assert=none", "scenarios")
    run_it = crash.project.run_workers if workers else crash.project.run
    result = run_it(*arguments, planners="held")
    assert result.ret == 2
    expect("full_disk", text_of(result))
    run = crash.run()
    check_kept(run, 3 if workers and crash.recorded(3)() else 2)
    assert "seed2.parquet" not in str(list(run.rglob("*.part")))
    crash.unmark("full")
    crash.resume()
    check_finished(run, undisturbed)


def test_full_disk_for_temporary_files(crash: CrashProject, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("pytest_lpb.plugin.items.run_trial", full)
    result = crash.project.run("--lpb-trials=4", "scenarios", planners="held")
    assert result.ret == 2
    result.assert_outcomes(failed=1)
    assert f"cannot write a file in {tempfile.gettempdir()}: No space left" in text_of(result)
    expect("full_disk", text_of(result))


# In a mount namespace of its own: nothing is left mounted, whatever happens, and users may do so too.
OWN_MOUNTS = ["unshare", "--mount", *([] if os.getuid() == 0 else ["--user", "--map-root-user"])]
FULL_DISK = """
import os, subprocess, sys
import pytest

def mount(*arguments):
    subprocess.run(["mount", *arguments, sys.argv[1]], check=True)

def run(*arguments):
    print("EXIT", int(pytest.main([*sys.argv[2:], *arguments])), flush=True)
    sys.stderr.flush()

mount("-t", "tmpfs", "-o", "size=4k", "tmpfs")
begin = (f"--lpb-reports={sys.argv[1]}/r", "--lpb-planners=held", "--lpb-trials=4", "--lpb-assert=none", "scenarios")
run(*begin)
print("LEFT", os.listdir(f"{sys.argv[1]}/r"), flush=True)
mount("-o", "remount,size=48k")
run(*begin)
mount("-o", "remount,ro")
run(f"--lpb-resume={sys.argv[1]}/r/latest")
mount("-o", "remount,rw,size=10m")
run(f"--lpb-resume={sys.argv[1]}/r/latest")
subprocess.run(["cp", "-a", f"{sys.argv[1]}/r", "kept"], check=True)
"""


def has_own_mounts() -> bool:
    """Whether this user may mount something for itself."""
    if shutil.which("unshare") is None or sys.platform != "linux":
        return False
    command = [*OWN_MOUNTS, "mount", "-t", "tmpfs", "tmpfs", "/tmp"]
    return subprocess.run(command, check=False, capture_output=True).returncode == 0


@pytest.mark.skipif(not has_own_mounts(), reason="this user cannot mount a small file system (unshare --mount)")
def test_full_disk_at_the_start(crash: CrashProject, undisturbed: Hashes) -> None:
    """A file system that is full, then too small, then only to be read, then large enough."""
    (crash.path / "disk").mkdir()
    result = subprocess.run(
        [*OWN_MOUNTS, sys.executable, "-c", FULL_DISK, str(crash.path / "disk"), *LEAN, FAST],
        cwd=crash.path,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    at_the_start, full, read_only, finished, _ = result.stdout.split("EXIT ")
    expect("full_disk_at_the_start", at_the_start)
    assert full.startswith("4\nLEFT []\n")
    expect("full_disk", full)
    assert read_only.startswith("2\n")
    expect("read_only_run", read_only)
    assert finished.startswith("4\n")
    check_finished(next((crash.path / "kept").glob("2*")), undisturbed)


def test_file_too_large(crash: CrashProject, undisturbed: Hashes) -> None:
    """A limit of the operating system for one file: trials whose files are within it are recorded."""
    crash.project.scenario("scenarios/point/long.yaml", DRAWN.replace("duration: 0.5", "duration: 5, end_at: []"))
    crash.mark("small_files")
    process = crash.start(0)
    try:
        assert process.wait(PATIENCE_S) == 1, crash.output()
    finally:
        end(process)
    expect("file_too_large", crash.output())
    run = crash.run()
    assert hashes_of(run) == undisturbed
    assert [row["scenario"] for row in read_table(run / "missing.csv")] == ["point/long"]
    check_kept(run, 4)


@LINUX
@WORKERS
def test_read_only_reports(crash: CrashProject, monkeypatch: pytest.MonkeyPatch, workers: int) -> None:
    in_the_way = crash.project.write("file", "")
    locked = crash.path / "locked"
    locked.mkdir(mode=0o500)
    places = ["/proc/reports", in_the_way, in_the_way / "reports", *([locked] if os.getuid() else [])]
    for place in places:
        result = crash.project.run("-n", str(workers), f"--lpb-reports={place}", "scenarios", planners="held")
        assert result.ret == 4
        expect("read_only_reports", text_of(result))
        assert str(place) in text_of(result)
    assert not list(crash.path.glob("in_*"))
    assert in_the_way.read_text() == ""


def test_damaged_trial(crash: CrashProject, undisturbed: Hashes, capsys: pytest.CaptureFixture[str]) -> None:
    crash.project.run("--lpb-trials=4", "scenarios", planners="held")
    run = crash.run()
    damaged = run / "trials/point/x/held/seed2.parquet"
    content = damaged.read_bytes()
    for length in (0, 4, len(content) // 2, len(content) - 1):
        damaged.write_bytes(content[:length])
        said = report_of(run, capsys, code=1)
        expect("damaged_trial", said)
        assert str(damaged) in said
        assert "3 of 4 trials were run; " in said
        left = hashes_of(run)
        assert len(left) == 3
        assert left.items() < undisturbed.items()
    result = crash.project.run(f"--lpb-resume={run}", planners=None)
    result.assert_outcomes(passed=3, failed=1)
    expect("damaged_trial", text_of(result))
    damaged.unlink()
    crash.resume()
    check_finished(run, undisturbed)


def test_two_runs_at_once(crash: CrashProject, undisturbed: Hashes) -> None:
    latest = crash.path / "reports/latest"
    processes = [crash.start(0), crash.start(0)]
    try:
        while any(process.poll() is None for process in processes):
            assert not latest.is_symlink() or (latest / "run.json").is_file()
            time.sleep(0.002)
        assert [process.returncode for process in processes] == [0, 0]
    finally:
        for process in processes:
            end(process)
    expect("two_runs_at_once", crash.output())
    first, second = crash.project.runs()
    for run in (first, second):
        check_finished(run, undisturbed)
    assert latest.resolve() in (first, second)
    assert sorted(path.name for path in latest.parent.iterdir()) == sorted(
        [".gitignore", first.name, second.name, "latest"]
    )
