"""The decorator `plot`, its registry, and plots as files and in the report."""

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.drawing import drawings, figure_of
from pytest_lpb.report.palette import COLOURS, styles_of
from pytest_lpb.report.plots import PlotRegistry, default_registry, load_builtin, write_plots
from pytest_lpb.report.report import page, render
from pytest_lpb.report.user_figures import user_figures
from pytest_lpb.run.summary import summary_table
from pytest_lpb.trajectory import Trajectory

from .runs import make_run

OF_TRIALS = ["path", "clearance", "goal_error", "action", "solver_time"]
BUILTIN = [*OF_TRIALS, "success", "kpi", "comparison", "profile"]


def _draw(trajectory: Any, axes: Any) -> None:
    axes.plot(trajectory.t, trajectory.q[:, 0])


@pytest.fixture
def small(run: ReportData) -> ReportData:
    """Two of the run's trials."""
    chosen = run.trials["scenario"].eq("cart/crossing") & run.trials["seed"].eq(0)
    return replace(run, trials=run.trials[chosen & run.trials["planner"].ne("fabrics")])


@pytest.fixture(autouse=True)
def preserved() -> Iterator[None]:
    load_builtin()
    with default_registry.preserved():
        yield


def test_built_in_plots() -> None:
    assert [entry.name for entry in load_builtin() if entry.builtin] == BUILTIN


def test_importing_plots_does_not_import_matplotlib() -> None:
    code = "import sys, pytest_lpb.report.plots; sys.exit('matplotlib' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_same_function_again_replaces_another_is_refused() -> None:
    registry = PlotRegistry()
    registry.plot("mine")(_draw)
    registry.plot("mine")(_draw)
    with pytest.raises(ConfigurationError, match=r"'mine'.*taken by .*test_plots\.py.*rename"):
        registry.plot("mine")(lambda trajectory, axes: None)
    assert len(list(registry)) == 1


@pytest.mark.parametrize("name", ["", "../x", "a b", "1st", "é" * 3])
def test_names_are_checked(name: str) -> None:
    with pytest.raises(ConfigurationError, match="a name begins with a letter"):
        PlotRegistry().plot(name)(_draw)


def test_scope_is_checked() -> None:
    wrong: Any = "planner"
    with pytest.raises(ConfigurationError, match="'planner'; allowed: run, scenario, trial"):
        PlotRegistry().plot("mine", scope=wrong)(_draw)


def test_unknown_names_are_told_with_the_nearest() -> None:
    with pytest.raises(ConfigurationError, match="unknown plot 'clearence'; did you mean 'clearance'"):
        default_registry.select(["clearence"])


@pytest.mark.parametrize("name", BUILTIN)
def test_built_in_plots_are_written(small: ReportData, tmp_path: Path, name: str) -> None:
    """In both formats, for a part of the KPIs: all of them are drawn below."""
    small = replace(small, kpis=small.kpis[::4])
    written = write_plots(tmp_path, [name], small)
    assert not written.failures
    kpis = sum(small.trials[kpi.name].notna().any() for kpi in small.kpis)
    directed = sum(small.trials[kpi.name].notna().any() for kpi in small.kpis if kpi.direction != "none")
    pairs = len(small.comparisons.groupby(["planner_a", "planner_b"]))
    pictures = {"success": 1, "kpi": kpis, "comparison": pairs, "profile": directed}
    assert len(written.paths) == 2 * pictures.get(name, 2)
    for path in written.paths:
        start = {".png": b"\x89PNG", ".pdf": b"%PDF"}[path.suffix]
        assert path.read_bytes().startswith(start)
        assert path.stat().st_size > 3000


def test_plots_of_tables_are_named_by_kpi_and_pair(small: ReportData, tmp_path: Path) -> None:
    paths = write_plots(tmp_path, ["kpi", "comparison"], small, ["svg"]).paths
    names = {path.relative_to(tmp_path).as_posix() for path in paths}
    assert {"kpi/clearance_min_m.svg", "comparison/fabrics/pd.svg"} <= names


