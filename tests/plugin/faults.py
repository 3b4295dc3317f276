"""Faults of planners, as the table in docs/robustness.md lists them: the code, and what becomes of the trial."""

from __future__ import annotations

from textwrap import indent
from typing import NamedTuple


class Fault(NamedTuple):
    """A fault that a planner commits at its third call (unless it is in another method)."""

    code: str  # lines of `compute_action(self, observation)`, or whole methods
    outcome: str
    text: str  # in the trial's message
    details: str = ""  # in the trial's details


ERROR = "planner_error"
READ_ONLY = "is read-only: copy what you change"
PUT_BACK = "changed by the planner, and put back: "

FAULTS: dict[str, Fault] = {
    "raises": Fault("raise RuntimeError('no plan')", ERROR, "RuntimeError: no plan"),
    "raises_base_exception": Fault("raise BaseException('odd')", ERROR, "BaseException: odd"),
    "exits": Fault("sys.exit(0)", ERROR, "SystemExit: 0"),
    "raises_keyboard_interrupt": Fault("raise KeyboardInterrupt", ERROR, "KeyboardInterrupt"),
    "skips_itself": Fault("import pytest; pytest.skip('later')", ERROR, "Skipped: later"),
    "stops_pytest": Fault("import pytest; pytest.exit('enough')", ERROR, "Exit: enough"),
    "recurses": Fault(
        "def compute_action(self, observation):\n    return self.compute_action(observation)",
        ERROR,
        "RecursionError: maximum recursion depth",
    ),
    "runs_out_of_memory": Fault("np.zeros(1 << 50)", ERROR, "Unable to allocate 8.00 PiB"),
    "cannot_say_what": Fault(
        "raise type('Odd', (Exception,), {'__str__': lambda self: sys.exit(1)})()",
        ERROR,
        "Odd: (its text cannot be shown: SystemExit)",
    ),
    "cannot_say_which_value": Fault(
        "raise type('Odd', (ValueError,), {'__str__': lambda self: sys.exit(1)})()",
        ERROR,
        "Odd: (its text cannot be shown: SystemExit)",
    ),
    "says_megabytes": Fault("raise RuntimeError('x' * 10**7)", ERROR, "RuntimeError: xxx", "characters left out"),
    "raises_in_setup": Fault("def setup(self, problem):\n    raise OSError('no model')", ERROR, "OSError: no model"),
    "raises_in_constructor": Fault(
        "def __init__(self, parameters):\n    raise KeyboardInterrupt", ERROR, "t = 0 s: KeyboardInterrupt"
    ),
    "wrong_shape": Fault("return np.zeros(3)", ERROR, "an array of shape (3,); expected (2,)"),
    "wrong_type": Fault("return np.zeros(2, dtype=complex)", ERROR, "its elements are complex128"),
    "returns_none": Fault("return None", ERROR, "compute_action returned None"),
    "returns_nan": Fault("return np.array([np.nan, 0.0])", ERROR, "every entry must be finite"),
    "returns_infinity": Fault("return [np.inf, 0.0]", ERROR, "every entry must be finite"),
    "returns_what_raises": Fault(
        "return type('Odd', (), {'__array__': lambda *_, **__: sys.exit(1), '__repr__': lambda self: 1 / 0})()",
        ERROR,
        "SystemExit: 1",
    ),
    "changes_its_action_later": Fault(
        "def compute_action(self, observation):\n"
        "    if observation['t'] > 0.0:\n"
        "        self.kept[:] = np.nan\n"
        "    self.kept = np.zeros(2)\n"
        "    return self.kept",
        "success",
        "reached the goal",
    ),
    "writes_into_observation": Fault("observation['q'][0] = 1.0", ERROR, f"observation['q'] {READ_ONLY}"),
    "writes_into_a_view": Fault(
        "goal = observation['goal_reach'][:1]\ngoal += 1.0",
        ERROR,
        f"observation['goal_reach'] or observation['goal_position'] {READ_ONLY}",
    ),
    "makes_it_writeable": Fault(
        "observation['q'].flags.writeable = True", ERROR, "cannot set WRITEABLE flag to True of this array"
    ),
    "writes_into_limits": Fault(
        "def setup(self, problem):\n    problem.robot.limits.velocity[:] = 9.0",
        ERROR,
        f"problem.robot.limits.velocity {READ_ONLY}",
    ),
    "writes_into_goal_entry": Fault(
        "def setup(self, problem):\n    problem.goal[0].entry['link'] = 'other'",
        ERROR,
        f"problem.goal[0].entry['link'] {READ_ONLY}",
    ),
    "writes_into_problem": Fault(
        "def setup(self, problem):\n    problem.goal[0].tolerance = 9.0",
        ERROR,
        "FrozenInstanceError: cannot assign to field 'tolerance'",
    ),
    "prints_megabytes": Fault("print('word ' * 10**6)", "success", "reached the goal"),
    "prints_megabytes_and_fails": Fault("print('word ' * 10**6); return None", ERROR, "returned None"),
    "forks": Fault("os.fork()", "success", "reached the goal"),
    "forks_in_setup": Fault("def setup(self, problem):\n    os.fork()", "success", "reached the goal"),
    "leaves_threads": Fault(
        "threading.Thread(target=time.sleep, args=(2,), name='left', daemon=True).start()",
        "success",
        "reached the goal",
        "threads left running: left",
    ),
    "seeds_random_numbers": Fault("np.random.seed(1); random.seed(1)", "success", "reached the goal"),
    "changes_directory": Fault("os.chdir('/')", "success", "reached the goal", f"{PUT_BACK}the working directory (/)"),
    "changes_environment": Fault(
        "os.environ['FAULT'] = '1'", "success", "reached the goal", f"{PUT_BACK}environment variables (FAULT)"
    ),
    "changes_signal_handlers": Fault(
        "signal.signal(signal.SIGINT, signal.SIG_IGN)", "success", "reached the goal", f"{PUT_BACK}signal handlers"
    ),
    "sets_an_alarm": Fault("signal.alarm(1)", "success", "reached the goal", f"{PUT_BACK}a timer"),
    "changes_warnings": Fault("warnings.simplefilter('error')", "success", "reached the goal"),
    "changes_search_path": Fault(
        "sys.path.insert(0, '/nowhere')", "success", "reached the goal", f"{PUT_BACK}sys.path"
    ),
    "changes_float_errors": Fault(
        "np.seterr(all='raise')", "success", "reached the goal", f"{PUT_BACK}numpy's handling of floating-point errors"
    ),
    "changes_recursion_limit": Fault(
        "sys.setrecursionlimit(400)", "success", "reached the goal", f"{PUT_BACK}the recursion limit"
    ),
    "changes_threads_of_linear_algebra": Fault(
        "threadpoolctl.threadpool_limits(2)", "success", "reached the goal", f"{PUT_BACK}threads of linear algebra"
    ),
    "replaces_search_path": Fault(
        "sys.path = ['/nowhere', *sys.path]", "success", "reached the goal", f"{PUT_BACK}sys.path"
    ),
    "changes_umask": Fault("os.umask(0o777)", "success", "reached the goal", f"{PUT_BACK}the umask (777)"),
    "changes_locale": Fault(
        "locale.setlocale(locale.LC_ALL, 'C' if locale.setlocale(locale.LC_ALL) != 'C' else 'C.UTF-8')",
        "success",
        "reached the goal",
        f"{PUT_BACK}the locale (C",
    ),
    "pins_itself_to_a_core": Fault(
        "os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})",
        "success",
        "reached the goal",
        f"{PUT_BACK}the cores to run on",
    ),
}

