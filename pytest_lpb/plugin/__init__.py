"""The pytest plugin. This module is imported in every pytest run on the machine: it stays small and inert.

Everything else is imported once planners are chosen, by `--lpb-planners` or ini `lpb_planners`.
"""

from __future__ import annotations

import pytest

from pytest_lpb.plugin.options import add_options, is_active


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the `--lpb-*` options and their ini twins."""
    add_options(parser)


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    """Wake up when planners are chosen."""
    if is_active(config):
        from pytest_lpb.plugin.activation import activate

        activate(config)
    elif any(argument.partition("::")[0].endswith((".yaml", ".yml")) for argument in config.args):
        from pytest_lpb.plugin.unchosen import explain_unchosen_planners

        explain_unchosen_planners(config)
