"""Success in words, and who is ahead by the tests of comparisons.csv, from small tables of trials by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd
import pytest

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.exported import tables
from pytest_lpb.report.heat import heat_map
from pytest_lpb.report.overview import statements, success_matrix, summary_table
from pytest_lpb.report.overview_section import notes
from pytest_lpb.report.packing import unpacked
from pytest_lpb.report.palette import planner_styles
from pytest_lpb.report.profiles import profile_section
from pytest_lpb.report.text import comparison_table, planner_notes, planner_rows
from pytest_lpb.report.timing_notes import deadline_warnings
from pytest_lpb.report.titles import compared_name, compared_title, value_title
from pytest_lpb.report.trial_pages import index
from pytest_lpb.report.winners import winners, winners_summary
from pytest_lpb.run.tables import aggregates_table, comparisons_table
from pytest_lpb.run.tables import summary_table as summaries
from tests.run.trial_frames import TIME, Column, trial


@dataclass(frozen=True)
class Reported(Column):
    """A KPI as reports see it."""

    group: str = "timing"


GOAL = Reported(TIME.name, TIME.unit, restricted_to_duration=True, group="goal")
P50 = Reported("solver_time_p50_ms", "ms", timing=True)
P95 = Reported("solver_time_p95_ms", "ms", timing=True)
CPU = Reported("solver_cpu_p50_ms", "ms", timing=True)
MISSES = Reported("deadline_miss_rate", "1", timing=True)


def reported(rows: Sequence[Mapping[str, Any]], kpis: Sequence[Reported] = (GOAL,), **info: Any) -> ReportData:
    """A run of these trials; what a trial says of no KPI is NaN."""
    empty = {kpi.name: math.nan for kpi in kpis} | {"message": "", "command": "", "control": ""}
    trials = pd.DataFrame([{**empty, **row} for row in rows])
    trials["node_id"] = [f"{index}" for index in range(len(trials))]
    return ReportData(
        trials=trials,
        summary=summaries(trials, kpis),
        comparisons=comparisons_table(trials, kpis),
        aggregates=aggregates_table(trials, kpis),
        kpis=kpis,
        run_info=info,
        trajectory_of=lambda node_id: pytest.fail(node_id),
    )


def solving(planner: str, solved: str, scenario: str = "s", time: float = 5.0) -> list[dict[str, object]]:
    """One trial per letter: `x` is solved after `time` and a little more with each seed, `.` is not."""
    return [
        trial(scenario, planner, seed, success=letter == "x", time_to_goal_s=time + 0.01 * seed)
        if letter == "x"
        else trial(scenario, planner, seed, success=False, time_to_goal_s=math.nan)
        for seed, letter in enumerate(solved)
    ]


def test_trials_solved_stand_first_and_the_mean_over_scenarios_is_named() -> None:
    """a: 4/4 and 0/1, a mean of 50 %; b: 2/4 and 1/1, a mean of 75 %. a solved more trials and stands first."""
    rows = [
        *solving("a", "xxxx", "s1"),
        *solving("a", ".", "s2"),
        *solving("b", "xx..", "s1"),
        *solving("b", "x", "s2"),
    ]
    data, styles = reported(rows), planner_styles(["b", "a"])
    assert [(entry.style.name, entry.text) for entry in statements(data, styles)] == [
        ("a", "solved 4/5 problems (mean of 2 scenarios: 50\u202f%, 95 % interval 13–87\u202f%)"),
        ("b", "solved 3/5 problems (mean of 2 scenarios: 75\u202f%, 95 % interval 27–96\u202f%)"),
    ]
    assert [row[:4] for row in planner_rows(data)] == [
        ["planner", "solved", "problems", "mean of 2 scenarios"],
        ("a", "4/5", "5", "50 %"),
        ("b", "3/5", "5", "75 %"),
    ]
    heads, table = summary_table(data, styles)
    assert heads[:3] == ["solved", "problems", "mean of 2 scenarios"]
    assert [[cell.text for cell in row.cells[:3]] for row in table] == [
        ["4/5", "5", "50\u202f%"],
        ["3/5", "5", "75\u202f%"],
    ]
    matrix = {
        row.scenario: [(cell.text, cell.note.split(" · ")[0]) for cell in row.cells]
        for row in success_matrix(data, styles)
    }
    assert matrix["s1"] == [("2/4", "50\u202f%"), ("4/4", "100\u202f%")]
    assert matrix["all"][1] == ("4/5", "mean of 2 scenarios: 50\u202f%")
    rows_of_all = [row[1:5] for row in tables(data)[0].rows if row[0] == "all"]
    assert [row[:2] for row in rows_of_all] == [["a", "4/5"], ["b", "3/5"]]
    assert rows_of_all[0][3].startswith("mean of 2 scenarios: 50 (")


def test_one_scenario_has_a_rate_and_repeats_a_mean_of_problems() -> None:
    one = reported([*solving("a", "xxx."), *solving("b", "x...")])
    assert [row[1:4] for row in planner_rows(one)][:2] == [["solved", "problems", "success rate"], ("3/4", "4", "75 %")]
    repeats = reported([{**row, "problem_hash": "x" if row["seed"] else "y"} for row in solving("a", "xxx.")])
    assert [row[1:4] for row in planner_rows(repeats)][1] == ("3/4", "2", "83 %")
    assert planner_rows(repeats)[0][3] == "mean of 2 problems"


@pytest.mark.parametrize(
    ("a", "b", "times", "names", "standing"),
    [
        ("x" * 20, "." * 15 + "x" * 5, (5.0, 5.0), ["a"], "ahead"),  # by success: 15 problems, p < 0.001
        ("." * 15 + "x" * 5, "x" * 20, (1.0, 9.0), ["b"], "ahead"),  # success goes before the time of what is solved
        ("x" * 8, "x" * 7 + ".", (5.0, 5.0), ["a", "b"], "undecided"),  # 8/8 and 7/8: McNemar's p is 1
        ("x" * 12, "x" * 12, (5.0, 6.0), ["a"], "ahead"),  # by time: 12 pairs differ by 1 s
        ("x" * 12, "x" * 12, (5.0, 5.0), ["a", "b"], "equal"),
        ("x", ".", (5.0, 5.0), ["a", "b"], "undecided"),  # one problem decides nothing, whatever it looks like
        ("....", "....", (5.0, 5.0), [], "nobody"),
    ],
)
def test_who_is_ahead(a: str, b: str, times: tuple[float, float], names: list[str], standing: str) -> None:
    data = reported([*solving("a", a, time=times[0]), *solving("b", b, time=times[1])])
    styles = planner_styles(["a", "b"])
    (winner,) = winners(data, styles)
    assert ([style.name for style in winner.styles], winner.standing) == (names, standing)
    words = {"ahead": f"{names[0] if names else ''} is ahead in 1", "nobody": "1 solved by nobody"}
    assert winners_summary([winner], styles) == f"Of 1 scenario: {words.get(standing, f'1 {standing}')}."


def test_what_is_ahead_says_by_what() -> None:
    three = [*solving("a", "x" * 12, time=5.0), *solving("b", "x" * 12, time=6.0), *solving("c", "." * 12)]
    styles = planner_styles(["a", "b", "c"])
    (winner,) = winners(reported(three), styles)
    assert winner.text == (
        "more successful than c; success decides nothing against b; sooner at the goal (failures count the duration): "
        "−1.00 s against b"
    )
    (few,) = winners(reported([*solving("a", "x"), *solving("b", ".")]), styles)
    assert few.text == "1 problem; a test needs 6"


def test_all_scenarios_together_are_judged_by_the_same_rule() -> None:
    rows = [
        row for name in ("s1", "s2") for p, time in (("a", 5.0), ("b", 6.0)) for row in solving(p, "x" * 5, name, time)
    ]
    data, styles = reported(rows), planner_styles(["a", "b"])
    found = winners(data, styles)
    # Five pairs decide nothing; the ten of both do.
    assert [(winner.scenario, winner.standing) for winner in found] == [
        ("s1", "undecided"),
        ("s2", "undecided"),
        ("all", "ahead"),
    ]
    assert winners_summary(found, styles).startswith("Of 2 scenarios: 2 undecided. Over all of them: a is ahead (")


def test_two_quantities_have_two_names() -> None:
    """Solved after 4 and 6 s, one failure in 25 s: 5 s if reached, and with the failure a mean of 35/3 s."""
    assert value_title(GOAL) == "time to goal if reached [s]"
    assert compared_title(GOAL) == "time to goal, failures count the duration [s]"
    assert compared_name(GOAL) == "time_to_goal_s, failures count the duration"
    assert value_title(P50) == compared_title(P50) == "solver time p50 [ms]"
    times = {"a": (4.0, 6.0, math.nan), "b": (4.5, 7.0, 8.0)}
    rows = [
        trial(planner=p, seed=seed, success=time == time, time_to_goal_s=time)
        for p, each in times.items()
        for seed, time in enumerate(each)
    ]
    data, styles = reported(rows), planner_styles(["a", "b"])
    heads, _ = summary_table(data, styles)
    assert dict(zip(planner_rows(data)[0], planner_rows(data)[2], strict=True))["time to goal if reached [s]"] == "5"
    assert "time to goal if reached [s]" in heads
    heat = heat_map(data, styles)
    assert heat is not None
    assert [title for _, _, title in heat.options] == ["time to goal if reached [s]"]
    assert unpacked(heat.packed)[GOAL.name][1][0][0] == ["5.00", 5.0, "4.50 to 5.50 · 2 problems"]
    section = profile_section(data, styles)
    assert section is not None
    assert {row.title for row in section.rows} == {"time to goal, failures count the duration [s]"}
    (row,) = (row for row in section.rows if row.style.name == "a")
    assert row.cells[2].text == "11.7"
    summary, comparisons = tables(data)
    assert summary.heads[5:] == ["time to goal if reached [s]"]
    assert [row[2] for row in comparisons.rows] == ["success [%]", "time to goal, failures count the duration [s]"]
    assert any(line.startswith("time_to_goal_s, failures count the duration ") for line in comparison_table(data))


def test_success_differs_by_percentage_points() -> None:
    """Three of four and one of four: 50 percentage points."""
    data = reported([*solving("a", "xxx."), *solving("b", "x...")])
    row = tables(data)[1].rows[0]
    assert row[3:6] == ["4", "75.0", "25.0"]
    assert row[6].startswith("−50.0 (")
    assert "percentage points" in tables(data)[1].caption


def timed(contended: Sequence[str], workers: int = 1, **columns: float) -> ReportData:
    """A trial for each text of contended KPIs; on two cores."""
    rows = [
        trial(seed=seed, contended_kpis=text, solver_time_p50_ms=1.0, solver_time_p95_ms=9.0, solver_cpu_p50_ms=1.0)
        | columns
        for seed, text in enumerate(contended)
    ]
    return reported(rows, [P50, P95, CPU, MISSES], workers=workers, machine={"cores": 2})


def test_a_mark_stands_at_each_timing_that_was_contended_and_nowhere_else() -> None:
    data = timed(["", "solver_time_p95_ms", ""])
    styles = planner_styles(["a"])
    assert [head for head in planner_rows(data)[0] if "[ms]" in head] == ["solver median [ms]", "p95 [ms] †"]
    heads, ((row),) = summary_table(data, styles)
    marks = {head: (cell.mark, cell.note) for head, cell in zip(heads, row.cells, strict=True)}
    assert marks["solver time p50 [ms]"] == ("", "")
    assert marks["solver time p95 [ms]"] == ("†", "1 trial †")
    heat = heat_map(data, styles)
    assert heat is not None
    assert [cells[1][0][0][0] for cells in unpacked(heat.packed).values()] == ["1.00", "9.00 †", "1.00"]
    assert tables(data)[0].heads[-2:] == ["solver time p50 [ms]", "solver time p95 [ms] †"]
    (note, cpu) = planner_notes(data)
    assert note.startswith("† Calls waited for a core in up to 1 of 3 trials")
    assert "--retime" in note
    assert cpu.startswith("CPU times can be compared: ")
    assert not list(planner_notes(timed(["", ""])))


def test_the_note_on_contention_stands_where_a_mark_is_shown_only() -> None:
    """The late calls of one trial are in a KPI that the table of planners does not have."""
    data = timed(["", "deadline_miss_rate"])
    assert not list(planner_notes(data))
    assert next(planner_notes(data, ["deadline_miss_rate"])).startswith("† ")
    assert notes(data)[0].startswith("† ")  # the page shows every KPI


def test_trial_pages_have_the_time_to_goal_of_the_trial() -> None:
    data = reported([trial(seed=0, time_to_goal_s=5.0)], [GOAL])
    assert index(data, data.trials, planner_styles(["a"]))["kpis"] == [["goal", "time to goal if reached [s]"]]


def test_contention_says_why_and_what_to_do() -> None:
    every = "solver_time_p50_ms; solver_time_p95_ms; deadline_miss_rate"
    data = timed([every, every], workers=2, timing_contended=True)
    first, second = planner_notes(data)
    assert first == (
        "† Timing was contended in 2 of 2 trials: 2 workers on 2 cores leave no core to the rest of the system. Do not "
        "compare planners by them. Time the calls again with `lpb-report RUN --retime`, or run with -n 1."
    )
    assert second.startswith("CPU times can be compared: ")


def test_a_planner_that_misses_most_of_its_deadlines_is_warned_of() -> None:
    """In s1 60 and 80 % of the calls are late, in s2 half of them: more than half only in s1."""
    rows = [trial("s1", seed=0, deadline_miss_rate=0.6), trial("s1", seed=1, deadline_miss_rate=0.8)]
    rows += [trial("s2", seed=0, deadline_miss_rate=0.5), trial("s1", "b", deadline_miss_rate=0.1)]
    (warning,) = deadline_warnings(reported(rows, [MISSES]))
    assert warning.startswith("a misses most of its deadlines in 1 of 2 scenarios: 70\u202f% of its calls in s1 ")
    assert not list(deadline_warnings(reported(rows[2:], [MISSES])))
    assert any(line.startswith("warning: a misses most") for line in planner_notes(reported(rows, [MISSES])))
