"""Every combination of a sweep's values, with a name for each."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.study.change import Change
from pytest_lpb.study.family import FileFamily

MAX_VARIANTS = 1_000


def combinations(values: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Every combination of one value each, the last parameter changing fastest."""
    found = [dict(zip(values, chosen, strict=True)) for chosen in product(*values.values())]
    if len(found) > MAX_VARIANTS:
        raise ConfigurationError(f"sweep: {len(found)} combinations; at most {MAX_VARIANTS} are allowed")
    return found


def suffix(values: Mapping[str, Any]) -> str:
    """What a variant's name ends with, such as `_horizon-20_step-0.1`."""
    return "".join(f"_{_safe(name)}-{_safe(_text(value))}" for name, value in values.items())


def _text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _safe(text: str) -> str:
    """Text as part of a name; a minus sign stays."""
    sign = "-" if re.match(r"-[\d.]", text) else ""
    return sign + re.sub(r"[^A-Za-z0-9_.-]+", "-", text).strip("-")


def planner_variants(
    planner: PlannerConfiguration, values: Mapping[str, Sequence[Any]]
) -> Iterator[PlannerConfiguration]:
    """A planner with every combination of parameters; what it has for single robots does not override them.

    Raises ConfigurationError for parameters that the planner does not have.
    """
    for chosen in combinations(values):
        per_robot = {
            robot: {name: value for name, value in own.items() if name not in chosen}
            for robot, own in planner.per_robot.items()
        }
        variant = replace(
            planner,
            name=f"{planner.name}{suffix(chosen)}",
            parameters={**planner.parameters, **chosen},
            per_robot=per_robot,
        )
        variant.check()
        yield variant


def scenario_variants(family: FileFamily, values: Mapping[str, Sequence[Any]], place: str) -> Iterator[FileFamily]:
    """A scenario with every combination of knobs, which messages find at a `place`."""
    for chosen in combinations(values):
        changes = [Change(name, value, place) for name, value in chosen.items()]
        yield FileFamily(f"{family.key}{suffix(chosen)}", family.path, changes, family.key)
