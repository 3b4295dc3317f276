"""The report's section about the regression gate."""

from __future__ import annotations

import dataclasses

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.gate_section import MAX_CHANGES, GateSection, gate_section
from pytest_lpb.report.palette import planner_styles
from pytest_lpb.run.gate import Gate
from pytest_lpb.run.margins import parse_margins
from tests.report.test_markdown import all_kpis, report_data
from tests.run.test_gate import MACHINE, Old, failed, trials
from tests.run.trial_frames import KPIS


def judged(old: pd.DataFrame, new: pd.DataFrame, *margins: str) -> ReportData:
    gate = Gate(Old(old), parse_margins(margins, KPIS, "--x")).judge(new, MACHINE)
    return dataclasses.replace(report_data(all_kpis(new)), gate=gate)


def section(data: ReportData) -> GateSection:
    found = gate_section(data, planner_styles(["a"]))
    assert found is not None
    return found


def test_without_a_baseline_there_is_none() -> None:
    assert gate_section(report_data(all_kpis(trials(3))), planner_styles(["a"])) is None


def test_a_closed_gate_shows_the_problems_that_changed() -> None:
    shown = section(judged(trials(80), trials(80, failed(range(60))), "success:2%", "clearance_min_m:0.01m"))
    assert (shown.closed, shown.conclusion, shown.baseline) == (True, "GATE CLOSED: 1 verdict regressed", "old")
    assert [(entry.verdict, entry.look) for entry in shown.entries] == [
        ("regressed", "worse"),
        ("same or better", "better"),
    ]
    assert all(len(entry.cells) == len(shown.heads) for entry in shown.entries)
    (changes,) = shown.changes
    assert changes.title == "a, success: worse on 60 of 80 problems; the worst 50 of them"
    assert len(changes.problems) == MAX_CHANGES
    first = changes.problems[0]
    assert (first.scenario, first.seed, first.old, first.new) == ("s", 0, "success", "timeout")
    assert (first.node_id, first.command) == ("scenarios/s.yaml::a::seed0", "pytest scenarios/s.yaml::a::seed0")


def test_an_inconclusive_gate_says_why() -> None:
    shown = section(judged(trials(10), trials(12), "success:2%"))
    assert not shown.closed
    assert shown.entries[0].look == "inconclusive"
    assert shown.notes[0].startswith("a, success: 10 common problems; 20 are needed; at least 10 further seeds")
    assert shown.notes[1] == "not compared: a: not in the baseline: s seed10, s seed11"
