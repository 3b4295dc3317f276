"""The gate's verdicts as text for the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_lpb.aligned import aligned
from pytest_lpb.names import count
from pytest_lpb.report.numbers import finite
from pytest_lpb.report.titles import compared_name
from pytest_lpb.run.gate import INCONCLUSIVE, MIN_PROBLEMS, REGRESSED, GateResult, GateVerdict
from pytest_lpb.run.gate_pairs import Change, LeftOut
from pytest_lpb.run.margins import Margin

HEADS = ("planner", "kpi", "problems", "baseline", "now", "loss", "95 % bounds", "margin", "verdict")
MAX_CHANGES = 10  # lines of problems that a verdict prints
MAX_LEFT_OUT = 5  # problems that are named


def gate_lines(result: GateResult) -> Iterator[str]:
    """Table of verdicts, why some are inconclusive, what was not compared, what changed and how to repeat it."""
    yield f"regression gate, baseline {result.baseline}"
    yield from aligned([HEADS, *map(verdict_cells, result.verdicts)])
    yield from notes(result)
    for verdict in result.verdicts:
        if verdict.verdict == INCONCLUSIVE:
            yield f"inconclusive: {subject(verdict)}: {doubt(verdict)}"
    yield from left_out_lines(result)
    for verdict in result.verdicts:
        if verdict.verdict == REGRESSED:
            yield from ("", *change_lines(verdict))


def notes(result: GateResult) -> Iterator[str]:
    """What the table's figures are, where that is not plain."""
    if any(verdict.margin.kpi is None for verdict in result.verdicts):
        yield "pp: percentage points, what two success rates differ by"
    restricted = [kpi for verdict in result.verdicts if (kpi := verdict.margin.kpi) and kpi.restricted_to_duration]
    yield from (compared_name(kpi) for kpi in dict.fromkeys(restricted))


def verdict_cells(verdict: GateVerdict) -> tuple[str, ...]:
    """One verdict as cells under HEADS."""
    margin = verdict.margin
    low, high = verdict.loss_low, verdict.loss_high
    known = finite(low) is not None and finite(high) is not None
    return (
        verdict.planner if verdict.planner == verdict.baseline else f"{verdict.planner} (was {verdict.baseline})",
        margin.name,
        str(verdict.problems),
        value_text(margin, verdict.old),
        value_text(margin, verdict.new),
        "-" if finite(verdict.loss) is None else margin.text(verdict.loss),
        margin.text(low, high) if known else "-",
        margin.text(margin.value),
        verdict.verdict,
    )


def value_text(margin: Margin, value: float) -> str:
    """A value in the KPI's unit; of success, the rate."""
    if finite(value) is None:
        return "-"
    if margin.kpi is None:
        return f"{100 * value:.3g} %"
    return f"{value:.4g} {margin.kpi.unit if margin.kpi.unit != '1' else ''}".rstrip()


def subject(verdict: GateVerdict) -> str:
    """Planner and KPI of a verdict."""
    return f"{verdict.planner}, {verdict.margin.name}"


def doubt(verdict: GateVerdict) -> str:
    """Why a verdict is inconclusive, and what would decide."""
    if verdict.further_seeds is not None:
        least = "at least " if verdict.problems < MIN_PROBLEMS else "about "
        seeds = count(verdict.further_seeds, "further seed")
        return f"{verdict.reason}; {least}{seeds} per scenario would decide, in the baseline too"
    return f"{verdict.reason}{'; further seeds would not decide' if verdict.problems else ''}"


def left_out_lines(result: GateResult) -> Iterator[str]:
    """Problems and planners that were not compared, and values that the baseline lacks."""
    for planner, left_out in result.left_out.items():
        for kind, problems in left_out_problems(left_out):
            yield f"not compared: {planner}: {kind}: {problems}"
    for planner in result.unknown:
        yield f"not compared: {planner}: the baseline does not know this planner"
    for warning in result.warnings:
        yield f"warning: baseline: {warning}"


def left_out_problems(left_out: LeftOut) -> Iterator[tuple[str, str]]:
    """What kind of problems are left out, and which."""
    kinds = (
        ("only in the baseline", left_out.missing),
        ("not in the baseline", left_out.new),
        ("another problem than in the baseline", left_out.changed),
    )
    for kind, problems in kinds:
        if problems:
            yield kind, _named(problems)


def _named(problems: Sequence[tuple[str, int]]) -> str:
    named = ", ".join(f"{scenario} seed{seed}" for scenario, seed in problems[:MAX_LEFT_OUT])
    return f"{named} and {len(problems) - MAX_LEFT_OUT} more" if len(problems) > MAX_LEFT_OUT else named


def change_lines(verdict: GateVerdict) -> Iterator[str]:
    """The problems of a regressed KPI that got worse, the worst first, each with the command that repeats it."""
    yield f"regressed: {subject(verdict)}: worse on {len(verdict.changes)} of {count(verdict.problems, 'problem')}"
    for change in verdict.changes[:MAX_CHANGES]:
        old, new = change_texts(verdict.margin, change)
        yield f"  {change.scenario} seed{change.seed}: {old} -> {new}   {change.command}"
    if len(verdict.changes) > MAX_CHANGES:
        yield f"  ... and {len(verdict.changes) - MAX_CHANGES} more"


def change_texts(margin: Margin, change: Change) -> tuple[str, str]:
    """A problem's old and new value; where success is lost, how the trial ended."""
    if margin.kpi is None:
        return "success", "criteria_failed" if change.outcome == "success" else change.outcome
    return value_text(margin, change.old), value_text(margin, change.new)


def conclusion(result: GateResult) -> str:
    """What the verdicts mean for the run, in one line."""
    regressed, inconclusive = result.count(REGRESSED), result.count(INCONCLUSIVE)
    if regressed:
        return f"GATE CLOSED: {_verdicts(regressed)} regressed"
    if not inconclusive:
        return "gate open: same or better in all that was asked"
    if result.inconclusive_fails:
        return f"GATE CLOSED: {_verdicts(inconclusive)} inconclusive"
    return f"GATE OPEN, BUT NOT SURE: {_verdicts(inconclusive)} inconclusive (inconclusive=fail would close it)"


def _verdicts(number: int) -> str:
    return count(number, "verdict")
