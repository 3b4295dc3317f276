"""A run's title: from the option, a study or the ini file, to wherever the run is shown."""

from __future__ import annotations

import json

import pytest

from pytest_lpb.cli import main

from .projects import Project, read_run, text_of

EVIL = "Wider <b>margins</b> & *more*"


def test_a_title_is_shown_wherever_the_run_is(project: Project, capsys: pytest.CaptureFixture[str]) -> None:
    project.ini("lpb_title = of the ini file")
    project.scenario()
    result = project.run(f"--lpb-title=  {EVIL}\x1b[31m\n ", "scenarios")
    (run,) = project.runs()
    shown = EVIL + r"\x1b[31m"
    assert read_run(run)["title"] == shown
    assert shown in result.stdout.lines
    html = (run / "report.html").read_text("utf-8")
    escaped = r"Wider &lt;b&gt;margins&lt;/b&gt; &amp; *more*\x1b[31m"
    assert f"<title>{escaped}</title>" in html
    assert f"<h1>{escaped}</h1>" in html
    assert run.name in html  # which run it is, too
    capsys.readouterr()
    assert main([str(run), "--markdown", str(run / "summary.md")]) == 0
    assert capsys.readouterr().out.splitlines()[0] == shown
    heading = (run / "summary.md").read_text("utf-8").splitlines()[0]
    assert heading.startswith(r"### Wider &lt;b>margins&lt;/b> &amp; \*more\*")
    # It decides nothing: a trial is repeated without it, and a run is finished with its own.
    assert "title" not in project.row()["node_id"] + str(read_run(run)["options"])
    resumed = project.run(f"--lpb-resume={run}", "--lpb-title=other", planners=None)
    assert "keeps it: leave --lpb-title out" in text_of(resumed)


@pytest.mark.parametrize(
    ("option", "title"), [((), "What is it about?"), (("--lpb-title=shorter",), "shorter"), (("--lpb-title=",), "")]
)
def test_a_study_says_what_it_is_about(project: Project, option: tuple[str, ...], title: str) -> None:
    project.ini("lpb_title = of the ini file")
    project.scenario()
    text = (
        "study: |\n  What is\n  it about?\n\n  And more in detail.\nplanners: [pd]\nscenarios: scenarios/point/x.yaml\n"
    )
    project.write("study.yaml", text + "kpis: [time_to_goal_s]\n")
    project.run("study.yaml", *option, planners=None).assert_outcomes(passed=1)
    (run,) = project.runs()
    assert read_run(run).get("title", "") == title
    assert f"<title>{title or run.name}</title>" in (run / "report.html").read_text("utf-8")


def test_titles_that_are_none(project: Project, capsys: pytest.CaptureFixture[str]) -> None:
    project.scenario()
    result = project.run(f"--lpb-title={'x' * 201}", "scenarios")
    assert result.ret == 4
    assert "--lpb-title: found 201 characters; a title may have at most 200" in text_of(result)
    project.run("scenarios")
    (run,) = project.runs()
    assert "title" not in read_run(run)
    (run / "run.json").write_text(json.dumps({**read_run(run), "title": ["a"]}), "utf-8")
    assert main([str(run)]) == 4
    assert "run.json: title: found a list" in capsys.readouterr().err