# Faults that take their process down: with -n 0 that is the run's.
FATAL: dict[str, str] = {
    "leaves_at_once": "os._exit(0)",
    "segmentation_fault": "ctypes.string_at(0)",
    "kills_its_process": "os.kill(os.getpid(), signal.SIGKILL)",
}


class Isolated(NamedTuple):
    """A fault that a planner commits in a process of its own."""

    code: str  # as in Fault
    keys: str  # of its planner file
    outcome: str
    text: str  # in the trial's message


ISOLATED: dict[str, Isolated] = {
    "leaves_at_once": Isolated(
        FATAL["leaves_at_once"], "isolate: true", ERROR, "the planner's process ended with exit code 0"
    ),
    "segmentation_fault": Isolated(
        FATAL["segmentation_fault"], "isolate: true", ERROR, "the planner's process was ended by SIGSEGV (signal 11)"
    ),
    "kills_its_process": Isolated(
        FATAL["kills_its_process"], "isolate: true", ERROR, "the planner's process was ended by SIGKILL (signal 9)"
    ),
    "hangs": Isolated(
        "time.sleep(600)", "deadline_s: 0.5", "deadline", "compute_action took longer than deadline_s = 0.5 s"
    ),
    "hangs_in_setup": Isolated(
        "def setup(self, problem):\n    time.sleep(600)",
        "setup_deadline_s: 1.5",
        "deadline",
        "start and setup took longer than setup_deadline_s = 1.5 s",
    ),
    "needs_more_and_more_memory": Isolated(
        "kept = [None]\nwhile kept: kept.append(bytearray(10**8))",
        "memory_mb: 1500",
        ERROR,
        "(memory_mb: 1500)",
    ),
    "leaves_a_child": Isolated("os.fork() or time.sleep(600)", "isolate: true", "success", "reached the goal"),
}

