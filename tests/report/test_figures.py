"""Scenes, distributions, axes and numbers."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.report import numbers
from pytest_lpb.report.canvas import MAX_PATH_POINTS, canvas_for, path_through, thinned
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.distributions import kpi_figures, success_groups
from pytest_lpb.report.palette import COLOURS, planner_styles
from pytest_lpb.report.scale import Scale, round_values, scale_for, tick_labels
from pytest_lpb.report.scenes import representative, scenes
from pytest_lpb.report.view import Mark, Scene
from pytest_lpb.trajectory import Trajectory

STYLES = planner_styles(["potential_field", "pd", "fabrics"])


@pytest.fixture(scope="module")
def drawn(run: ReportData) -> dict[str, Scene]:
    return {scene.scenario: scene for scene in scenes(run, STYLES)}


def _marks(scene: Scene, css: str) -> list[Mark]:
    return [mark for mark in scene.panels[0].marks if mark.css == css]


def test_every_planner_has_a_path_of_its_own(drawn: dict[str, Scene]) -> None:
    for scene in drawn.values():
        paths = _marks(scene, "path")
        assert {mark.style.name for mark in paths if mark.style} == set(STYLES)
        assert all(mark.d.count("L") < MAX_PATH_POINTS for mark in paths)
        assert len(_marks(scene, "goal")) == len(_marks(scene, "tolerance")) == 1


def test_collision_is_marked_where_it_happened(run: ReportData, drawn: dict[str, Scene]) -> None:
    crosses = [mark for mark in _marks(drawn["point/two_obstacles"], "collision") if mark.style]
    assert {mark.style.name for mark in crosses if mark.style} == {"pd"}
    cross = np.array(re.findall(r"-?[\d.]+", crosses[0].d), dtype=float).reshape(-1, 2).mean(axis=0)
    pd_path = next(m for m in _marks(drawn["point/two_obstacles"], "path") if m.style and m.style.name == "pd")
    end = np.array(re.findall(r"-?[\d.]+", pd_path.d)[-2:], dtype=float)
    assert np.linalg.norm(cross - end) < 2  # [px]: a point touches where it stands


def test_moving_obstacle_has_track_and_ghosts(drawn: dict[str, Scene]) -> None:
    assert len(_marks(drawn["cart/crossing"], "track")) == 1
    assert len(_marks(drawn["cart/crossing"], "obstacle ghost")) == 4
    assert not _marks(drawn["point/two_obstacles"], "track")


def test_arm_has_ghost_poses_and_a_cart_its_heading(drawn: dict[str, Scene]) -> None:
    assert len(_marks(drawn["arm/reach"], "robot ghost")) == 15
    assert len(_marks(drawn["cart/crossing"], "heading final")) == 3
    assert not _marks(drawn["point/two_obstacles"], "robot ghost")


def test_timelines_have_a_line_per_planner(drawn: dict[str, Scene]) -> None:
    assert [timeline.title for timeline in drawn["arm/reach"].timelines] == ["goal error [m]", "clearance [m]"]
    assert all(len(timeline.lines) == 3 for timeline in drawn["arm/reach"].timelines)


def test_trial_without_raw_data_is_told(run: ReportData) -> None:
    lost = replace(run, trials=run.trials[run.trials["outcome"] == "worker_crash"])
    (scene,) = scenes(lost, STYLES)
    assert not scene.panels
    assert "no trial file" in scene.notes[0]


def test_representative_is_the_first_seed_that_most_planners_ran(run: ReportData) -> None:
    rows = run.trials[run.trials["scenario"] == "arm/reach"]
    without = rows[~((rows["planner"] == "pd") & (rows["seed"] == 0))]
    assert representative(without)["seed"].tolist() == [1, 1, 1]
    assert representative(without)["planner"].tolist() == ["potential_field", "fabrics", "pd"]


def test_paths_that_run_far_away_do_not_shrink_the_picture() -> None:
    near = np.array([[0.0, 0.0], [4.0, 2.0]])
    far = np.array([[0.0, 0.0], [1e6, 0.0], [np.nan, 0.0]])
    canvas = canvas_for(near, far)
    assert canvas.high[0] - canvas.low[0] < 10
    assert "nan" not in canvas.line(far)


def test_thinning_keeps_both_ends() -> None:
    points = np.random.default_rng(0).normal(size=(5000, 2))
    kept = thinned(points)
    assert len(kept) == MAX_PATH_POINTS
    assert np.array_equal(kept[[0, -1]], points[[0, -1]])


def test_path_is_lifted_over_gaps() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [np.nan, np.nan], [2.0, 0.0], [3.0, 0.0]])
    assert path_through(points) == "M0.0 0.0L1.0 0.0M2.0 0.0L3.0 0.0"


def test_boxes_count_only_the_trials_of_the_kpi(run: ReportData) -> None:
    figures, _ = kpi_figures(run, STYLES)
    figure = next(figure for figure in figures if figure.name == "path_length_m")
    assert "solved trials only" in figure.notes
    group = next(group for group in figure.groups if group.name == "point/two_obstacles")
    solved = run.trials[run.trials["success"] & (run.trials["scenario"] == "point/two_obstacles")]
    assert {row.style.name: row.number for row in group.rows} == solved.groupby("planner").size().to_dict()


def test_success_bars_hold_their_interval(run: ReportData) -> None:
    groups = success_groups(run.summary, STYLES)
    assert groups[0].name == "all scenarios"
    for row in (row for group in groups for row in group.rows):
        assert row.low is not None
        assert row.rate is not None
        assert row.high is not None
        assert 0 <= row.low <= row.rate <= row.high <= 100


def test_forty_planners_look_different() -> None:
    styles = planner_styles(f"p{i}" for i in range(40)).values()
    assert len({(style.colour, style.dash) for style in styles}) == 40


@pytest.mark.parametrize("colour", COLOURS)
def test_colours_are_seen_on_white(colour: str) -> None:
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    assert 1.05 / (luminance + 0.05) > 4.5  # WCAG AA for text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (31, "31.0"),
        (0.12345, "0.123"),
        (9.999, "10.0"),
        (0.00996, "0.00996"),
        (-12.345, "−12.3"),
        (12345.6, "12\u202f346"),
        (1.5e-7, "1.5·10⁻⁷"),
        (float("nan"), "–"),
        (float("inf"), "–"),
        (None, "–"),
        ("text", "–"),
    ],
)
def test_numbers_as_people_read_them(value: object, text: str) -> None:
    assert numbers.show(value) == text


def test_rates_are_all_or_none_only_when_they_are() -> None:
    shown = [numbers.percent(rate).replace("\u202f", "") for rate in (0, 0.001, 0.5, 0.999, 1, np.nan)]
    assert shown == ["0%", "< 1%", "50%", "> 99%", "100%", "–"]


@pytest.mark.parametrize(
    ("name", "unit", "title"),
    [
        ("path_length_m", "m", "path length [m]"),
        ("jerk_rms_m_per_s3", "m/s^3", "jerk rms [m/s³]"),
        ("curvature_max_per_m", "1/m", "curvature max [1/m]"),
        ("spl", "1", "spl"),
        ("elbow", "m", "elbow [m]"),
    ],
)
def test_kpi_titles(name: str, unit: str, title: str) -> None:
    assert numbers.kpi_title(name, unit) == title


@pytest.mark.parametrize("low", [-3.0, 0.0, 1e-9, 12345.0])
@pytest.mark.parametrize("span", [1e-6, 0.3, 7.0, 1e8])
def test_ticks_are_round_few_and_inside(low: float, span: float) -> None:
    values = round_values(low, low + span, 6)
    assert 1 <= len(values) <= 8
    assert all(low - 1e-6 * span <= value <= low + 1.000001 * span for value in values)
    assert len(set(tick_labels(values))) == len(values)


def test_axis_holds_its_values() -> None:
    for values in ([1.0], [0.0], [-2.0, 5.0], [3.0, 3.1], [1e-3, 1e3]):
        array = np.array(values)
        scale = scale_for(array, may_be_logarithmic=True)
        assert ((scale.place(array) >= 0) & (scale.place(array) <= 1)).all()
        assert len(scale.ticks()) >= 2
    assert scale_for(np.array([1e-3, 1e3]), may_be_logarithmic=True).logarithmic
    assert [tick.label for tick in Scale(0.9, 11.0, logarithmic=True).ticks()] == ["1", "2", "5", "10"]


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1))
def test_any_numbers_have_an_axis_and_a_text(values: list[float]) -> None:
    array = np.array([*values, 1.0])
    for may_be_logarithmic in (False, True):
        scale = scale_for(array, may_be_logarithmic=may_be_logarithmic)
        assert (np.abs(scale.place(array)) < 2.001).all()
        assert scale.ticks()
    assert all(len(numbers.show(value)) < 20 for value in values)


def test_values_too_large_to_draw_are_told(run: ReportData) -> None:
    trials = run.trials.copy()
    trials["path_length_m"] = 1.0
    trials.loc[trials.index[trials["success"]][0], "path_length_m"] = -1.79e308
    figure = next(f for f in kpi_figures(replace(run, trials=trials), STYLES)[0] if f.name == "path_length_m")
    assert "1 value too large to draw: −1.8·10³⁰⁸ (" in " ".join(figure.notes)
    figures, without = kpi_figures(replace(run, trials=trials.assign(path_length_m=1.6e308)), STYLES)
    figure = next(f for f in figures if f.name == "path_length_m")
    assert not figure.groups
    assert not figure.ticks
    assert "path_length_m" not in without


@pytest.mark.parametrize("far", [1e13, 1e155, 1e300, -1.7e308, np.inf, np.nan])
def test_trajectories_that_diverge_are_drawn_within_a_sane_window(run: ReportData, far: float) -> None:
    """Warnings are errors here."""

    def diverged(node_id: str) -> Trajectory:
        made = run.trajectory_of(node_id)
        columns = {name: values.copy() for name, values in made.columns.items()}
        for name, values in columns.items():
            if name.startswith(("q", "u", "link_", "clearance_m", "goal_reach_error")):
                values[len(values) // 2 :] = far
                values[-1] = -far
        return Trajectory(columns, made.metadata, made.problem)

    drawn = scenes(replace(run, trajectory_of=diverged), STYLES)
    paths = [mark.d for scene in drawn for panel in scene.panels for mark in panel.marks]
    paths += [line.d for scene in drawn for timeline in scene.timelines for line in timeline.lines]
    places = [float(text) for path in paths for text in re.findall(r"-?\d+\.?\d*", path)]
    assert not re.search("nan|inf|e", "".join(paths))
    assert len(paths) > 30
    assert max(map(abs, places)) < 20_000
