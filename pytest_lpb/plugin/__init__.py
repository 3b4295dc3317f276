"""The pytest plugin. This module is imported in every pytest run on the machine: it stays small and inert.

Everything else is imported once planners are chosen, by `--lpb-planners` or ini `lpb_planners`.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import pytest

from pytest_lpb.plugin.options import add_options, is_active


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the `--lpb-*` options and their ini twins."""
    add_options(parser)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> Generator[None, Any, Any]:
    """Before pytest imports anything: files of run folders bring no code along."""
    given, folder = early_config.known_args_namespace, early_config.invocation_params.dir
    paths = [folder / argument.partition("::")[0] for argument in given.file_or_dir or ()]
    paths = [path for path in paths if path.suffix in (".yaml", ".yml", ".json") or (path / "run.json").is_file()]
    run = folder / given.lpb_problems if given.lpb_problems else None
    if paths or run:
        from pytest_lpb.plugin.strange_code import refuse_strange_code

        refuse_strange_code(paths, run)
    return (yield)


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    """Wake up when planners are chosen."""
    if is_active(config):
        from pytest_lpb.plugin.activation import activate

        activate(config)
    elif any(argument.partition("::")[0].endswith((".yaml", ".yml")) for argument in config.args):
        from pytest_lpb.plugin.unchosen import explain_unchosen_planners

        explain_unchosen_planners(config)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, exitstatus: int, config: pytest.Config) -> None:
    """Where folders are named that hold nothing to run but studies, say how to run those."""
    named = config.args_source is pytest.Config.ArgsSource.ARGS
    if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED and named and not is_active(config):
        from pytest_lpb.plugin.unchosen import told_studies

        if studies := told_studies(config):
            terminalreporter.write_line(studies)