HEAD = """\
import ctypes, locale, os, random, signal, sys, threading, time, warnings
import numpy as np
import threadpoolctl
from pytest_lpb import Planner

CLASSES = {}

class Faulty(Planner):
    # Commits the fault that its scenario is called after: many planners would make a large table of comparisons.
    name = "faulty"

    def setup(self, problem):
        self.inner = CLASSES[problem.name.rpartition("/")[2]](self.parameters)
        self.inner.setup(problem)

    def compute_action(self, observation):
        return self.inner.compute_action(observation)

def pytest_collection_modifyitems(items):
    # A constructor knows no scenario: its fault is a planner of its own.
    items[:] = [item for item in items if (item.key.planner == "raises_in_constructor") == (
        item.key.scenario == "raises_in_constructor" and item.key.planner != "neighbour")]
"""

# Its actions tell whether anything is not as it was when the run began.
NEIGHBOUR = """
def world():
    return repr([
        os.getcwd(), sorted(os.environ.keys() - {"PYTEST_CURRENT_TEST"}), list(sys.path), np.geterr(),
        [signal.getsignal(number) for number in (signal.SIGALRM, signal.SIGUSR1)], sys.getrecursionlimit(),
        callable(signal.getsignal(signal.SIGINT)), [str(entry) for entry in warnings.filters],
        {library["num_threads"] for library in threadpoolctl.threadpool_info()},
        locale.setlocale(locale.LC_ALL), os.sched_getaffinity(0), os.umask(0o022),
    ])

AT_FIRST = []

class Neighbour(Planner):
    name = "neighbour"

    def setup(self, problem):
        self.world = world()
        AT_FIRST[:] = AT_FIRST or [self.world]
        self.seed = problem.seed

    def compute_action(self, observation):
        same = self.world == AT_FIRST[0]
        return np.array([0.01 * np.random.random(), 0.01 * random.random() + (0.0 if same else 0.1)])
"""

METHODS = """
    def setup(self, problem):
        self.calls = 0

    def compute_action(self, observation):
        self.calls += 1
        if self.calls == 3:
{code}
        return np.zeros(2)
"""
LATER = """
    def compute_action(self, observation):
        return np.zeros(2)
"""


def planner_source(name: str, code: str) -> str:
    """The class of a planner with a fault."""
    title = name.title().replace("_", "")
    head = f'\nclass {title}(Planner):\n    name = "{name}"\n'
    registered = f'\nCLASSES["{name}"] = {title}\n'
    if not code.startswith("def "):
        return head + METHODS.format(code=indent(code, " " * 12)) + registered
    return head + "\n" + indent(code, " " * 4) + "\n" + ("" if "def compute_action" in code else LATER) + registered


def conftest(faults: dict[str, str]) -> str:
    """A conftest.py with a planner per fault, and the neighbour."""
    return HEAD + NEIGHBOUR + "".join(planner_source(name, code) for name, code in faults.items())
