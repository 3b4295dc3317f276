"""Settings and fixtures for all tests."""

from hypothesis import HealthCheck, settings

pytest_plugins = ["pytester", "tests.plugin.fixtures"]

# Machines are shared: how long an example takes says nothing about the code.
settings.register_profile("lpb", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("lpb")
