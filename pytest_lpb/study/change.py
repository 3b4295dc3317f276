"""Changes of a scenario that a sweep asks for: the value at a key path, or a knob that has a meaning everywhere."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from pytest_lpb.errors import ScenarioError
from pytest_lpb.scenario.schema.values import is_number

Data = dict[str, Any]
_TIME = re.compile(r"\bt\b")
_STEP = re.compile(r"^(?P<key>[A-Za-z_]\w*)(?P<indices>(\[\d+\])*)$")


@dataclass(frozen=True)
class Change:
    """A value of a knob, or at a key path such as `robot.body_radius` or `obstacles[0].radius`."""

    name: str
    value: Any
    place: str = ""  # where a study says so

    def apply(self, data: Data) -> Data:
        """A scenario file's content with the change. Raises ScenarioError where it cannot be made."""
        changed = copy.deepcopy(data)
        knob = KNOBS.get(self.name)
        try:
            if knob is None:
                _set(changed, self.name, copy.deepcopy(self.value))
            else:
                knob(changed, self.value)
        except (AttributeError, IndexError, KeyError, TypeError) as error:
            raise ScenarioError(
                f"{self.name}: this scenario has no such place; write a key path of the file, "
                f"such as robot.body_radius or randomize.obstacles.count, or one of {', '.join(KNOBS)}"
            ) from error
        return changed


def check_name(name: str) -> str:
    """A knob's name or a key path. Raises ScenarioError for anything else."""
    if name not in KNOBS and not all(_STEP.match(step) for step in name.split(".")):
        raise ScenarioError(f"found {name!r}; a key path such as obstacles[0].radius, or one of {', '.join(KNOBS)}")
    return name


def _set(data: Data, path: str, value: Any) -> None:
    steps: list[str | int] = []
    for part in path.split("."):
        match = _STEP.match(part)
        assert match is not None, "check_name has seen it"
        steps += [match["key"], *(int(index) for index in re.findall(r"\d+", match["indices"]))]
    place: Any = data
    for step, after in pairwise(steps):
        # A mapping that the file leaves out has its defaults: the key path may begin it.
        place = place.setdefault(step, {}) if isinstance(after, str) and isinstance(place, dict) else place[step]
    last = steps[-1]
    if isinstance(place, dict) != isinstance(last, str):
        raise KeyError(last)
    place[last] = value


def _groups(data: Data) -> list[Data]:
    """Groups of drawn obstacles, in the file's own data."""
    groups = data.get("randomize", {}).get("obstacles", [])
    return groups if isinstance(groups, list) else [groups]


def _obstacle_count(data: Data, value: Any) -> None:
    groups = _groups(data)
    if not groups:
        raise ScenarioError("obstacle_count: this scenario draws no obstacles (randomize: obstacles)")
    if len(groups) == 1:
        groups[0]["count"] = value
    else:
        for group, count in zip(groups, _shares(value, [_mean_count(group) for group in groups]), strict=True):
            group["count"] = count
    drawn = data["randomize"].setdefault("draw", [])
    if "obstacles" not in drawn:
        drawn.append("obstacles")


def _mean_count(group: Data) -> float:
    count = group["count"]
    return sum(count) / len(count) if isinstance(count, list) else float(count)


def _shares(total: Any, weights: list[float]) -> list[int]:
    """A number split over groups in proportion, whole (largest remainders first)."""
    if type(total) is not int:
        raise ScenarioError(f"obstacle_count: found {total!r}; with several groups a whole number is required")
    exact = [total * weight / (sum(weights) or 1.0) for weight in weights]
    shares = [int(share) for share in exact]
    order = sorted(range(len(exact)), key=lambda index: shares[index] - exact[index])
    for index in order[: total - sum(shares)]:
        shares[index] += 1
    return shares


def _obstacle_speed(data: Data, value: Any) -> None:
    factor = _number("obstacle_speed_factor", value, least=0.0)
    for obstacle in data.get("obstacles", []):
        if "trajectory" in obstacle:
            obstacle["trajectory"] = [_faster(expression, factor) for expression in obstacle["trajectory"]]
        if "spline" in obstacle:
            _faster_spline(obstacle, factor)
        turn = obstacle.get("orientation")
        if isinstance(turn, str):
            obstacle["orientation"] = _faster(turn, factor)
        elif isinstance(turn, dict) and isinstance(turn.get("angle"), str):
            turn["angle"] = _faster(turn["angle"], factor)
    for group in _groups(data):
        if group.get("velocity") is not None:
            group["velocity"] = [[factor * bound for bound in pair] for pair in group["velocity"]]


def _faster(expression: Any, factor: float) -> Any:
    return _TIME.sub(f"({factor!r} * t)", expression) if isinstance(expression, str) else expression


def _faster_spline(obstacle: Data, factor: float) -> None:
    rows = obstacle["spline"]
    if factor > 0.0:
        obstacle["spline"] = [[row[0] / factor, *row[1:]] for row in rows]
        return
    # Nothing moves any more: where it was at the first row.
    obstacle.pop("spline")
    obstacle.pop("periodic", None)
    obstacle["position"] = list(rows[0][1:])


def _clearance(data: Data, value: Any) -> None:
    change = _number("clearance_change_m", value)
    for obstacle in data.get("obstacles", []):
        _shrink(obstacle, change)
    for group in _groups(data):
        _shrink(group, change)


def _shrink(obstacle: Data, change: float) -> None:
    """Take so much [m] off each side; lengths of capsules and cylinders stay, their radii change."""
    if "radius" in obstacle:
        obstacle["radius"] = _less(obstacle["radius"], change)
    elif "size" in obstacle:
        obstacle["size"] = [_less(size, 2.0 * change) for size in obstacle["size"]]
    else:
        raise ScenarioError(f"clearance_change_m: an obstacle of shape {obstacle.get('shape')!r} has no radius or size")


def _less(size: Any, change: float) -> Any:
    return [part - change for part in size] if isinstance(size, list) else size - change


def _number(name: str, value: Any, least: float | None = None) -> float:
    if not is_number(value) or (least is not None and value < least):
        raise ScenarioError(
            f"{name}: found {value!r}; a number{'' if least is None else f' of at least {least:g}'} is required"
        )
    return float(value)


# Knobs: what they do to a scenario file's content.
KNOBS: Mapping[str, Callable[[Data, Any], None]] = {
    "obstacle_count": _obstacle_count,  # a number, or [fewest, most]: of the one group of drawn obstacles
    "obstacle_speed_factor": _obstacle_speed,  # by which obstacles move faster; 0: they stand still
    "clearance_change_m": _clearance,  # [m] by which obstacles are smaller on every side; negative: larger
}
