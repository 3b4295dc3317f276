import pytest

from pytest_lpb.kpis.units import same_unit, unit_of_name


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("path_length_m", "m"),
        ("setup_ms", "ms"),
        ("final_goal_error_rad", "rad"),
        ("curvature_max_per_m", "1/m"),
        ("jerk_rms_m_per_s3", "m/s^3"),
        ("speed_m_per_s", "m/s"),
        ("area_m2", "m^2"),
        ("per_m", None),
        ("m", None),
        ("ldj", None),
        ("saturated_steps", None),
        ("clearance_min", None),
        ("goals_per_hour", None),
    ],
)
def test_unit_that_a_name_ends_with(name: str, unit: str | None) -> None:
    assert unit_of_name(name) == unit


@pytest.mark.parametrize("spelling", ["m/s^3", "m/s3", "m/s³", "m / s^3"])
def test_spellings_of_one_unit(spelling: str) -> None:
    assert same_unit(spelling, "m/s^3")
    assert not same_unit(spelling, "m/s^2")


def test_hertz_in_a_name_may_be_small() -> None:
    assert same_unit(unit_of_name("rate_hz") or "", "Hz")


def test_case_tells_units_apart() -> None:
    assert not same_unit("N", "n")
    assert not same_unit("Mm", "mm")
