"""Properties of every KPI, a user's own included: no sentinels, the same in every frame and at every step."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_lpb.kpis.evaluate import as_number
from pytest_lpb.kpis.registry import Kpi, Registry, evaluate_kpis, load_builtin
from pytest_lpb.trajectory import Trajectory

from .scenes import ORIGIN, PLACEABLE, SCENES, Placement, Scene
from .spatial_scenes import ANYWHERE, SPATIAL, SpatialPlacement, flight, flying, rolling
from .trials import ARM, POINT_3D, REACH, make_problem, make_trial

STEP = 0.02  # [s]
SENTINELS = {-1.0, 1000.0, 999.0, -999.0, 1e6, 1e9}

# KPIs that need not be stable when dt is halved.
STEP_DEPENDENT = {
    "saturated_steps": "counts steps, of which there are twice as many",
    "solver_time_mean_ms": "the planner is called more often, at other states",
    "solver_time_p50_ms": "as the mean",
    "solver_time_p95_ms": "as the mean",
    "solver_time_p99_ms": "as the mean",
    "solver_time_max_ms": "as the mean",
    "solver_cpu_p50_ms": "as the mean",
    "solver_cpu_p95_ms": "as the mean",
    "solver_cpu_p99_ms": "as the mean",
    "first_call_ms": "one measurement of the machine",
    "setup_ms": "one measurement of the machine",
    "deadline_miss_rate": "follows from solver times and the control period",
    "longest_miss_burst": "counts calls, of which there are more",
    "real_time_factor": "a step costs wall time, and there are twice as many",
}


def _with_users_own() -> Registry:
    registry = Registry()
    for entry in load_builtin():
        registry.add(entry)

    @registry.kpi("excursion_max_m", "m", "lower", "all")
    def excursion(trajectory: Trajectory) -> float:
        path = trajectory.link(trajectory.problem.robot.link_names[-1])
        return float(np.linalg.norm(path - path[0], axis=1).max())

    return registry


REGISTRY = _with_users_own()
KPIS = list(REGISTRY)
each_kpi = pytest.mark.parametrize("entry", KPIS, ids=[entry.name for entry in KPIS])


def value_of(entry: Kpi, trajectory: Trajectory) -> float:
    """The KPI's value with nothing caught: warnings are errors here."""
    return as_number(entry(trajectory))


def check_step(entry: Kpi, scene: Scene) -> None:
    coarse, fine = (value_of(entry, scene(dt)) for dt in (STEP, STEP / 2.0))
    allowed = 0.01 * abs(coarse) + 1e-4 + (2.0 * STEP if entry.unit == "s" else 0.0)
    assert fine == pytest.approx(coarse, abs=allowed, rel=0.0, nan_ok=True)


def check_frame(entry: Kpi, scene: Scene, place: Placement) -> None:
    # Limits of x and y are an axis-aligned box, which a turned scene cannot have: compare like with like.
    here = Placement(angle=2.0 * math.pi) if place.angle else ORIGIN
    before, after = value_of(entry, scene(STEP, here)), value_of(entry, scene(STEP, place))
    assert after == pytest.approx(before, rel=1e-6, abs=1e-6, nan_ok=True)


def check_spatial_frame(entry: Kpi, scene: Scene, place: SpatialPlacement) -> None:
    # As above: a ball's coordinates are the world's, so that its limits are a box there.
    here = SpatialPlacement(angle=2.0 * math.pi)
    before, after = value_of(entry, scene(STEP, here)), value_of(entry, scene(STEP, place))
    assert after == pytest.approx(before, rel=1e-6, abs=1e-6, nan_ok=True)


def check_degenerate(entry: Kpi, trial: Callable[[], Trajectory]) -> None:
    value = value_of(entry, trial())
    assert math.isnan(value) or value not in SENTINELS


@each_kpi
@pytest.mark.parametrize("scene", [*SCENES, *SPATIAL])
def test_stable_when_the_step_is_halved(entry: Kpi, scene: Scene) -> None:
    if entry.name not in STEP_DEPENDENT:
        check_step(entry, scene)


def test_only_builtin_timing_and_counts_may_depend_on_the_step() -> None:
    allowed = {entry.name for entry in KPIS if entry.timing or entry.unit == "steps"}
    assert set(STEP_DEPENDENT) == allowed


PLACES = st.builds(
    Placement,
    st.one_of(st.just(0.0), st.floats(0.1, 6.0)),
    st.floats(-50.0, 50.0),
    st.floats(-50.0, 50.0),
)


@pytest.mark.parametrize("scene", PLACEABLE)
@settings(max_examples=10, deadline=None)
@given(place=PLACES)
def test_the_same_wherever_the_scene_lies(scene: Scene, place: Placement) -> None:
    for entry in KPIS:
        check_frame(entry, scene, place)


LENGTHS = st.floats(-50.0, 50.0)
AXES_OF_TURNS = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda axis: math.hypot(*axis) > 0.1)
IN_SPACE = st.builds(SpatialPlacement, AXES_OF_TURNS, st.floats(0.1, 6.0), st.tuples(LENGTHS, LENGTHS, LENGTHS))
ON_THE_GROUND = st.builds(
    SpatialPlacement,
    angle=st.floats(0.1, 6.0),
    shift=st.tuples(LENGTHS, LENGTHS, st.just(0.0)),
)


@pytest.mark.parametrize("scene", ANYWHERE)
@settings(max_examples=5, deadline=None)
@given(place=IN_SPACE)
def test_the_same_wherever_the_scene_lies_in_space(scene: Scene, place: SpatialPlacement) -> None:
    for entry in KPIS:
        check_spatial_frame(entry, scene, place)


