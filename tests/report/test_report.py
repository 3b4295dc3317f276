"""What the report says, and what it must never contain."""

import base64
import hashlib
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.provenance import provenance
from pytest_lpb.report.report import page, render, write_report
from pytest_lpb.report.sections import VIEWS

from .runs import make_run

EVIL = "<script>alert(1)</script>"
ROUTES = {"scenario", *(view.name for view in VIEWS)}


class Elements(HTMLParser):
    """Tags with their attributes, and the text outside styles and scripts."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self._raw = False
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._raw = tag in ("style", "script")

    def handle_endtag(self, tag: str) -> None:
        self._raw = False

    def handle_data(self, data: str) -> None:
        if not self._raw and data.strip():
            self.text.append(" ".join(data.split()))


def test_text_that_no_encoding_holds_costs_no_report(run: ReportData, tmp_path: Path) -> None:
    data = replace(
        make_run(["point/two_obstacles"], ("pd",), seeds=1, crashed=False), title="b\udcff", warnings=["\udcff"]
    )
    assert r"<title>b\udcff</title>" in write_report(tmp_path / "report.html", data).read_text("utf-8")


def test_sentences_say_who_solved_what(run: ReportData, html: str) -> None:
    text = " ".join(Elements(html).text)
    for planner in ("potential_field", "pd", "fabrics"):
        row = run.summary[(run.summary["scenario"] == "all") & (run.summary["planner"] == planner)].iloc[0]
        assert f"{planner} solved {row['successes']}/12 problems (" in text
    assert "worker crash in 1" in text
    assert "95 % interval" in text


def test_names_all_planners_scenarios_and_outcomes(run: ReportData, html: str) -> None:
    text = Elements(html).text
    for name in {*run.trials["scenario"], *run.trials["planner"]}:
        assert name in text
    for outcome in set(run.trials["outcome"]):
        assert outcome.replace("_", " ") in text


def test_shows_warnings_and_marks_contended_timing(html: str) -> None:
    text = " ".join(Elements(html).text)
    assert "KPI elbow is NaN: no link 'elbow'" in text
    assert "Timing was contended" in text
    assert html.count("<sup>†</sup>") > 12
    assert "<sup>†</sup>" not in render(page(make_run(["point/two_obstacles"], seeds=1)))
    assert "–<sup>†</sup>" not in html  # nothing was timed there


def test_trials_can_be_repeated(run: ReportData, html: str) -> None:
    text = Elements(html).text
    for row in run.trials.to_dict("records"):
        assert row["command"] in text
        assert not row["message"] or row["message"] in text


@pytest.mark.parametrize(
    ("first", "trials", "text"),
    [
        (None, 2, "2 in each scenario"),
        (5, None, "from 5 on"),
        (5, 2, "2 in each scenario, from 5 on"),
        (None, None, ""),
    ],
)
def test_seeds_that_were_asked_for(first: int | None, trials: int | None, text: str) -> None:
    facts = {fact.name: fact.text for fact in provenance({"seeds": {"first": first, "trials": trials}}, {}).facts}
    assert facts.get("seeds", "") == text


def test_run_section_names_machine_versions_and_command(html: str) -> None:
    text = " ".join(Elements(html).text)
    for part in ("AMD EPYC", "7.80 GiB", "2026-11-22 02:49 UTC", "360c25b00000 with uncommitted changes", "2.4.6"):
        assert part in text
    assert "pytest --lpb-planners=potential_field,pd,fabrics -n 2 scenarios/" in text
    assert '"limit": null' in text


@pytest.mark.parametrize("column", ["scenario", "message", "command", "failed_criteria"])
def test_text_from_outside_is_never_markup(run: ReportData, column: str) -> None:
    trials = run.trials.copy()
    trials[column] = EVIL
    html = render(page(replace(run, trials=trials)))
    assert EVIL not in html
    assert html.count("<script>") == 1
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in html


def test_scenario_called_script_is_text() -> None:
    data = make_run([EVIL], planners=('"><img src=x onerror=alert(1)>',), seeds=2, warnings=[EVIL])
    elements = Elements(render(page(replace(data, title=EVIL))))
    assert elements.text.count(EVIL) > 5
    assert not [tag for tag, _ in elements.tags if tag == "img"]
    assert not [attributes for _, attributes in elements.tags if any(name.startswith("on") for name in attributes)]


HOSTILE = (
    EVIL,
    '"><img src=x onerror=alert(1)>',
    "</script><script>alert(1)</script>",
    "javascript:alert(1)",
    "{{7*7}}{% raw %}",
    "<!--<svg onload=alert(1)>",
    "]]>&amp;\x1b[31m",
)


def recorded(run: ReportData, text: str) -> ReportData:
    """A run in which everything that is recorded as text is this text."""
    entry = {"planner": text, "parameters": {text: text}, "parameters_hash": text, "source_hash": text}
    info = {
        **run.run_info,
        "command": ["pytest", text],
        "started": text,
        "planners": dict.fromkeys(run.run_info["planners"], entry),
        "packages": {text: text},
        "scenarios": {text: {"file": text, "hash": text}},
        "machine": dict.fromkeys(("cpu", "system", "python"), text),
        "git": {"commit": text, "dirty": True},
        "random": [text],
    }
    trials = run.trials.assign(message=text, command=text, failed_criteria=text)
    return replace(run, trials=trials, run_info=info, title=text, warnings=[text])


@pytest.fixture(scope="module")
def plain(run: ReportData) -> Elements:
    """The page with a harmless text wherever one is recorded."""
    return Elements(render(page(recorded(run, "x"))))


@pytest.mark.parametrize("text", HOSTILE)
def test_recorded_text_is_text_wherever_it_comes_from(run: ReportData, plain: Elements, text: str) -> None:
    """The page has the same elements with the same attributes as without."""
    hostile = Elements(render(page(recorded(run, text))))
    assert [(tag, sorted(names)) for tag, names in hostile.tags] == [(tag, sorted(names)) for tag, names in plain.tags]
    assert sum(text in part for part in hostile.text) >= 8
    addresses = [names.get(key) or "" for _, names in hostile.tags for key in ("href", "src", "action", "xlink:href")]
    assert not [address for address in addresses if address.strip().lower().startswith("javascript:")]


def test_loads_nothing(html: str) -> None:
    for tag, attributes in Elements(html).tags:
        for name in ("src", "href", "xlink:href", "action", "data", "poster", "srcset"):
            address = attributes.get(name) or ""
            assert address == "" or address.startswith(("#", "data:")), (tag, address)
    style = html[html.index("<style>") : html.index("</style>")]
    assert "url(" not in style
    assert "@import" not in style


def test_only_its_own_script_may_run(html: str) -> None:
    script = re.search(r"<script>(.*?)</script>", html, re.DOTALL)
    assert script is not None
    digest = base64.b64encode(hashlib.sha256(script[1].encode()).digest()).decode()
    policy = next(tag[1]["content"] for tag in Elements(html).tags if tag[1].get("http-equiv"))
    assert f"script-src 'sha256-{digest}'" in str(policy)
    assert "default-src 'none'" in str(policy)


def test_missing_numbers_are_dashes(run: ReportData, html: str) -> None:
    assert run.trials["time_to_goal_s"].isna().any()
    assert '<td class="num">–</td>' in html
    shown = [text.lower() for text in Elements(html).text if text not in run.warnings]
    assert not [text for text in shown if re.search(r"\b(nan|inf|none|<na>)\b", text)]
    drawn = " ".join(str(a.get(key)) for _, a in Elements(html).tags for key in ("d", "style", "data-v", "width"))
    assert "nan" not in drawn
    assert "inf" not in drawn


def test_ids_are_unique_and_labels_refer_to_them(html: str) -> None:
    tags = Elements(html).tags
    ids = [attributes["id"] for _, attributes in tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    for tag, attributes in tags:
        href = attributes.get("href") or ""
        if href.startswith("#/"):
            assert href.split("/")[1] in ROUTES
        elif tag in ("use", "a") and href.startswith("#"):
            assert href[1:] in ids
        if "aria-labelledby" in attributes:
            assert attributes["aria-labelledby"] in ids


def test_same_data_give_the_same_bytes(run: ReportData, html: str) -> None:
    assert render(page(run)) == html


def test_file_appears_whole(run: ReportData, tmp_path: Path, html: str) -> None:
    path = write_report(tmp_path / "new" / "report.html", run)
    assert path.read_text("utf-8") == html
    assert [file.name for file in path.parent.iterdir()] == ["report.html"]


def test_no_trials_at_all(run: ReportData) -> None:
    empty = replace(run, trials=run.trials.iloc[:0], summary=run.summary.iloc[:0], comparisons=run.comparisons.iloc[:0])
    assert "No trial of this run has finished." in Elements(render(page(empty))).text


def test_one_trial_and_one_planner() -> None:
    text = Elements(render(page(make_run(["arm/reach"], planners=("pd",), seeds=1, crashed=False)))).text
    assert "1 planner · 1 scenario · 1 trial · 2026-11-22 02:49 UTC" in text
    assert "Comparisons" not in text


def test_repeats_of_one_problem_are_told(run: ReportData) -> None:
    trials = run.trials.assign(problem_hash="same")
    notes = page(replace(run, trials=trials)).model("overview").notes
    assert any("Repeats of one problem count as one problem" in note for note in notes)


def test_goal_reached_but_criteria_not_met(run: ReportData) -> None:
    trials = run.trials.copy()
    reached = trials["outcome"] == "success"
    trials.loc[reached, "success"] = False
    trials.loc[reached, "failed_criteria"] = "clearance_min_m"
    view = page(replace(run, trials=trials))
    outcomes = view.model("trials").outcomes
    assert "criteria_failed" in outcomes
    assert "success" not in outcomes
    assert any("criteria failed in" in statement.detail for statement in view.model("overview").statements)


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan])
def test_numbers_that_are_none_do_not_break_figures(run: ReportData, value: float) -> None:
    trials = run.trials.copy()
    for kpi in run.kpis:
        trials[kpi.name] = value
    kpis = page(replace(run, trials=trials)).model("kpis")
    assert not kpis.options
    assert len(kpis.without_values) == len(run.kpis)


def test_size_of_200_trials() -> None:
    data = make_run(planners=("a", "b", "c", "d", "e"), seeds=14)
    assert len(data.trials) >= 200
    assert len(render(page(data)).encode()) < 5_000_000


def test_size_of_1000_trials_of_500_steps(run: ReportData) -> None:
    data = _large(run, seeds=112)
    assert len(data.trials) >= 1000
    assert len(render(page(data)).encode()) < 8_000_000


def _large(run: ReportData, seeds: int) -> ReportData:
    """The run's trials over and over, each with another seed and 500 steps."""
    base = run.trials[run.trials["seed"] == 0]
    frames = [base.assign(seed=seed, node_id=base["node_id"] + f"-{seed}") for seed in range(seeds)]

    def trajectory_of(node_id: str) -> Any:
        trajectory = run.trajectory_of(node_id.rsplit("-", 1)[0])
        rows = np.linspace(0, len(trajectory) - 1, 501).astype(int)
        columns = {name: values[rows] for name, values in trajectory.columns.items()}
        return type(trajectory)(columns, trajectory.metadata, trajectory.problem)

    return replace(run, trials=pd.concat(frames, ignore_index=True), trajectory_of=trajectory_of)
