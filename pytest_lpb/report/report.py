"""report.html: one self-contained page, made from the tables and raw data of a run."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

import jinja2
from markupsafe import Markup

from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.distributions import kpi_figures, success_groups
from pytest_lpb.report.numbers import count
from pytest_lpb.report.overview import (
    by_success,
    endings,
    ordered_outcomes,
    outcome_bars,
    statements,
    success_matrix,
    summary_table,
)
from pytest_lpb.report.palette import planner_styles
from pytest_lpb.report.provenance import moment, provenance
from pytest_lpb.report.retimed import retimed_section
from pytest_lpb.report.scenes import scenes
from pytest_lpb.report.tables import COMPARISON_HEADS, comparison_rows, trial_heads, trial_rows
from pytest_lpb.report.user_figures import user_figures
from pytest_lpb.report.view import Page, PlannerStyle

TEMPLATES = "templates"
STYLES = ("style.css", "spatial.css")


def write_report(path: Path, data: ReportData) -> Path:
    """Write the report of an evaluated run; the file appears at once, whole. Raises RecordingError."""
    return replace_file(path, render(page(data)).encode())


def render(page: Page) -> str:
    """The page as HTML. Templates escape everything but the package's own style and script."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("pytest_lpb.report", TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    folder = files("pytest_lpb.report") / TEMPLATES
    # Reports without spatial problems do not carry what only these need.
    several = any(len(scene.panels) > 1 for scene in page.scenes)
    style = "".join((folder / name).read_text("utf-8") for name in STYLES[: 2 if several else 1])
    script = (folder / "script.js").read_text("utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    # The hash lets the browser run this script and no other, whatever a scenario is called.
    return environment.get_template("report.html.j2").render(
        page=page,
        style=Markup(style),
        script=Markup(script),
        script_hash=f"sha256-{digest}",
    )


def page(data: ReportData) -> Page:
    """The view model of the whole page."""
    styles = planner_styles([*(data.run_info.get("planners") or {}), *data.trials["planner"]])
    heads, summary = summary_table(data, styles)
    figures, without_values = kpi_figures(data, styles)
    comparisons, comparisons_note = comparison_rows(data, styles)
    trials, trials_note = trial_rows(data, styles)
    contended = bool(data.trials["timing_contended"].eq(True).any()) if len(data.trials) else False
    return Page(
        title=data.title or "pytest-lpb report",
        subtitle=_subtitle(data, styles),
        styles=by_success(data, styles),
        statements=statements(data, styles),
        notes=_notes(data),
        warnings=[str(warning) for warning in data.warnings],
        timing_contended=contended,
        matrix_styles=list(styles.values()),
        matrix=success_matrix(data, styles),
        summary_heads=heads,
        summary=summary,
        outcomes=outcome_bars(data, styles),
        success=success_groups(data.summary, styles),
        kpi_figures=figures,
        kpis_without_values=without_values,
        comparison_heads=COMPARISON_HEADS,
        comparisons=comparisons,
        comparisons_note=comparisons_note,
        retimed=retimed_section(data, styles),
        scenes=scenes(data, styles),
        user_figures=user_figures(data),
        trial_heads=trial_heads(data),
        trials=trials,
        trials_note=trials_note,
        provenance=provenance(data.run_info, styles),
        scenario_names=[str(name) for name in dict.fromkeys(data.trials["scenario"])],
        outcome_names=ordered_outcomes(endings(data.trials)),
    )


def _subtitle(data: ReportData, styles: Mapping[str, PlannerStyle]) -> str:
    counts = [
        (len(styles), "planner"),
        (data.trials["scenario"].nunique(), "scenario"),
        (len(data.trials), "trial"),
    ]
    started = moment(data.run_info.get("started"))
    return " · ".join([*(count(number, noun) for number, noun in counts), *([started] if started else [])])


def _notes(data: ReportData) -> list[str]:
    """What a reader must know before reading any number."""
    if data.trials.empty:
        return ["No trial of this run has finished."]
    notes = []
    problems = data.trials.groupby("scenario")["problem_hash"].nunique()
    repeats = data.trials.groupby("scenario")["seed"].nunique()
    fixed = [str(name) for name in problems.index if problems[name] == 1 and repeats[name] > 1]
    if fixed:
        notes.append(f"Repeats of one problem count as one problem; nothing is drawn in {', '.join(fixed)}.")
    if data.trials["timing_contended"].eq(True).any():
        notes.append("† Timing was contended: other work ran on the same cores. Such figures do not compare planners.")
    return notes