@settings(max_examples=5, deadline=None)
@given(place=ON_THE_GROUND)
def test_the_same_wherever_a_base_drives(place: SpatialPlacement) -> None:
    for entry in KPIS:
        check_spatial_frame(entry, rolling, place)


@each_kpi
@pytest.mark.parametrize("scenes", [SCENES, SPATIAL], ids=["plane", "space"])
def test_applies_to_some_scene(entry: Kpi, scenes: tuple[Scene, ...]) -> None:
    """Else the properties above would hold of NaN alone."""
    assert any(math.isfinite(value_of(entry, scene(STEP))) for scene in scenes)


def nothing_happens() -> Trajectory:
    """A point that stays where it is, without obstacles, limits, actions, or calls of the planner."""
    problem = make_problem()
    action = np.full((3, 2), np.nan)
    q = np.tile([0.3, 0.4], (3, 1))
    return make_trial(problem, q, action=action, outcome="timeout", wall_s=None, setup_ms=None, period_s=None)


def one_row() -> Trajectory:
    return make_trial(make_problem(), np.array([[0.3, 0.4]]), outcome="planner_error")


def two_rows() -> Trajectory:
    return make_trial(make_problem(), np.array([[0.3, 0.4], [0.31, 0.4]]), outcome="collision")


def standing_still() -> Trajectory:
    return make_trial(make_problem(), np.tile([0.3, 0.4], (300, 1)), outcome="stalled")


def diverging() -> Trajectory:
    growing = 10.0 ** np.linspace(0.0, 300.0, 200)
    q = np.column_stack([growing, -growing])
    return make_trial(make_problem(), q, qd=q, action=q, outcome="environment_error")


def lost() -> Trajectory:
    q = np.tile([0.3, 0.4], (50, 1))
    q[30:] = np.nan
    return make_trial(make_problem(), q, qd=q, action=q, outcome="environment_error")


def arm_at_rest() -> Trajectory:
    goal = {"name": "elbow", "type": "joint", "joints": ["joint2"], "target": [1.0]}
    return make_trial(make_problem(ARM, goal=[goal]), np.zeros((20, 2)), outcome="timeout")


def ball_at_rest() -> Trajectory:
    goal = {**REACH, "target": [2.0, 0.0, 1.0]}
    return make_trial(make_problem(POINT_3D, goal=[goal]), np.zeros((20, 3)), outcome="timeout")


def ball_lost() -> Trajectory:
    path, velocity, action = flight(STEP)
    path[30:] = np.nan
    velocity[40:] = np.inf
    return make_trial(flying(STEP).problem, path, qd=velocity, action=action, outcome="environment_error")


DEGENERATE = (
    *(nothing_happens, one_row, two_rows, standing_still, diverging, lost, arm_at_rest),
    *(ball_at_rest, ball_lost),
)


@each_kpi
@pytest.mark.parametrize("trial", DEGENERATE)
def test_nan_is_never_a_sentinel(entry: Kpi, trial: Callable[[], Trajectory]) -> None:
    if trial is not diverging or entry.module != __name__:
        check_degenerate(entry, trial)


def test_most_kpis_do_not_apply_where_nothing_happens() -> None:
    finite = {entry.name for entry in KPIS if math.isfinite(value_of(entry, nothing_happens()))}
    assert finite == {
        *("final_goal_distance_m", "min_goal_distance_m"),
        *("path_length_m", "joint_path_length_m", "excursion_max_m"),
    }


def test_zero_rows_give_nan_without_a_warning() -> None:
    values, faults = evaluate_kpis(make_trial(make_problem(), np.zeros((0, 2)), outcome="worker_crash"), KPIS)
    assert list(values) == [entry.name for entry in KPIS]
    assert all(math.isnan(value) for value in values.values())
    assert faults == []


NUMBERS = st.one_of(st.floats(-10.0, 10.0), st.floats())


@settings(max_examples=150, deadline=None)
@given(rows=st.lists(st.tuples(*[NUMBERS] * 8), min_size=1, max_size=25))
def test_any_recorded_numbers_give_finite_values_or_nan(rows: list[tuple[float, ...]]) -> None:
    data = np.array(rows)
    obstacle = {"name": "pillar", "shape": "circle", "radius": 0.5, "position": [1.0, 1.0]}
    columns = {"clearance_m": data[:, 6], "solver_wall_ms": data[:, 7]}
    with np.errstate(all="ignore"):  # the making of the columns, not the KPIs
        trial = make_trial(
            make_problem(obstacles=[obstacle], dt=0.1),
            data[:, :2],
            qd=data[:, 2:4],
            action=data[:, 4:6],
            columns=columns,
        )
    for entry in load_builtin():
        value_of(entry, trial)


def test_the_checks_find_kpis_that_break_the_rules() -> None:
    wrong = Registry()
    wrong.kpi("summed_m", "m", "lower", "all")(lambda trajectory: trajectory.link("body")[:, 0].sum())
    wrong.kpi("leftmost_m", "m", "lower", "all")(lambda trajectory: trajectory.link("body")[:, 0].min())
    wrong.kpi("reached_s", "s", "lower", "all")(
        lambda trajectory: -1.0 if trajectory.goal_row is None else trajectory.t[trajectory.goal_row]
    )
    summed, leftmost, reached = wrong
    with pytest.raises(AssertionError):
        check_step(summed, PLACEABLE[0])
    with pytest.raises(AssertionError):
        check_frame(leftmost, PLACEABLE[0], Placement(x=3.0))
    with pytest.raises(AssertionError):
        check_degenerate(reached, nothing_happens)
