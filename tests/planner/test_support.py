"""What planners declare to support: which robots are left out, and every wrong declaration by its text."""

# ruff: noqa: E501 - tables of one case a line

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.far.support import NO_REASON, refusal
from pytest_lpb.planner.files import find_planners
from pytest_lpb.planner.support import checked_support, why_unsupported

ARM = {"name": "planar_arm_3", "model": "planar_arm", "base": "fixed", "control": "velocity"}


@pytest.mark.parametrize(
    ("declared", "reason"),
    [
        ({}, ""),
        ({"robots": "planar_arm"}, ""),
        ({"robots": ["panda", "planar_arm_*"], "control": {"velocity"}}, ""),
        ({"robots": ["planer_arm_3", "point"]}, "it supports robots planer_arm_3, point, and this one is planar_arm_3; did you mean 'planer_arm_3'?"),
        ({"base": ("holonomic", "bicycle")}, "it supports base holonomic, bicycle, and this is fixed"),
        ({"base": "fixed", "control": ["torque"]}, "it supports control torque, and this is velocity"),
    ],
)  # fmt: skip
def test_a_declaration_leaves_robots_out(declared: Any, reason: str) -> None:
    assert why_unsupported(checked_support(declared, "here"), ARM) == reason


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        ({"robot": ["panda"]}, "here: robot: unknown key; did you mean 'robots'?; allowed: base, control, robots"),
        ({"control": ["velocty"]}, "here: control: unknown value 'velocty'; did you mean 'velocity'?; allowed: acceleration, torque, velocity"),
        ({"base": "differential"}, "here: base: unknown value 'differential'; did you mean 'differential_drive'?; allowed: bicycle"),
        ({"robots": [3]}, "here: robots: unknown value 3; allowed: names"),
        ({"robots": []}, "here: robots: found []; a name or a list of names is needed"),
        (["panda"], "here: found ['panda']; a mapping such as"),
    ],
)  # fmt: skip
def test_wrong_declarations(declared: Any, message: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        checked_support(declared, "here")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("answer", "reason"),
    [(True, ""), (np.True_, ""), (False, NO_REASON), (np.False_, NO_REASON), (" needs meshes ", "needs meshes")],
)
def test_answers_of_a_method(answer: Any, reason: str) -> None:
    assert refusal(SimpleNamespace(supports=lambda problem: answer), None) == reason


@pytest.mark.parametrize("answer", [None, "", 1, ["panda"]])
def test_other_answers_are_errors(answer: Any) -> None:
    with pytest.raises(TypeError, match="allowed: True, False, or the reason as text"):
        refusal(SimpleNamespace(supports=lambda problem: answer), None)


@pytest.mark.parametrize("name", ["pd", "potential_field", "fabrics", "mpc"])
def test_shipped_planners_know_no_torques(name: str) -> None:
    (planner,) = find_planners([name], [])
    assert not planner.unsupported(ARM)
    assert planner.unsupported({**ARM, "control": "torque"}) == (
        "it supports control acceleration, velocity, and this is torque"
    )
    assert planner.to_dict()["supports"] == [{"control": ["acceleration", "velocity"]}, {}]
