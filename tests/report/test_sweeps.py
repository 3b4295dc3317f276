"""The report's section about sweeps."""

from __future__ import annotations

import dataclasses

import pandas as pd

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
    assert titles[0] == "success rate, mean of 3 scenarios"
    assert len(titles) > 10
    for figure in sweep.figures:
        assert [tick.label for tick in figure.x_ticks] == ["1.0", "10.0"]
        assert figure.x_title == "gain"
        (line,) = figure.lines
        assert len(line.dots) == 2
        assert all(0 <= x <= 1000 and 0 <= y <= 1000 for x, y, _ in line.dots)


def test_points_have_intervals_and_say_of_how_much(run: ReportData) -> None:
    section = sweep_section(swept(run), planner_styles(run.trials["planner"]))
    assert section is not None
    success = section.sweeps[0].figures[0]
    summary = run.summary[run.summary["scenario"] == "all"].set_index("planner")
    names = list(dict.fromkeys(run.trials["planner"]))[:2]
    for name, (_, _, text) in zip(names, success.lines[0].dots, strict=True):
        assert text.endswith(f"), {summary.loc[name, 'successes']}/{summary.loc[name, 'trials']}")
    assert success.lines[0].whiskers.count("M") == 2


def test_the_section_is_shown(run: ReportData) -> None:
    html = render(page(swept(run)))
    assert 'id="sweeps"' in html
    assert "base: gain" in html


def test_lines_of_one_planner_differ(run: ReportData) -> None:
    """Two knobs: over one of them, a planner has a line for each value of the other."""
    scenario = run.trials["scenario"].iloc[0]
    parts = []
    variants = {}
    for radius in (1, 2):
        for speed in (1, 2):
            name = f"{scenario}_{radius}_{speed}"
            variants[name] = {"of": "base", "values": {"radius": radius, "speed": speed}}
            parts.append(run.summary[run.summary["scenario"] == scenario].assign(scenario=name))
    told = {**run.run_info, "swept": {"planners": {}, "scenarios": variants}}
    data = dataclasses.replace(run, summary=pd.concat(parts), run_info=told)
    section = sweep_section(data, planner_styles(run.trials["planner"]))
    assert section is not None
    assert [sweep.title for sweep in section.sweeps] == ["base: radius", "base: speed"]
    for sweep in section.sweeps:
        seen: dict[str, tuple[int, str]] = {}
        for figure in [*sweep.figures, *sweep.further]:
            looks = {line.label: (line.style.number, line.dash) for line in figure.lines}
            assert len(set(looks.values())) == len(looks)
            seen = looks | seen
            assert looks.items() <= seen.items()  # as in the legend
        assert len(seen) == 2 * run.trials["planner"].nunique()
