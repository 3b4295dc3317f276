"""`--lpb-fail-on`: what may be written, and what is said of the rest."""

from __future__ import annotations

import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.run.margins import DEFAULT_MARGINS, Margin, parse_margins


def parse(*texts: str) -> list[Margin]:
    return parse_margins(texts, load_builtin(), "--lpb-fail-on")


def test_percentages_and_numbers_with_units() -> None:
    success, time, clearance, misses = parse(
        "success:2%", " time_to_goal_s : 10 %", "clearance_min_m:1e-2m", "deadline_miss_rate:0.05"
    )
    assert (success.kpi, success.value, success.unit, success.relative) == (None, 0.02, "%", False)
    assert (time.name, time.value, time.unit, time.relative) == ("time_to_goal_s", 0.1, "%", True)
    assert (clearance.value, clearance.unit, clearance.relative) == (0.01, "m", False)
    assert (misses.value, misses.unit) == (0.05, "")
    assert [margin.text(margin.value) for margin in (success, time, clearance, misses)] == [
        *("2 pp", "10 %", "0.01 m", "0.05")
    ]


def test_other_spellings_of_a_unit_and_of_zero() -> None:
    jerk, length = parse("jerk_rms_m_per_s3:.5m/s³", "path_length_m:0%")
    assert (jerk.value, jerk.unit, length.value) == (0.5, "m/s^3", 0.0)


def test_the_default_is_one_of_them() -> None:
    (margin,) = parse(DEFAULT_MARGINS)
    assert (margin.name, margin.value) == ("success", 0.05)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_to_gaol_s:10%", "unknown KPI 'time_to_gaol_s'; did you mean 'time_to_goal_s'"),
        ("succes:10%", "unknown KPI 'succes'; did you mean 'success'"),
        ("time_to_goal_s", "found 'time_to_goal_s'; allowed is KPI:MARGIN"),
        ("time_to_goal_s:much", "found 'time_to_goal_s:much'; allowed is KPI:MARGIN"),
        ("time_to_goal_s:nan%", "allowed is KPI:MARGIN"),
        ("time_to_goal_s:1e999%", "a margin is 0 or above"),
        ("time_to_goal_s:-1%", "time_to_goal_s: found -1%; a margin is 0 or above"),
        ("time_to_goal_s:0.5m", "found 0.5m; allowed are 0.5s (its own unit) and 0.5% (of the baseline's mean)"),
        ("time_to_goal_s:0.5", "found 0.5; allowed are 0.5s"),
        ("spl:0.1m", "spl: found 0.1m; allowed are 0.1 (its own unit)"),
        ("success:0.02", "success: found 0.02; allowed are percentage points, such as 2%"),
        ("curvature_max_per_m:1", "allowed are 1 1/m (its own unit)"),
        ("action_total_variation:3m/s", "its unit depends on the control mode: write 3%"),
    ],
)
def test_what_is_refused(text: str, message: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse(text)
    assert str(caught.value).startswith("--lpb-fail-on: ")
    assert message in str(caught.value)


def test_a_kpi_without_direction_or_twice_and_none_at_all() -> None:
    from tests.run.trial_frames import ACTION

    with pytest.raises(ConfigurationError, match="has no direction"):
        parse_margins([f"{ACTION.name}:10%"], [ACTION], "--fail-on")
    with pytest.raises(ConfigurationError, match="success has two margins"):
        parse("success:2%", "success:3%")
    with pytest.raises(ConfigurationError, match="found no margin; write KPI:MARGIN, such as success:5%"):
        parse()


def test_all_faults_at_once() -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse("succes:10%", "time_to_goal_s:-1%")
    assert len(str(caught.value).splitlines()) == 2
