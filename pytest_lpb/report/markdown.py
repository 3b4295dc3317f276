"""A summary of a run in Markdown that fits the comment of a pull request."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd

from pytest_lpb.names import count
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.gate_text import (
    HEADS,
    change_texts,
    conclusion,
    doubt,
    left_out_lines,
    notes,
    subject,
    verdict_cells,
)
from pytest_lpb.report.text import planner_notes, planner_rows
from pytest_lpb.report.titles import compared_name, timing_mark
from pytest_lpb.run.gate import INCONCLUSIVE, REGRESSED, GateResult, GateVerdict
from pytest_lpb.run.paired import SUCCESS
from pytest_lpb.run.title import title_of

MAX_BYTES = 60_000  # GitHub takes comments of 65,536 characters
MAX_CHANGES = 10
MAX_COMPARISONS = 40
MAX_FAILURES = 20
MAX_MESSAGE = 160  # characters of a failed trial's message
SIGNS = {REGRESSED: "❌", INCONCLUSIVE: "❔"}


def markdown_summary(data: ReportData) -> str:
    """Planners, the gate's verdicts, clear comparisons and failed trials; what does not fit is left out, and told."""
    parts = [_title(data), _planners(data)]
    if data.gate is not None:
        parts.append(_gate(data.gate))
    parts += [_comparisons(data), _failures(data)]
    text = ""
    for part in filter(None, ("\n".join(lines) for lines in parts)):
        if len((text + part).encode()) > MAX_BYTES:
            return text + "More would not fit; the report has it all.\n"
        text += f"{part}\n\n"
    return text.rstrip("\n") + "\n"


def _title(data: ReportData) -> Iterator[str]:
    counts = (
        count(data.trials["planner"].nunique(), "planner"),
        count(data.trials["scenario"].nunique(), "scenario"),
        count(len(data.trials), "trial"),
    )
    title = title_of(data.run_info)
    if title:
        yield from (f"### {_cell(title)}", "")
    yield f"{'' if title else '### '}Local planner benchmark: {', '.join(counts)}"


def _planners(data: ReportData) -> Iterator[str]:
    yield from _table(planner_rows(data))
    yield from ("", *planner_notes(data, _clear(data)["kpi"]))


def _gate(gate: GateResult) -> Iterator[str]:
    yield f"**{conclusion(gate)}** (baseline: {_cell(gate.baseline)})"
    yield ""
    rows = [[*cells[:-1], f"{SIGNS.get(cells[-1], '✅')} {cells[-1]}"] for cells in map(verdict_cells, gate.verdicts)]
    yield from _table([HEADS, *rows])
    yield ""
    doubts = [f"{subject(entry)}: {doubt(entry)}" for entry in gate.verdicts if entry.verdict == INCONCLUSIVE]
    yield from (f"- {_cell(note)}" for note in [*notes(gate), *doubts, *left_out_lines(gate)])
    for verdict in gate.verdicts:
        if verdict.verdict == REGRESSED:
            yield from _changes(verdict)


def _changes(verdict: GateVerdict) -> Iterator[str]:
    shown = verdict.changes[:MAX_CHANGES]
    more = f", the worst {len(shown)} of them" if len(verdict.changes) > len(shown) else ""
    rows = [(change.scenario, str(change.seed), *change_texts(verdict.margin, change)) for change in shown]
    repeat = ("", "```", *(change.command for change in shown[:1]), "```") if shown else ()
    problems = count(verdict.problems, "problem")
    summary = f"{_cell(subject(verdict))}: worse on {len(verdict.changes)} of {problems}{more}"
    yield from _details(summary, [*_table([("scenario", "seed", "baseline", "now"), *rows]), *repeat])


def _clear(data: ReportData) -> pd.DataFrame:
    frame = data.comparisons
    return frame[(frame["scenario"] == "all") & frame["verdict"].isin(["better", "worse"])]


def _comparisons(data: ReportData) -> Iterator[str]:
    """Comparisons over all scenarios with a clear verdict."""
    clear = _clear(data)
    if clear.empty:
        return
    names = {kpi.name: compared_name(kpi) + timing_mark(kpi, data) for kpi in data.kpis}
    names[SUCCESS.name] = "success [%; b − a in percentage points]"
    rows = [
        (
            f"{row['planner_b']} is {row['verdict']} than {row['planner_a']}",
            names.get(str(row["kpi"]), str(row["kpi"])),
            str(row["pairs"]),
            *(_figure(row, name) for name in ("median_a", "median_b", "difference_low", "difference_high")),
        )
        for row in clear.head(MAX_COMPARISONS).to_dict("records")
    ]
    figures = "mean of the scenarios' medians" if data.trials["scenario"].nunique() > 1 else "median"
    heads = ("b, a", "kpi", "pairs", f"a: {figures}", f"b: {figures}", "b − a, 95 % from", "to")
    lines = list(_table([heads, *rows]))
    if len(clear) > MAX_COMPARISONS:
        lines.append(f"\n{len(clear) - MAX_COMPARISONS} more are in comparisons.csv.")
    yield from _details(f"{count(len(clear), 'clear difference')} between planners", lines)


def _figure(row: Mapping[Any, Any], name: str) -> str:
    return f"{100 * row[name] if row['kpi'] == SUCCESS.name else row[name]:.3g}"


def _failures(data: ReportData) -> Iterator[str]:
    failed = data.trials[~data.trials["success"].astype(bool)]
    if failed.empty:
        return
    rows = [
        (str(row["node_id"]), _outcome(row), _shortened(str(row["message"])))
        for row in failed.head(MAX_FAILURES).to_dict("records")
    ]
    lines = list(_table([("trial", "outcome", "what happened"), *rows]))
    if len(failed) > MAX_FAILURES:
        lines.append(f"\n{len(failed) - MAX_FAILURES} more are in trials.csv.")
    yield from _details(f"{count(len(failed), 'trial')} without success", lines)


def _outcome(row: Mapping[Any, Any]) -> str:
    return "criteria_failed" if row["failed_criteria"] else str(row["outcome"])


def _details(summary: str, lines: Sequence[str]) -> Iterator[str]:
    yield from (f"<details><summary>{summary}</summary>", "", *lines, "", "</details>")


def _table(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    head, *body = rows
    yield _row(head)
    yield "|---" * len(head) + "|"
    yield from map(_row, body)


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(map(_cell, cells))} |"


def _cell(text: str) -> str:
    """Text that means itself: no table cell ends, no tag begins, no markup starts in it."""
    plain = " ".join(text.split()).replace("&", "&amp;").replace("<", "&lt;")
    for character in "\\|`*_[]":
        plain = plain.replace(character, f"\\{character}")
    return plain


def _shortened(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= MAX_MESSAGE else f"{line[: MAX_MESSAGE - 1]}…"
