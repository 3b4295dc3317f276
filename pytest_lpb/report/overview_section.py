"""The overview: words, heat map and table, from their parts."""

from __future__ import annotations

from collections.abc import Mapping

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.heat import heat_map
from pytest_lpb.report.overview import outcome_bars, statements, success_matrix, summary_table
from pytest_lpb.report.timing_notes import contention_notes, deadline_warnings
from pytest_lpb.report.view import Overview, PlannerStyle
from pytest_lpb.report.winners import winners, winners_summary
from pytest_lpb.run.missing import missing_notes
from pytest_lpb.run.skipped import skipped_notes


def overview(data: ReportData, styles: Mapping[str, PlannerStyle]) -> Overview:
    """The whole overview."""
    heads, summary = summary_table(data, styles)
    won = winners(data, styles)
    return Overview(
        warnings=[
            *map(str, data.warnings),
            *missing_notes(data.missing, len(data.trials), data.resume),
            *deadline_warnings(data),
        ],
        notes=notes(data),
        statements=statements(data, styles),
        winners_summary=winners_summary(won, styles),
        winners=won,
        matrix_styles=list(styles.values()),
        matrix=success_matrix(data, styles),
        heat=heat_map(data, styles),
        summary_heads=heads,
        summary=summary,
        outcomes=outcome_bars(data, styles),
        several_scenarios=data.trials["scenario"].nunique() > 1,
    )


def notes(data: ReportData) -> list[str]:
    """What a reader must know before reading any number."""
    if data.trials.empty:
        return ["No trial of this run has finished."]
    found = []
    problems = data.trials.groupby("scenario")["problem_hash"].nunique()
    repeats = data.trials.groupby("scenario")["seed"].nunique()
    fixed = [str(name) for name in problems.index if problems[name] == 1 and repeats[name] > 1]
    if fixed:
        found.append(f"Repeats of one problem count as one problem; nothing is drawn in {', '.join(fixed)}.")
    found += contention_notes(data)
    return [*found, *skipped_notes(data.skipped), *data.run_info.get("notes", ())]
