"""Who is ahead in words, the heat map, and tables for papers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.kpis.registry import Kpi
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.export import latex, latex_text, markdown, markdown_text, write_tables
from pytest_lpb.report.exported import Table, tables
from pytest_lpb.report.heat import heat_map
from pytest_lpb.report.numbers import whole_percent
from pytest_lpb.report.packing import unpacked
from pytest_lpb.report.palette import planner_styles
from pytest_lpb.report.report import page, render
from pytest_lpb.report.text import planner_rows
from pytest_lpb.run.tables import comparisons_table, summary_table

from .runs import make_run


def test_the_heat_map_has_every_kpi_with_values(run: ReportData) -> None:
    heat = heat_map(run, planner_styles(["potential_field", "pd", "fabrics"]))
    assert heat is not None
    cells = unpacked(heat.packed)
    assert list(cells) == [name for _, name, _ in heat.options]
    direction, rows = cells["path_length_m"]
    assert direction == "lower"
    assert len(rows) == 4  # three scenarios and their mean
    summary = run.summary[(run.summary["scenario"] == "point/two_obstacles") & (run.summary["planner"] == "pd")]
    expected = summary["path_length_m_median"].iloc[0]
    assert rows[0][1] is None if pd.isna(expected) else rows[0][1][1] == pytest.approx(expected)


def test_a_users_kpi_is_in_all_tables_and_figures() -> None:
    data = make_run(seeds=3, crashed=False)
    mine = Kpi("elbow_height_min_m", "m", "higher", "all", "user", lambda trajectory: 0.0, "mine")
    trials = data.trials.assign(elbow_height_min_m=[0.25 + 0.01 * row for row in range(len(data.trials))])
    kpis = [*data.kpis, mine]
    shown = replace(
        data,
        trials=trials,
        kpis=kpis,
        summary=summary_table(trials, kpis),
        comparisons=comparisons_table(trials, kpis),
    )
    view = page(shown)
    title = "elbow height min [m]"
    assert title in view.model("overview").summary_heads
    assert title in view.model("trials").heads
    assert title in [option[2] for option in view.model("overview").heat.options]
    assert title in [option[2] for option in view.model("kpis").options]
    assert title in [name for _, name in view.model("comparisons").kpis]
    assert title in [name for _, name in unpacked(view.model("trial").index)["kpis"]]
    assert title in render(view)
    summary, comparisons = tables(shown)
    assert title in summary.heads
    assert title in [row[2] for row in comparisons.rows]


def test_tables_say_what_the_csv_files_say(run: ReportData) -> None:
    summary, comparisons = tables(run)
    assert sorted(list(row[:2]) for row in summary.rows) == sorted(
        run.summary[["scenario", "planner"]].to_numpy().tolist()
    )
    assert "solver time p50 [ms] †" in summary.heads
    assert "Timing was contended" in summary.caption
    assert all(len(row) == len(table.heads) for table in (summary, comparisons) for row in table.rows)
    (only,) = (table.heads for table in tables(run, ["ldj"]) if table.name == "summary")
    assert only[5:] == ["ldj"]


@pytest.mark.parametrize(
    ("rate", "text"), [(1.0, "100"), (0.998, "> 99"), (0.994, "99"), (0.004, "< 1"), (0.0, "0"), (0.005, "< 1")]
)
def test_all_and_none_are_told_only_where_they_are(run: ReportData, rate: float, text: str) -> None:
    assert whole_percent(rate) == text
    data = replace(run, summary=run.summary.assign(success_rate=rate, success_low=0.0, success_high=1.0))
    assert planner_rows(data)[1][3] == f"{text} %"
    summary, *_ = tables(data)
    assert summary.rows[0][4] == f"{text} (0 to 100)"


def test_latex_prints_any_text() -> None:
    assert latex_text("a_b & 50 % of $x^2$ {c} \\ #1 ~") == (
        r"a\_b \& 50 \% of \$x\textasciicircum{}2\$ \{c\} \textbackslash{} \#1 \textasciitilde{}"
    )
    assert latex_text("−3.2·10⁻⁵ [m/s³] < –") == r"$-$3.2$\cdot$10$^{-5}$ [m/s$^{3}$] $<$ --"
    table = Table("t", "Two\nlines 50 %.", ["name", "x [m]"], 1, [["[a]", "1"], ["b", "2"]])
    assert latex(table).splitlines() == [
        "% Two lines 50 %. Needs \\usepackage{booktabs}.",
        r"\begin{tabular}{lr}",
        r"\toprule",
        r"name & x [m] \\",
        r"\midrule",
        r"{}[a] & 1 \\",
        r"b & 2 \\",
        r"\bottomrule",
        r"\end{tabular}",
    ]


def test_markdown_shows_any_text() -> None:
    assert markdown_text("a|b <script> *c* [d](e) \n f") == r"a\|b \<script\> \*c\* \[d\](e) f"
    table = Table("t", "Caption.", ["name", "x"], 1, [["a", "1"]])
    assert markdown(table) == "Caption.\n\n| name | x |\n| --- | ---: |\n| a | 1 |\n"


@given(st.text())
def test_a_cell_stays_one_cell(text: str) -> None:
    cell = markdown_text(text)
    assert "\n" not in cell
    assert cell.count("|") == cell.count("\\|")
    printed = latex_text(text)
    assert printed.count("&") == printed.count("\\&")
    assert printed.count("%") == printed.count("\\%")


def test_files_of_both_formats(run: ReportData, tmp_path: Path) -> None:
    paths = write_tables(tmp_path / "tables", run, ["latex", "markdown", "latex"], None)
    assert [path.name for path in paths] == ["summary.tex", "comparisons.tex", "summary.md", "comparisons.md"]
    assert [path.read_bytes() for path in paths] == [
        path.read_bytes() for path in write_tables(tmp_path / "again", run, ["latex", "markdown"], None)
    ]