def test_file_names_follow_scenario_planner_and_seed(small: ReportData, tmp_path: Path) -> None:
    evil = replace(small, trials=small.trials.assign(scenario="../../x/<b>"))
    paths = {path.relative_to(tmp_path).as_posix() for path in write_plots(tmp_path, ["clearance"], evil).paths}
    assert "clearance/_/_/x/_b_/pd/seed0.png" in paths
    assert all(path.is_file() for path in (tmp_path / name for name in paths))


def _axes(name: str, part: str | None, data: ReportData) -> Any:
    """The axes of a plot's picture; of tables by the KPI, or what else, that it is of."""
    made = drawings(default_registry.select([name])[0], data, data.trials)
    return figure_of(next(drawing for drawing in made if part is None or part in drawing.parts)).axes[0]


def test_a_planner_has_one_colour_in_all_pictures_that_of_the_report(run: ReportData) -> None:
    data = replace(run, run_info={**run.run_info, "planners": {"pd": {}, "potential_field": {}, "fabrics": {}}})
    expected = {name: to_rgb(COLOURS[style.colour]) for name, style in styles_of(data).items()}
    assert list(expected) == ["pd", "potential_field", "fabrics"]
    success = _axes("success", None, data)
    names = [label.get_text().split()[0] for label in success.get_yticklabels()]  # "pd 8/12"
    bars = {name: to_rgb(bar.get_facecolor()) for name, bar in zip(names, success.patches, strict=True)}
    lines = [
        {line.get_label(): to_rgb(line.get_color()) for line in axes.lines if line.get_label() in expected}
        for axes in (_axes("kpi", "clearance_min_m", data), _axes("profile", "clearance_min_m", data))
    ]
    assert bars == lines[0] == lines[1] == expected


def test_values_that_do_not_differ_show_their_planner(small: ReportData) -> None:
    axes = _axes("kpi", "clearance_min_m", replace(small, trials=small.trials.assign(clearance_min_m=0.5)))
    colours = [to_rgb(COLOURS[style.colour]) for name, style in styles_of(small).items() if name != "fabrics"]
    medians = [line for line in axes.lines if len(set(line.get_ydata())) == 1 and len(line.get_ydata()) == 2]
    assert set(colours) <= {to_rgb(line.get_color()) for line in medians}
    assert (0.0, 0.0, 0.0) not in {to_rgb(line.get_color()) for line in medians}


def test_axes_of_profiles_run_from_left_to_right(run: ReportData) -> None:
    low, high = _axes("profile", "clearance_min_m", run).get_xlim()  # as in the report
    assert low < high


def test_labels_of_times_are_plain(small: ReportData) -> None:
    axes = _axes("solver_time", "pd", small)
    axes.figure.canvas.draw()
    labels = [label.get_text() for which in ("major", "minor") for label in axes.yaxis.get_ticklabels(which=which)]
    assert [text for text in labels if text]
    assert all(float(text) > 0 for text in labels if text)


def test_long_comparisons_are_high_enough_to_read(run: ReportData) -> None:
    axes = _axes("comparison", "pd", run)
    axes.figure.canvas.draw()
    labels = axes.get_yticklabels()
    boxes = sorted((label.get_window_extent() for label in labels), key=lambda box: box.y0)
    assert len(boxes) > 20
    assert all(below.y1 < above.y0 + 2 for below, above in pairwise(boxes))
    assert [label.get_text() for label in axes.get_xticklabels()] == ["−200", "−50", "−10", "0", "10", "50", "200"]
    assert axes.xaxis.label.get_window_extent().x1 <= axes.figure.bbox.x1


def test_a_run_without_trials_has_no_pictures(run: ReportData, tmp_path: Path) -> None:
    empty = {name: getattr(run, name).iloc[:0] for name in ("trials", "summary", "comparisons", "aggregates")}
    written = write_plots(tmp_path, None, replace(run, **empty))
    assert (written.paths, written.failures) == ([], [])


def test_same_data_give_the_same_files(small: ReportData, tmp_path: Path) -> None:
    first, second = (write_plots(tmp_path / name, ["path"], small).paths for name in "ab")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_no_global_state_of_pyplot(small: ReportData, tmp_path: Path) -> None:
    write_plots(tmp_path, ["path"], small, formats=["png"])
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert pyplot is None or not pyplot.get_fignums()


