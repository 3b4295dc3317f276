"""Turns the plugin on: a session from the options, and the hooks of this process."""

from __future__ import annotations

import pytest

from pytest_lpb.errors import LpbError
from pytest_lpb.plugin.collection import CollectionPlugin, register_tags
from pytest_lpb.plugin.options import is_worker
from pytest_lpb.plugin.resolving import resolved_session
from pytest_lpb.plugin.session import SESSION, WORKER_CONTROLLER
from pytest_lpb.plugin.worker import WorkerPlugin
from pytest_lpb.run.orphans import end_with_parent


def activate(config: pytest.Config) -> None:
    """Set the session up and register the hooks. Raises UsageError for options that are wrong."""
    try:
        session = resolved_session(config)
    except LpbError as error:
        raise pytest.UsageError(str(error)) from error
    config.stash[SESSION] = session
    register_tags(config)
    manager = config.pluginmanager
    manager.register(CollectionPlugin(session), "lpb-collection")
    manager.register(WorkerPlugin(), "lpb-worker")
    if is_worker(config):
        end_with_parent(config.workerinput[WORKER_CONTROLLER])  # type: ignore[attr-defined] # xdist adds it
    else:
        # Tables and reports are the controller's business: workers start without pandas and the like.
        from pytest_lpb.plugin.controller import ControllerPlugin
        from pytest_lpb.plugin.folding import FoldingPlugin
        from pytest_lpb.plugin.termination import TerminationPlugin

        termination = TerminationPlugin()
        controller = ControllerPlugin(session, config, termination)
        manager.register(controller, "lpb-controller")
        manager.register(termination, "lpb-termination")
        manager.register(FoldingPlugin(), "lpb-folding")
        # By its hooks, whatever name xdist is loaded under: `-p xdist.plugin` gives it another than its entry point.
        if hasattr(config.hook, "pytest_configure_node"):
            from pytest_lpb.plugin.crashes import CrashPlugin

            manager.register(CrashPlugin(session, controller.tell), "lpb-crashes")
