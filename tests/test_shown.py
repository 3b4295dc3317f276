"""Text of strangers in terminals and plots."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from pytest_lpb.commands import EXIT_USAGE, ended
from pytest_lpb.errors import LpbError
from pytest_lpb.report.plots import write_plots
from pytest_lpb.shown import literal, visible
from tests.report.runs import make_run


def test_control_characters_are_written_out() -> None:
    text = "a\x1b[31mred\x1b]0;title\x07\x9b1m\r\x00\u202eb\tc\nd é 中"
    assert visible(text) == r"a\x1b[31mred\x1b]0;title\x07\x9b1m\r\x00\u202eb" + "\tc\nd é 中"
    assert literal("$x$ a") == r"\$x\$ a"


def test_commands_do_not_obey_what_they_print(capsys: pytest.CaptureFixture[str]) -> None:
    def work() -> int:
        print("out \x1b[2J")
        print("err \x1b[2J", file=sys.stderr)
        raise LpbError("scenario \x1b]0;x\x07")

    assert ended("lpb-report", work) == EXIT_USAGE
    told = capsys.readouterr()
    assert told.out == "out \\x1b[2J\n"
    assert told.err == "err \\x1b[2J\nlpb-report: error: scenario \\x1b]0;x\\x07\n"


def test_names_with_dollar_signs_are_no_formulas(tmp_path: Path) -> None:
    data = make_run(["a/$\\frac", "b/$x$_{"], planners=("$\\alpha", "p$q$"), seeds=1, crashed=False)
    data = replace(data, warnings=[], kpis=data.kpis[:3])  # their names are alike in all
    written = write_plots(tmp_path, ["clearance", "success", "kpi", "profile"], data, ("svg",))
    assert written.failures == []
    assert written.paths


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (OSError(24, "Too many open files"), "it: error: [Errno 24] Too many open files"),
        (OSError(28, "No space left on device", "a\x1b"), "it: error: cannot write a\\x1b: No space left on device"),
    ],
)
def test_faults_of_the_system_are_told(error: OSError, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    def work() -> int:
        raise error

    assert ended("it", work) == EXIT_USAGE
    assert capsys.readouterr().err.strip() == told
