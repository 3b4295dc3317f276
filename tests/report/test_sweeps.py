"""The report's section about sweeps."""

from __future__ import annotations

import dataclasses

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.palette import planner_styles
from pytest_lpb.report.report import page, render
from pytest_lpb.report.sweeps import sweep_section


def swept(run: ReportData) -> ReportData:
    """The run, its first two planners told to be variants of one."""
    names = list(dict.fromkeys(run.trials["planner"]))[:2]
    variants = {name: {"of": "base", "values": {"gain": 10.0**place}} for place, name in enumerate(names)}
    return dataclasses.replace(run, run_info={**run.run_info, "swept": {"planners": variants, "scenarios": {}}})


def test_no_sweeps_no_section(run: ReportData) -> None:
    assert sweep_section(run, planner_styles(run.trials["planner"])) is None
    assert 'id="sweeps"' not in render(page(run))


def test_every_kpi_has_its_figure(run: ReportData) -> None:
    section = sweep_section(swept(run), planner_styles(run.trials["planner"]))
    assert section is not None
    (sweep,) = section.sweeps
    assert sweep.title == "base: gain"
    titles = [figure.title for figure in [*sweep.figures, *sweep.further]]
    assert titles[0] == "success rate"
    assert len(titles) > 10
    for figure in sweep.figures:
        assert [tick.label for tick in figure.x_ticks] == ["1.0", "10.0"]
        (line,) = figure.lines
        assert len(line.dots) == 2
        assert all(0 <= x <= 1000 and 0 <= y <= 1000 for x, y, _ in line.dots)


def test_the_section_is_shown(run: ReportData) -> None:
    html = render(page(swept(run)))
    assert 'id="sweeps"' in html
    assert "base: gain" in html
