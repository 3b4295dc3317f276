"""Where the numbers come from: machine, versions, command, parameters."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import finite, show, show_exact
from pytest_lpb.report.view import Fact, PlannerSetup, PlannerStyle, Provenance
from pytest_lpb.run.title import title_of

HASH_DIGITS = 12


def run_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> Provenance:
    """What run.json says, in words."""
    return provenance(data.run_info, styles)


def provenance(run_info: Mapping[str, Any], styles: Mapping[str, PlannerStyle]) -> Provenance:
    """What run.json says, in words."""
    planners = run_info.get("planners") or {}
    return Provenance(
        facts=[Fact(name, text) for name, text in _facts(run_info) if text],
        planners=[_setup(styles[name], entry) for name, entry in planners.items() if name in styles],
        packages=[Fact(str(name), str(text)) for name, text in sorted((run_info.get("packages") or {}).items())],
        scenarios=[
            Fact(str(key), f"{entry.get('file', '')} · {str(entry.get('hash', ''))[:HASH_DIGITS]}")
            for key, entry in sorted((run_info.get("scenarios") or {}).items())
        ],
    )


def command_line(run_info: Mapping[str, Any]) -> str:
    """The command as it can be typed again."""
    command = run_info.get("command") or ""
    return command if isinstance(command, str) else shlex.join(str(word) for word in command)


def moment(text: Any) -> str:
    """A point in time from ISO 8601, such as `2026-11-22 12:15 UTC`; any other text as it is."""
    try:
        found = datetime.fromisoformat(str(text))
    except ValueError:
        return str(text or "")
    return f"{found:%Y-%m-%d %H:%M} {found.tzname() or ''}".rstrip()


def safe_json(value: Any) -> str:
    """A value as JSON text; NaN and infinities are null, what JSON does not know is text."""
    return json.dumps(_plain(value), allow_nan=False, indent=2, sort_keys=True, ensure_ascii=False)


def _facts(run_info: Mapping[str, Any]) -> list[tuple[str, str]]:
    machine = run_info.get("machine") or {}
    git = run_info.get("git") or {}
    commit = str(git.get("commit") or "")[:HASH_DIGITS]
    memory = finite(machine.get("memory_gib"))
    return [
        ("title", title_of(run_info)),
        ("command", command_line(run_info)),
        ("started", moment(run_info.get("started"))),
        ("seeds", _seeds(run_info.get("seeds"))),
        ("drawn at random", ", ".join(str(part) for part in run_info.get("random") or ())),
        ("workers", str(run_info.get("workers") or "")),
        ("processor", str(machine.get("cpu") or "")),
        ("cores", str(machine.get("cores") or "")),
        ("memory", "" if memory is None else f"{show(memory)} GiB"),
        ("system", str(machine.get("system") or "")),
        ("Python", str(machine.get("python") or "")),
        ("git commit", commit + (" with uncommitted changes" if commit and git.get("dirty") else "")),
    ]


def _setup(style: PlannerStyle, entry: Mapping[str, Any]) -> PlannerSetup:
    facts = [
        ("period", _seconds(entry.get("period"))),
        ("delay", _seconds(entry.get("delay"))),
        ("parameters' hash", str(entry.get("parameters_hash") or "")[:HASH_DIGITS]),
        ("source hash", str(entry.get("source_hash") or "")[:HASH_DIGITS]),
    ]
    return PlannerSetup(
        style=style,
        planner=str(entry.get("planner") or ""),
        parameters=safe_json(_parameters(entry)),
        facts=[Fact(name, text) for name, text in facts if text],
    )


def _parameters(entry: Mapping[str, Any]) -> dict[str, Any]:
    per_robot = entry.get("per_robot")
    return dict(entry.get("parameters") or {}) | ({"per_robot": per_robot} if per_robot else {})


def _seconds(value: Any) -> str:
    return "" if finite(value) is None else f"{show_exact(value)} s"


def _seeds(seeds: Any) -> str:
    if isinstance(seeds, Sequence) and not isinstance(seeds, str) and seeds:
        numbers = sorted(int(seed) for seed in seeds)
        if numbers == list(range(numbers[0], numbers[-1] + 1)) and len(numbers) > 1:
            return f"{numbers[0]}–{numbers[-1]}"
        return ", ".join(str(number) for number in numbers)
    if isinstance(seeds, Mapping):
        first, trials = seeds.get("first"), seeds.get("trials")
        told = [] if trials is None else [f"{trials} in each scenario"]
        return ", ".join([*told, *([] if first is None else [f"from {first} on"])])
    return "" if seeds is None else str(seeds)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, bool | str) or value is None:
        return value
    if isinstance(value, int):
        return value
    return finite(value) if isinstance(value, float) or hasattr(value, "dtype") else str(value)
