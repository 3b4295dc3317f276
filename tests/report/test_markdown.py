"""Markdown for pull requests: what it says, what it escapes, what it leaves out."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.markdown import MAX_BYTES, markdown_summary
from pytest_lpb.run.gate import Gate
from pytest_lpb.run.margins import parse_margins
from pytest_lpb.run.tables import aggregates_table, comparisons_table, summary_table
from tests.run.test_gate import MACHINE, Old, failed, trials
from tests.run.trial_frames import KPIS, TIME


def report_data(rows: pd.DataFrame) -> ReportData:
    return ReportData(
        trials=rows,
        summary=summary_table(rows, KPIS),
        comparisons=comparisons_table(rows, KPIS),
        aggregates=aggregates_table(rows, KPIS),
        kpis=[],
        run_info={},
        trajectory_of=lambda _: None,  # type: ignore[arg-type, return-value]
    )


def all_kpis(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.assign(**{kpi.name: 1.0 for kpi in KPIS if kpi.name not in rows})


def tables(text: str) -> list[list[str]]:
    """Rows of each table; every one must have as many cells as its head."""
    found: list[list[str]] = []
    for block in re.findall(r"(?:^\|.*\|\n)+", text, re.MULTILINE):
        rows = block.splitlines()
        cells = [len(re.findall(r"(?<!\\)\|", row)) for row in rows]
        assert len(set(cells)) == 1, block
        assert set(rows[1]) == {"|", "-"}
        found.append(rows)
    return found


def summary(old: pd.DataFrame, new: pd.DataFrame, *margins: str) -> str:
    gate = Gate(Old(old), parse_margins(margins, KPIS, "--x")).judge(new, MACHINE)
    return markdown_summary(dataclasses.replace(report_data(all_kpis(new)), gate=gate))


def test_a_closed_gate() -> None:
    text = summary(trials(), trials(40, failed(range(10))), "success:2%", "clearance_min_m:0.01m")
    planners, verdicts, changes, failures = tables(text)
    assert len(planners) == 3
    assert planners[2].startswith("| a | 30/40 | 40 | 75 % |")
    assert "**GATE CLOSED: 1 verdict regressed** (baseline: old)" in text
    assert verdicts[2].startswith("| a | success | 40 | 100 % | 75 % | 25 pp | ")
    assert verdicts[2].endswith("| 2 pp | ❌ regressed |")
    assert (
        verdicts[3] == "| a | clearance\\_min\\_m | 40 | 0.2 m | 0.2 m | 0 m | 0 to 0 m | 0.01 m | ✅ same or better |"
    )
    assert changes[2] == "| s | 0 | success | timeout |"
    assert "pytest scenarios/s.yaml::a::seed0" in text
    assert len(failures) == 12


def test_an_inconclusive_gate_says_why() -> None:
    text = summary(trials(10), trials(12), "success:2%")
    assert "❔ inconclusive |" in text
    assert "- a, success: 10 common problems; 20 are needed; at least 10 further seeds per scenario would" in text
    assert "- not compared: a: not in the baseline: s seed10, s seed11" in text


def test_clear_comparisons_only() -> None:
    both = pd.concat([trials(), trials(time_to_goal_s=9.0).assign(planner="b")])
    text = markdown_summary(report_data(all_kpis(both)))
    assert "<summary>1 clear difference between planners</summary>" in text
    assert "| b is worse than a | time\\_to\\_goal\\_s | 40 | 5 | 9 | 4 | 4 |" in text
    assert "clearance" not in text
    assert "without success" not in text


def test_names_and_messages_are_only_text() -> None:
    rows = trials(3, failed([1]), message="a | b <script> `x` [y](z)\n* w", node_id="x")
    text = markdown_summary(report_data(all_kpis(rows)))
    (row,) = (line for line in text.splitlines() if "timeout" in line)
    assert row == "| x | timeout | a \\| b &lt;script> \\`x\\` \\[y\\](z) \\* w |"
    tables(text)


def many(problems: int, names: Sequence[str]) -> pd.DataFrame:
    rows = trials(problems, failed(range(problems)), message="word " * 400)
    return all_kpis(pd.concat([rows.assign(planner=name) for name in names]))


def test_it_fits_a_comment_whatever_the_run() -> None:
    text = markdown_summary(report_data(many(60, [f"{'p' * 90}{index}" for index in range(12)])))
    assert len(text.encode()) < MAX_BYTES
    assert "700 more are in trials.csv" in text
    assert max(map(len, text.splitlines())) < 500
    data = report_data(many(2, ["a"]))
    long = dataclasses.replace(data, summary=pd.concat([data.summary] * 2000))
    text = markdown_summary(long)
    assert len(text.encode()) < MAX_BYTES
    assert "More would not fit; the report has it all." in text


def test_a_run_without_trials() -> None:
    text = markdown_summary(report_data(all_kpis(trials(1)).iloc[:0]))
    assert text.startswith("### Local planner benchmark: 0 planners, 0 scenarios, 0 trials\n")
    assert TIME.name not in text
