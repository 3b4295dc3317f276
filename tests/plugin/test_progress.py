"""Lines that say how far a run is."""

from __future__ import annotations

import re
from typing import Any

import pytest

from pytest_lpb.plugin import progress
from pytest_lpb.plugin.progress import INTERVAL_LOG_S, INTERVAL_S, Progress

from .projects import UNSOLVED, Project


class _Terminal:
    def __init__(self, *, isatty: bool = True) -> None:
        self.isatty = isatty
        self.lines: list[str] = []

    def ensure_newline(self) -> None:
        pass

    def write_line(self, line: str) -> None:
        self.lines.append(line)


def make(terminal: Any, total: int, monkeypatch: pytest.MonkeyPatch) -> tuple[Progress, list[float]]:
    clock = [0.0]
    monkeypatch.setattr(progress, "monotonic", lambda: clock[0])
    counter = Progress(terminal)
    counter.start(total)
    return counter, clock


def test_text(monkeypatch: pytest.MonkeyPatch) -> None:
    counter, _ = make(_Terminal(), 1000, monkeypatch)
    for index in range(120):
        counter.count(success=index >= 8)
    assert counter.text(24.0) == "lpb: 120 of 1000 trials, 8 unsolved, 2:56 left"
    assert counter.text(0.0) == "lpb: 120 of 1000 trials, 8 unsolved, 0:00 left"
    assert counter.text(1200.0) == "lpb: 120 of 1000 trials, 8 unsolved, 146:40 left"


@pytest.mark.parametrize(("isatty", "interval"), [(True, INTERVAL_S), (False, INTERVAL_LOG_S)])
def test_a_line_now_and_then(monkeypatch: pytest.MonkeyPatch, interval: float, *, isatty: bool) -> None:
    terminal = _Terminal(isatty=isatty)
    counter, clock = make(terminal, 5, monkeypatch)
    for now in (0.5, 0.9, 1.0, 1.5, 9.0):
        clock[0] = now * interval
        counter.count(success=True)
    # None before the interval has passed, none once all trials are done.
    assert len(terminal.lines) == 1
    assert terminal.lines[0].startswith("lpb: 3 of 5 trials, 0 unsolved, ")


@pytest.mark.parametrize("arguments", [(), ("--reruns", "1")])
def test_lines_in_a_run(project: Project, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]) -> None:
    monkeypatch.setattr(progress, "INTERVAL_LOG_S", 0.0)
    project.scenario(content=UNSOLVED)
    result = project.run("--lpb-trials=3", *arguments, "scenarios")
    lines = [line for line in result.stdout.lines if line.startswith("lpb: ")]
    assert len(lines) == 2
    assert re.fullmatch(r"lpb: 1 of 3 trials, 1 unsolved, \d+:\d\d left", lines[0])
    assert lines[1].startswith("lpb: 2 of 3 trials, 2 unsolved, ")
