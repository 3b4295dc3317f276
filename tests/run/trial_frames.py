"""Trial tables for tests, as the evaluation of a run would give them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Column:
    """A KPI as the tables see it."""

    name: str
    unit: str = "m"
    direction: str = "lower"
    over: str = "all"
    timing: bool = False
    restricted_to_duration: bool = False


LENGTH = Column("path_length_m", over="solved")
CLEARANCE = Column("clearance_min_m", direction="higher")
TIME = Column("time_to_goal_s", unit="s", restricted_to_duration=True)
SOLVER = Column("solver_time_p50_ms", unit="ms", timing=True)
ACTION = Column("action_total_variation", unit="", direction="none", over="solved")
KPIS = [LENGTH, CLEARANCE, TIME, SOLVER, ACTION]


def trial(
    scenario: str = "s", planner: str = "a", seed: int = 0, *, success: bool = True, **columns: object
) -> dict[str, object]:
    """One trial's row; `columns` overrides any column and adds KPIs."""
    return {
        "node_id": f"scenarios/{scenario}.yaml::{planner}::seed{seed}",
        "scenario": scenario,
        "planner": planner,
        "seed": seed,
        "outcome": "success" if success else "timeout",
        "success": success,
        "failed_criteria": "",
        "steps": 100,
        "problem_hash": f"{scenario}-{seed}",
        "trajectory_hash": f"{scenario}-{planner}-{seed}",
        "wall_s": 1.0,
        "attempt": 1,
        "timing_contended": False,
        "duration_s": 25.0,
        **columns,
    }


def random_trials(
    planners: Sequence[str] = ("a", "b"),
    scenarios: Sequence[str] = ("s1", "s2"),
    seeds: int = 12,
    kpis: Sequence[Column] = KPIS,
    rng_seed: int = 0,
    rate: float = 0.7,
) -> pd.DataFrame:
    """Trials in which no planner is better than another: the problem's difficulty times a planner's noise."""
    rng = np.random.default_rng(rng_seed)
    rows = []
    for scenario in scenarios:
        difficulty = rng.lognormal(size=(seeds, len(kpis)))
        for planner in planners:
            values = difficulty * rng.lognormal(sigma=0.3, size=difficulty.shape)
            solved = rng.random(seeds) < rate
            for seed in range(seeds):
                figures = dict(zip([kpi.name for kpi in kpis], values[seed].tolist(), strict=True))
                if not solved[seed] and TIME in kpis:
                    figures[TIME.name] = np.nan
                rows.append(trial(scenario, planner, seed, success=bool(solved[seed]), **figures))
    return pd.DataFrame(rows)
