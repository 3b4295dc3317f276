"""What the report is made of: views, and the sections in each. A new section is a template and a line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pytest_lpb.report.comparison_section import comparison_section
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.distributions import kpi_section
from pytest_lpb.report.fault_text import fault_section
from pytest_lpb.report.gate_section import gate_section
from pytest_lpb.report.known_failures import known_failures
from pytest_lpb.report.overview_section import overview
from pytest_lpb.report.profiles import profile_section
from pytest_lpb.report.provenance import run_section
from pytest_lpb.report.retimed import retimed_section
from pytest_lpb.report.scenes import scenario_section
from pytest_lpb.report.sweeps import sweep_section
from pytest_lpb.report.trial_pages import trial_pages
from pytest_lpb.report.trial_section import trial_section
from pytest_lpb.report.user_figures import plot_section
from pytest_lpb.report.view import PlannerStyle, ShownSection, ShownView

Styles = Mapping[str, PlannerStyle]
Build = Callable[[ReportData, Styles], Any]


@dataclass(frozen=True)
class Section:
    """Part of a view.

    Args:
        name: id of the section's element.
        template: file in templates/; it sees `model`, `page` and the macros it imports.
        build: makes the template's `model`; None: the section is left out.
    """

    name: str
    template: str
    build: Build


@dataclass(frozen=True)
class View:
    """What is seen at once, at the address `#/NAME`.

    Args:
        name: in the address.
        title: in the navigation; empty: it is reached by links alone.
        sections: from top to bottom.
    """

    name: str
    title: str
    sections: tuple[Section, ...]


VIEWS = (
    View(
        "overview",
        "Overview",
        (
            Section("faults", "_faults.html.j2", fault_section),
            Section("overview", "_overview.html.j2", overview),
            Section("known", "_known.html.j2", known_failures),
        ),
    ),
    View("gate", "Gate", (Section("gate", "_gate.html.j2", gate_section),)),
    View("scenarios", "Scenarios", (Section("scenarios", "_scenes.html.j2", scenario_section),)),
    View("kpis", "KPIs", (Section("kpis", "_kpis.html.j2", kpi_section),)),
    View("profiles", "Profiles", (Section("profiles", "_profiles.html.j2", profile_section),)),
    View("comparisons", "Comparisons", (Section("comparisons", "_comparisons.html.j2", comparison_section),)),
    View("sweeps", "Sweeps", (Section("sweeps", "_sweeps.html.j2", sweep_section),)),
    View("retimed", "Retimed", (Section("retimed", "_retimed.html.j2", retimed_section),)),
    View("plots", "Plots", (Section("plots", "_plots.html.j2", plot_section),)),
    View("trials", "Trials", (Section("trials", "_trials.html.j2", trial_section),)),
    View("trial", "", (Section("trial", "_trial.html.j2", trial_pages),)),
    View("run", "Run", (Section("run", "_run.html.j2", run_section),)),
)


def shown_views(data: ReportData, styles: Styles) -> list[ShownView]:
    """The views with something to show."""
    shown = []
    for view in VIEWS:
        models = [(section, section.build(data, styles)) for section in view.sections]
        sections = [ShownSection(part.name, part.template, model) for part, model in models if model is not None]
        if sections:
            shown.append(ShownView(view.name, view.title, sections))
    return shown