def test_users_plots_appear_in_the_report(small: ReportData) -> None:
    seen: list[int] = []
    default_registry.plot("first_joint")(_draw)
    default_registry.plot("of_all", scope="run")(lambda trajectories, axes: seen.append(len(trajectories)))
    default_registry.plot("of_scenario", scope="scenario")(lambda trajectories, axes: axes.bar([0, 1], [1, 2]))
    html = render(page(small))
    assert seen == [2]
    assert html.count('src="data:image/svg+xml;base64,') == 4
    assert "first joint · cart · crossing · pd · seed0" in html


def test_large_plot_becomes_png(small: ReportData) -> None:
    noise = np.random.default_rng(0).normal(size=(2, 20_000))
    default_registry.plot("cloud", scope="run")(lambda trajectories, axes: axes.scatter(*noise))
    (figure,) = user_figures(small)
    assert figure.image.startswith("data:image/png;base64,")
    assert len(figure.image) < 400_000


def test_plot_that_raises_is_told_and_the_rest_goes_on(small: ReportData, tmp_path: Path) -> None:
    def broken(trajectory: Any, axes: Any) -> None:
        raise ValueError("<b>no link 'elbow'</b>")

    default_registry.plot("broken")(broken)
    default_registry.plot("first_joint")(_draw)
    written = write_plots(tmp_path, ["broken", "first_joint"], small, formats=["png"])
    assert len(written.paths) == len(written.failures) == 2
    assert "plot 'broken'" in written.failures[0]
    assert "ValueError" in written.failures[0]
    html = render(page(small))
    assert "&lt;b&gt;no link" in html
    assert "<b>no link" not in html


def test_crashed_trial_has_no_plot(run: ReportData, tmp_path: Path) -> None:
    crashed = replace(run, trials=run.trials[run.trials["outcome"] == "worker_crash"])
    written = write_plots(tmp_path, ["clearance"], crashed)
    assert not written.paths
    assert "no trial file" in written.failures[0]


@pytest.mark.parametrize("leave", [sys.exit, pytest.fail, pytest.skip])
def test_leaving_is_a_fault_like_any_other(small: ReportData, leave: Any) -> None:
    default_registry.plot("leaves", scope="run")(lambda trajectories, axes: leave("enough"))
    (figure,) = user_figures(small)
    assert "enough" in figure.error


def test_interrupts_are_not_caught(small: ReportData) -> None:
    def interrupted(trajectory: Any, axes: Any) -> None:
        raise KeyboardInterrupt

    default_registry.plot("interrupted")(interrupted)
    with pytest.raises(KeyboardInterrupt):
        user_figures(small)


def test_success_plot_agrees_with_the_summary() -> None:
    """With a crashed worker, criteria that were not met, and scenarios of different sizes."""
    data = make_run(["point/two_obstacles", "arm/reach"], planners=("b", "a"), seeds=4)
    trajectories = {}
    for row in data.trials.to_dict("records"):
        crashed = row["outcome"] == "worker_crash"
        made = data.trajectory_of(str(row["node_id"]).replace("seed3", "seed2") if crashed else str(row["node_id"]))
        columns = {name: values[: 0 if crashed else None] for name, values in made.columns.items()}
        solved = bool(row["success"]) and row["seed"] != 0
        metadata = {**made.metadata, "seed": row["seed"], "success": solved, "problem_hash": row["problem_hash"]}
        trajectories[row["node_id"]] = Trajectory(columns, metadata, made.problem)
    drop = data.trials["scenario"].eq("arm/reach") & data.trials["seed"].gt(1)
    trials = data.trials[~drop].assign(
        success=[trajectories[node].metadata["success"] for node in data.trials["node_id"][~drop]]
    )
    (drawing,) = drawings(
        default_registry.select(["success"])[0],
        replace(data, trials=trials, trajectory_of=trajectories.__getitem__),
        trials,
    )
    axes: Any = figure_of(drawing).axes[0]
    summary = summary_table(trials, [])
    rows = summary[summary["scenario"] == "all"].to_dict("records")
    expected = {f"{row['planner']} {row['successes']}/{row['trials']}": row["success_rate"] for row in rows}
    shown = [label.get_text() for label in axes.get_yticklabels()]
    assert dict(zip(shown, [bar.get_width() for bar in axes.patches], strict=True)) == expected
    assert len(set(expected.values())) == 2
