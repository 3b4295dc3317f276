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
from pytest_lpb.report.numbers import count
from pytest_lpb.report.overview import by_success
from pytest_lpb.report.palette import styles_of
from pytest_lpb.report.provenance import moment
from pytest_lpb.report.scripts import script_of, style_of
from pytest_lpb.report.sections import shown_views
from pytest_lpb.report.view import Page, PlannerStyle
from pytest_lpb.run.title import title_of

TEMPLATES = "templates"


def write_report(path: Path, data: ReportData) -> Path:
    """Write the report of an evaluated run; the file appears at once, whole. Raises RecordingError."""
    # Names of folders may hold bytes that are no text.
    return replace_file(path, render(page(data)).encode("utf-8", "backslashreplace"))


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
    script = script_of(folder, page)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    # The hash lets the browser run this script and no other, whatever a scenario is called.
    return environment.get_template("report.html.j2").render(
        page=page,
        style=Markup(style_of(folder, page)),
        script=Markup(script),
        script_hash=f"sha256-{digest}",
    )


def page(data: ReportData) -> Page:
    """The view model of the whole page."""
    styles = styles_of(data)
    title = title_of(data.run_info)
    return Page(
        title=title or data.title or "pytest-lpb report",
        subtitle=" · ".join(filter(None, [data.title if title else "", _subtitle(data, styles)])),
        styles=by_success(data, styles),
        views=shown_views(data, styles),
    )


def _subtitle(data: ReportData, styles: Mapping[str, PlannerStyle]) -> str:
    counts = [
        (len(styles), "planner"),
        (data.trials["scenario"].nunique(), "scenario"),
        (len(data.trials), "trial"),
    ]
    started = moment(data.run_info.get("started"))
    return " · ".join([*(count(number, noun) for number, noun in counts), *([started] if started else [])])
