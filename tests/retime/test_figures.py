"""Figures of calls timed again, by hand."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import RecordingError
from pytest_lpb.retime.figures import PassTimes, RetimedRow, against, noise_floor, row_of, spread
from pytest_lpb.retime.result import Retimed, own_part, read_retimed
from pytest_lpb.retime.text import retimed_table


def row(
    planner: str = "a", scenario: str = "s", calls: tuple[tuple[float, ...], ...] = ((1.0, 2.0, 3.0),) * 2
) -> RetimedRow:
    """Two trials a pass; the period is 2.5 ms."""
    passes = [PassTimes(times, (4.0, 2.0), 1.0) for times in calls]
    return row_of(scenario, planner, passes, [9.0, 1.0], 2.5, 0)


def test_figures_of_two_passes() -> None:
    figures = row(calls=((1.0, 2.0, 3.0, 4.0), (2.0, 3.0, 4.0, 5.0)))
    assert (figures.trials, figures.passes, figures.calls) == (2, 2, 8)
    assert figures.p50_ms == 3.0
    # `linear`: ranks 0.95 * 7 = 6.65 and 0.99 * 7 = 6.93 of 1 2 2 3 3 4 4 5.
    assert figures.p95_ms == pytest.approx(4.65)
    assert figures.p99_ms == pytest.approx(4.93)
    assert (figures.max_ms, figures.mean_ms) == (5.0, 3.0)
    # First calls are apart: 4, 2, 4, 2, and the cold ones 9 and 1.
    assert (figures.first_call_ms, figures.first_call_max_ms) == (3.0, 9.0)
    # Over 2.5 ms: 3, 4, 3, 4, 5 and two first calls.
    assert (figures.deadline_misses, figures.deadline_calls) == (7, 12)
    # The passes' medians are 2.5 and 3.5; their p95 3.85 and 4.85.
    assert figures.noise_p50 == pytest.approx(0.4)
    assert figures.noise_p95 == pytest.approx(4.85 / 3.85 - 1.0)


def test_the_spread_is_that_of_the_two_that_differ_most() -> None:
    assert spread([1.1, 1.0, 1.3, 1.2]) == pytest.approx(0.3)
    assert math.isnan(spread([1.0]))
    assert math.isnan(spread([0.0, 1.0]))


def test_a_difference_below_the_noise_floor_is_noise() -> None:
    fast, near, far, slow = (
        replace(row(name), p50_ms=p50) for name, p50 in zip("abcd", (1.0, 1.09, 1.5, 4.0), strict=True)
    )
    rows = [
        replace(each, noise_p50=noise)
        for each, noise in zip((fast, near, far, slow), (0.1, 0.0, 0.02, 0.0), strict=True)
    ]
    assert noise_floor(rows, "p50") == 0.1
    assert [against(each, rows) for each in rows] == ["fastest", "noise (+9.0 %)", "+50 %", "4 x"]


def test_a_few_disturbed_rows_are_not_the_floor_of_many() -> None:
    rows = [replace(row("a", f"s{k}"), noise_p50=0.01 * k) for k in range(1, 41)]
    assert noise_floor(rows, "p50") == pytest.approx(0.39)  # rank 0.95 * 39 = 37.05, the next one up
    assert noise_floor(rows[:20], "p50") == pytest.approx(0.20)
    # Of a row that was disturbed itself, more is noise.
    fast, slow = replace(row("a"), p50_ms=1.0, noise_p50=0.9), replace(row("b"), p50_ms=1.5, noise_p50=0.0)
    assert against(slow, [fast, slow, *rows]) == "noise (+50.0 %)"
    assert against(slow, [replace(fast, noise_p50=0.0), slow, *rows]) == "+50 %"


def test_each_scenario_has_a_fastest_of_its_own() -> None:
    rows = [row("a", "s1"), replace(row("b", "s1"), p50_ms=1.0), row("a", "s2")]
    assert [against(each, rows) for each in rows] == ["2 x", "fastest", ""]


def test_what_waited_for_a_processor_is_marked() -> None:
    waited = replace(row(), wall_per_cpu=1.3)
    assert waited.contended
    assert not row().contended
    lines = list(retimed_table(Retimed([waited])))
    assert lines[1].split()[:3] == ["s", "a", "†"]
    assert lines[-1].startswith("† these calls had to wait")


def test_the_terminal_says_count_and_floor() -> None:
    lines = list(retimed_table(Retimed([row(calls=((1.0, 2.0, 3.0, 4.0), (2.0, 3.0, 4.0, 5.0)))])))
    assert lines[1].split()[:9] == ["s", "a", "2", "8", "3", "4.65", "4.93", "5", "3"]
    assert "7 of 12 (> 2.5 ms)" in lines[1]
    assert lines[2] == "calls: those recorded, each made in 2 passes; the first call of a trial is apart (its median)"
    assert lines[3].startswith("A/A noise floor of this machine: 40 % of p50, 26 % of p95")


def written(path: Path, rows: list[RetimedRow]) -> dict[str, Any]:
    content = {
        "benchmarks": [{"extra_info": each.to_dict()} for each in rows],
        "datetime": "2026-11-22T02:49:21+00:00",
        "machine_info": {"cpu": {"brand_raw": "a processor"}},
        "pytest_lpb": own_part(rows, ["one warning"]),
    }
    path.write_text(json.dumps(content, allow_nan=False), encoding="utf-8")
    return content


def test_what_is_read_is_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "retimed.json"
    rows = [row("a"), row("b"), replace(row("a", "s2"), noise_p50=0.5)]
    content = written(path, rows)
    assert content["pytest_lpb"]["noise_floor_p50"] == 0.5
    retimed = read_retimed(path)
    assert retimed is not None
    assert list(retimed.rows) == rows
    assert (retimed.machine, retimed.warnings) == ("a processor", ["one warning"])
    assert [each.planner for each in retimed.selected({("s", "b")}).rows] == ["b"]


def test_an_unknown_noise_is_null(tmp_path: Path) -> None:
    path = tmp_path / "retimed.json"
    written(path, [row(calls=((1.0, 2.0),))])
    assert '"noise_floor_p50": null' in path.read_text(encoding="utf-8")
    retimed = read_retimed(path)
    assert retimed is not None
    assert math.isnan(retimed.rows[0].noise_p50)


@pytest.mark.parametrize("content", ["{", "[]", '{"benchmarks": [{"extra_info": {}}]}', '{"benchmarks": null}'])
def test_another_file_is_an_error(tmp_path: Path, content: str) -> None:
    path = tmp_path / "retimed.json"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(RecordingError, match="measure again with --retime"):
        read_retimed(path)
    assert read_retimed(tmp_path / "no.json") is None
