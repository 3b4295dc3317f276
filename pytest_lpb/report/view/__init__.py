"""The view models that the templates draw: text and places, ready to show."""

from pytest_lpb.report.view.common import Cell, Fact, PlannerStyle, Tick
from pytest_lpb.report.view.figures import BarGroup, BarRow, BoxGroup, BoxRow, KpiFigure, KpiSection
from pytest_lpb.report.view.overview import (
    HeatMap,
    KnownFailure,
    MatrixRow,
    OutcomeBar,
    Overview,
    PlannerRow,
    Share,
    Statement,
    Winner,
)
from pytest_lpb.report.view.page import Page, ShownSection, ShownView
from pytest_lpb.report.view.plots import UserFigure
from pytest_lpb.report.view.run import PlannerSetup, Provenance
from pytest_lpb.report.view.scene import Line, Mark, Panel, ScenarioSection, Scene, SceneEntry, Timeline
from pytest_lpb.report.view.tables import ComparisonRow, ComparisonSection, TrialPages, TrialRow, TrialSection

__all__ = [
    "BarGroup",
    "BarRow",
    "BoxGroup",
    "BoxRow",
    "Cell",
    "ComparisonRow",
    "ComparisonSection",
    "Fact",
    "HeatMap",
    "KnownFailure",
    "KpiFigure",
    "KpiSection",
    "Line",
    "Mark",
    "MatrixRow",
    "OutcomeBar",
    "Overview",
    "Page",
    "Panel",
    "PlannerRow",
    "PlannerSetup",
    "PlannerStyle",
    "Provenance",
    "ScenarioSection",
    "Scene",
    "SceneEntry",
    "Share",
    "ShownSection",
    "ShownView",
    "Statement",
    "Tick",
    "Timeline",
    "TrialPages",
    "TrialRow",
    "TrialSection",
    "UserFigure",
    "Winner",
]
