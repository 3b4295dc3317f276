"""Starts the processes that do jobs, and ends them."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from threading import Lock
from typing import Any

from pytest_lpb.fairness.job import Answers, Job, read_answers
from pytest_lpb.isolation.process import END_S, Tail, kill_group
from pytest_lpb.run.plan import TrialKey

SERVER = "pytest_lpb.fairness.serve"
SHOWN_LINES = 3


class Processes:
    """Processes that do jobs, several at a time: one per thread that asks."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._running: set[subprocess.Popen[bytes]] = set()
        self._stopped = False

    def have_done(self, job: Job) -> Answers:
        """Have a new process do a job, and wait for it. Where a trial ends it, another one goes on after that trial."""
        by_trial: dict[TrialKey, dict[str, Any]] = {}
        missing: dict[TrialKey, str] = {}
        left = list(job.trials)
        while left and not self._stopped:
            answers, said = self._answers(replace(job, trials=left))
            by_trial |= answers
            left = [key for key in left if key not in answers]
            if left:
                missing[left.pop(0)] = said
        return Answers(by_trial, missing)

    def stop(self) -> None:
        """End all processes, with whatever they have started; no other begins."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                _end(process)

    def _answers(self, job: Job) -> tuple[dict[TrialKey, dict[str, Any]], str]:
        """What one process answers, and the end of what it said."""
        with tempfile.TemporaryDirectory(prefix="lpb-fairness-") as work:
            job_file, answers = Path(work) / "job.json", Path(work) / "answers.jsonl"
            job_file.write_text(job.to_json(), encoding="utf-8")
            tail = Tail()
            with self._started([str(job_file), str(answers), str(os.getpid())], tail) as process:
                # Not for the end of its output: what a planner has started may keep that open.
                code = process.wait()
            tail.join(END_S)
            lines = answers.read_text(encoding="utf-8").splitlines(keepends=True) if answers.is_file() else []
        said = " / ".join(tail.text.splitlines()[-SHOWN_LINES:])
        return read_answers(lines), said or f"the process ended with {code}"

    @contextmanager
    def _started(self, arguments: list[str], tail: Tail) -> Iterator[subprocess.Popen[bytes]]:
        """A process, in a group of its own, which Ctrl-C does not reach; its group is ended with it."""
        with self._lock:
            process = subprocess.Popen(
                [sys.executable, "-m", SERVER, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
            self._running.add(process)
            if self._stopped:
                _end(process)
        assert process.stderr is not None
        tail.read_from(os.dup(process.stderr.fileno()))
        process.stderr.close()
        try:
            yield process
        finally:
            with self._lock:
                self._running.remove(process)
                _end(process)


def _end(process: subprocess.Popen[bytes]) -> None:
    if hasattr(os, "killpg"):
        kill_group(process.pid)
    else:
        process.kill()
