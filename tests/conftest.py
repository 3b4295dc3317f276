"""Settings and fixtures for all tests."""

# pytester's runs in this process forget the modules that they were the first to import. Imported here, these stay:
# matplotlib loaded a second time does not fit objects of the first.
import signal

import gymnasium
import matplotlib.backends.backend_agg
import matplotlib.backends.backend_pdf
import matplotlib.backends.backend_svg
import matplotlib.figure
import pandas as pd
import pyarrow.parquet
import scipy.signal
import scipy.stats
from hypothesis import HealthCheck, settings

KEPT = (gymnasium, matplotlib, pd, pyarrow, scipy)

pytest_plugins = ["pytester", "tests.plugin.fixtures"]

# Property tests draw the same examples in every run. The random search is a command of its own, and says its seed:
# pytest -m hypothesis --hypothesis-profile=search --hypothesis-seed=N
# Machines are shared: how long an example takes says nothing about the code.
settings.register_profile(
    "repeatable", deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True, database=None
)
settings.register_profile(
    "search", settings.get_profile("repeatable"), derandomize=False, max_examples=1000, print_blob=True
)
settings.load_profile("repeatable")

# Processes of a shell's background jobs are born deaf to Ctrl-C; tests are to hear it wherever they run.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
