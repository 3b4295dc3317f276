"""The outcomes of a trial, exactly one each (definitions: docs/kpis.md)."""

SUCCESS = "success"
PLANNER_ERROR = "planner_error"
ENVIRONMENT_ERROR = "environment_error"
INFEASIBLE = "infeasible"
DEADLINE = "deadline"
WORKER_CRASH = "worker_crash"

OUTCOMES = (
    SUCCESS,
    "collision",
    "self_collision",
    "joint_limit",
    "timeout",
    "stalled",
    PLANNER_ERROR,
    INFEASIBLE,
    DEADLINE,
    WORKER_CRASH,
    ENVIRONMENT_ERROR,
)

# Faults of the software, not of the plan: with --lpb-assert=none these alone fail an item.
SOFTWARE_FAULTS = (PLANNER_ERROR, DEADLINE, ENVIRONMENT_ERROR)
