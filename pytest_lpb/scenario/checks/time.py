"""Checks of the engine, the clock, and how much there is to compute."""

from collections.abc import Iterator
from pathlib import Path

from pytest_lpb.documents.faults import Fault
from pytest_lpb.names import is_name
from pytest_lpb.scenario.schema.available import simulates_forces
from pytest_lpb.scenario.schema.environment import MAX_STEPS, Environment
from pytest_lpb.scenario.schema.file import Certified
from pytest_lpb.scenario.schema.obstacle import MAX_OBSTACLES, Obstacle
from pytest_lpb.scenario.schema.randomize import Randomize
from pytest_lpb.scenario.schema.success import MAX_SEED, Success

MAX_ROWS_OF_OBSTACLES = 50_000_000
_MULTIPLE = 1e-6  # [steps] a duration may miss a multiple of dt by


def check_engine(environment: Environment) -> Iterator[Fault]:
    """The engine can simulate what is asked for."""
    if environment.dynamics and not simulates_forces(environment.engine):
        yield Fault(
            ("environment", "dynamics"),
            f"true is not available with the engine {environment.engine}; allowed: false",
        )
    if environment.substeps is not None and not environment.dynamics:
        yield Fault(("environment", "substeps"), "has no meaning without dynamics: true")


def check_steps(environment: Environment) -> Iterator[Fault]:
    """The duration is a whole number of steps, and not too many."""
    place = ("environment", "duration")
    steps = environment.duration / environment.dt
    if steps > MAX_STEPS + 0.5:
        yield Fault(
            place,
            f"{environment.duration:g} s in steps of {environment.dt:g} s are {steps:.0f} steps; "
            f"allowed are at most {MAX_STEPS}",
        )
    elif round(steps) < 1 or abs(steps - round(steps)) > _MULTIPLE:
        nearest = max(round(steps), 1) * environment.dt
        yield Fault(
            place,
            f"{environment.duration:g} s is not a multiple of dt = {environment.dt:g} s; the nearest is {nearest:g}",
        )


def check_rows(environment: Environment, obstacles: list[Obstacle], randomize: Randomize | None) -> Iterator[Fault]:
    """The number of obstacles, drawn ones included, and of their recorded positions is bounded."""
    drawn = sum(group.count[1] for group in (randomize.obstacles or ())) if randomize else 0
    total = len(obstacles) + drawn
    place = ("randomize", "obstacles") if drawn else ("obstacles",)
    if total > MAX_OBSTACLES:
        yield Fault(
            place,
            f"{len(obstacles)} listed and up to {drawn} drawn obstacles; allowed are {MAX_OBSTACLES} in total",
        )
    rows = environment.duration / environment.dt + 1
    if rows * total > MAX_ROWS_OF_OBSTACLES:
        yield Fault(
            place,
            f"{total} obstacles over {rows:.0f} rows are {rows * total:.3g} recorded positions; "
            f"allowed are {MAX_ROWS_OF_OBSTACLES:.0e}",
        )


def check_hold_time(success: Success, environment: Environment) -> Iterator[Fault]:
    """The goal can be held for the hold time within the duration."""
    if isinstance(success.hold_time, float) and success.hold_time > environment.duration:
        yield Fault(
            ("success", "hold_time"),
            f"found {success.hold_time:g} s; allowed: at most the duration, {environment.duration:g} s",
        )


def check_criteria(success: Success) -> Iterator[Fault]:
    """Further keys of `success` may name KPIs; which KPIs there are is known later."""
    for key in success.model_extra or {}:
        if not is_name(key):
            yield Fault(("success", key), "is no name of a KPI; allowed: hold_time, rate, and names of KPIs")


def check_seeds(seed: int, trials: int) -> Iterator[Fault]:
    """The last seed is in range too."""
    if seed + trials - 1 > MAX_SEED:
        yield Fault(("seed",), f"{trials} trials from seed {seed} go beyond the largest seed, {MAX_SEED}")


def check_certified(certified: Certified | None) -> Iterator[Fault]:
    """The certified path is there."""
    if certified is not None and certified.path is not None and not Path(certified.path).is_file():
        yield Fault(("certified", "path"), f"there is no file {certified.path}")
