"""Performance profiles in the report and as files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.palette import planner_styles
from pytest_lpb.report.plots import write_plots
from pytest_lpb.report.profiles import MAIN, profile_of, profile_section
from pytest_lpb.report.titles import value_title
from pytest_lpb.run.aggregates import aggregates_table
from tests.run.trial_frames import Column, trial

from .runs import make_run
from .test_report import Elements


@pytest.fixture(scope="module")
def quiet() -> ReportData:
    """Nothing contended, nothing crashed."""
    return make_run(contended=False, crashed=False)


def titles(data: ReportData) -> set[str]:
    section = profile_section(data, planner_styles(data.trials["planner"]))
    assert section is not None
    return {figure.title for figure in section.figures}


def test_main_kpis_and_those_of_users(quiet: ReportData) -> None:
    main = {value_title(kpi) for kpi in quiet.kpis if kpi.name in MAIN}
    assert titles(quiet) == main
    assert len(main) == len(MAIN)
    users = [_reported(Column("own_m", over="all"), "user"), *quiet.kpis]
    assert titles(replace(quiet, kpis=users, trials=quiet.trials.assign(own_m=1.0))) == {*main, "own [m]"}


def test_lines_begin_and_end_where_the_profile_does(quiet: ReportData) -> None:
    section = profile_section(quiet, planner_styles(quiet.trials["planner"]))
    assert section is not None
    kpi = next(kpi for kpi in quiet.kpis if kpi.name == "time_to_goal_s")
    profile = profile_of(kpi, quiet)
    assert profile is not None
    time = next(figure for figure in section.figures if figure.title == "time to goal if reached [s]")
    for line in time.lines:
        curve = profile.curves[line.style.name]
        places = [tuple(map(float, part.split())) for part in line.d.lstrip("M").split("L")]
        assert places[0] == pytest.approx((0.0, 1000 * (1 - curve.share[0])), abs=0.1)
        assert places[-1][1] == pytest.approx(1000 * (1 - curve.share[-1]), abs=0.1)
        assert np.all(np.diff([y for _, y in places]) <= 0)  # up the page
    assert time.note.startswith("share of problems with a value within a factor of the best planner's")
    assert time.unit == "x"


def test_the_section(run: ReportData, html: str) -> None:
    elements = Elements(html)
    assert ("section", "profiles") in [(tag, attributes.get("id")) for tag, attributes in elements.tags]
    text = elements.text
    assert "Every KPI" in text
    row = run.aggregates[(run.aggregates["kpi"] == "clearance_min_m")].iloc[0]
    assert f"{row['iqm']:.3f}" in text or f"{row['iqm']:.2f}" in text
    assert "solved by all" in text
    # Timing of the run was contended: marked here as in other tables.
    assert "solver time p50 [ms] †" in text


def test_a_report_without_trials_has_none(run: ReportData) -> None:
    empty = replace(run, trials=run.trials.iloc[:0], aggregates=run.aggregates.iloc[:0])
    assert profile_section(empty, {}) is None


def test_figures_as_files(quiet: ReportData, tmp_path: Path) -> None:
    drawn = ("clearance_min_m", "time_to_goal_s")
    kpis = [kpi for kpi in quiet.kpis if kpi.name in drawn]
    without_direction = _reported(Column("x_m", direction="none"), "goal")
    data = replace(quiet, kpis=[*kpis, without_direction], trials=quiet.trials.assign(x_m=1.0))
    written = write_plots(tmp_path, ["profile"], data)
    assert written.failures == []
    names = {path.relative_to(tmp_path).as_posix() for path in written.paths}
    assert names == {f"profile/{kpi}.{suffix}" for kpi in drawn for suffix in ("png", "pdf")}
    assert all(path.stat().st_size > 5000 for path in written.paths)
    again = write_plots(tmp_path / "again", ["profile"], data)
    assert [path.read_bytes() for path in again.paths] == [path.read_bytes() for path in written.paths]


def test_ratios_far_from_the_best_and_huge_values_are_drawn(run: ReportData) -> None:
    import pandas as pd

    kpis = [Column("time_to_goal_s", "s", restricted_to_duration=True), Column("clearance_min_m", direction="higher")]
    values = {"a": (1.0, 1e-3), "b": (1e5, -1e59)}
    rows = [
        trial(planner=p, seed=k, time_to_goal_s=t, clearance_min_m=c) for p, (t, c) in values.items() for k in range(3)
    ]
    trials = pd.DataFrame(rows)
    data = replace(
        run, trials=trials, kpis=[_reported(kpi, "goal") for kpi in kpis], aggregates=aggregates_table(trials, kpis)
    )
    section = profile_section(data, planner_styles("ab"))
    assert section is not None
    assert len(section.figures) == 2
    for figure in section.figures:
        for line in (*figure.lines, *figure.bands):
            assert "nan" not in line.d
            assert "inf" not in line.d


def _reported(kpi: Column, group: str) -> Any:
    from types import SimpleNamespace

    return SimpleNamespace(**vars(kpi), group=group)
