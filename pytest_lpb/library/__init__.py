"""Trials, planners and runs as Python functions, without pytest: what `import pytest_lpb` offers."""
