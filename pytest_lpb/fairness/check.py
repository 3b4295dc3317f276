"""Runs a sample of a run's trials again: alone, in reverse order, and with scenes that are moved."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor

from pytest_lpb.fairness.canary import GOAL, OBSTACLES
from pytest_lpb.fairness.job import MOVE, RUN, Answers, Job
from pytest_lpb.fairness.process import Processes
from pytest_lpb.fairness.result import Fairness
from pytest_lpb.fairness.sample import sample
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.plan import TrialKey
from pytest_lpb.run.reproduce import HASHES

Recorded = Mapping[TrialKey, Mapping[str, object]]  # hashes and outcomes of a run's trials


def check_fairness(run: RunFolder, per_planner: int, at_once: int) -> Fairness:
    """Check a run whose trials are finished.

    Args:
        run: the run folder.
        per_planner: trials of each planner to run again.
        at_once: processes to have at the same time.

    Raises RecordingError for trial files that cannot be read. When it is interrupted, its processes are ended.
    """
    recorded = {key: {name: metadata[name] for name in HASHES} for key, metadata in sample(run, per_planner).items()}
    processes = Processes()
    with ThreadPoolExecutor(at_once) as pool:
        try:
            return _checked(pool, processes, run, recorded)
        except BaseException:
            # Otherwise the pool would wait for all that it has been given: for ever, for a planner that hangs.
            pool.shutdown(wait=False, cancel_futures=True)
            processes.stop()
            raise


def _checked(pool: Executor, processes: Processes, run: RunFolder, recorded: Recorded) -> Fairness:
    """What comes out when trials are run again."""
    keys = list(recorded)
    scenes = list({(key.planner, key.scenario): key for key in keys}.values())
    # The two with many trials begin first.
    backwards = pool.submit(processes.have_done, Job(run.path, RUN, keys[::-1]))
    moved = pool.submit(processes.have_done, Job(run.path, MOVE, scenes))
    alone = _alone(pool, processes, run, keys)
    orders = (alone.by_trial, backwards.result().by_trial)
    differing = [key for key in keys if any(order.get(key, recorded[key]) != recorded[key] for order in orders)]
    again = _alone(pool, processes, run, differing)
    random = [key for key in differing if again.by_trial.get(key) != alone.by_trial.get(key)]
    reactions = moved.result()
    unanswered = alone.missing | backwards.result().missing
    return Fairness(
        trials=dict(Counter(key.planner for key in keys)),
        random=[_shown(key) for key in random],
        dependent=[_shown(key) for key in differing if key not in random],
        unanswered={_shown(key): said for key, said in unanswered.items()}
        | {f"{_shown(key)}, its scene moved,": said for key, said in reactions.missing.items()},
        blind=_scenarios(reactions, lambda goal, obstacles: goal is False and obstacles is not True),
        goal_unseen=_scenarios(reactions, lambda goal, obstacles: goal is False and obstacles is True),
        obstacles_unseen=_scenarios(reactions, lambda goal, obstacles: goal is not False and obstacles is False),
    )


def _alone(pool: Executor, processes: Processes, run: RunFolder, keys: Sequence[TrialKey]) -> Answers:
    """Each trial in a process of its own."""
    done = list(pool.map(processes.have_done, [Job(run.path, RUN, [key]) for key in keys]))
    return Answers(
        {key: answer for answers in done for key, answer in answers.by_trial.items()},
        {key: reason for answers in done for key, reason in answers.missing.items()},
    )


def _scenarios(reactions: Answers, concerned: Callable[[bool | None, bool | None], bool]) -> dict[str, list[str]]:
    """Scenarios by planner, of those whose reactions to a moved goal and to moved obstacles concern us."""
    found: dict[str, list[str]] = {}
    for key, sees in reactions.by_trial.items():
        if concerned(sees[GOAL], sees[OBSTACLES]):
            found.setdefault(key.planner, []).append(key.scenario)
    return found


def _shown(key: TrialKey) -> str:
    return f"{key.scenario} :: {key.planner} :: seed{key.seed}"
