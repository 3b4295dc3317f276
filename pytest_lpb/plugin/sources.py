"""Studies, the problems of old runs, and runs to finish: what they say becomes options, as if it had been typed."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.files import parted
from pytest_lpb.plugin.options import PARTS, named_study, split_names
from pytest_lpb.run.folder import RUN_FILE, RunFolder
from pytest_lpb.study.study import Study, read_study

# Options that decide the trials of a run and what is made of them; run.json records them to finish the run later.
RECORDED = (
    "lpb_planners",
    "lpb_trials",
    "lpb_seed",
    *(f"lpb_random_{part}" for part in PARTS),
    "lpb_assert",
    "lpb_kpis",
    "lpb_problems",
)


def typed_options(config: pytest.Config) -> dict[str, Any]:
    """The options among `RECORDED` that were given, by name."""
    values = {name: getattr(config.option, name) for name in RECORDED}
    return {name: value for name, value in values.items() if value not in (None, False)}


def as_arguments(options: dict[str, Any]) -> list[str]:
    """Options as they are typed."""
    names = {name: "--" + name.replace("_", "-") for name in options}
    return [names[name] if value is True else f"{names[name]}={value}" for name, value in options.items()]


def arguments_given(config: pytest.Config) -> bool:
    """Whether files or folders were named on the command line."""
    return config.args_source is pytest.Config.ArgsSource.ARGS


def run_folder_of(config: pytest.Config, option: str, value: str) -> RunFolder:
    """The run folder that an option names: workers take what the controller found, `latest` may lead elsewhere now."""
    told = getattr(config, "workerinput", {}).get(f"lpb_{option}")
    return RunFolder.open(Path(told) if told else config.invocation_params.dir / value)


def restore(config: pytest.Config, run: RunFolder) -> None:
    """Take options and arguments of a run that is to be finished. Raises ConfigurationError for others."""
    info = run.info()
    if info.get("planned") is None:
        raise ConfigurationError(f"--lpb-resume: {run.path} does not say which trials it was to have; start a new run")
    recorded: dict[str, Any] = info["options"]
    for name, value in typed_options(config).items():
        if recorded.get(name) != value:
            raise ConfigurationError(
                f"--lpb-resume: {as_arguments({name: value})[0]} is not what {run.path.name} was started with; "
                "leave it out: the run is finished as it began"
            )
    _check_own(config, info, run)
    for name in RECORDED:
        if name in recorded:
            setattr(config.option, name, recorded[name])
    if arguments_given(config) and config.args != info["arguments"]:
        raise ConfigurationError(
            f"--lpb-resume: {run.path.name} was started with {' '.join(info['arguments'])}; leave {config.args[0]} out"
        )
    config.args = list(info["arguments"])
    _check_place(config, info, run)


def _check_own(config: pytest.Config, info: dict[str, Any], run: RunFolder) -> None:
    """Raise ConfigurationError where a run names planner files or arguments in its own folder.

    They were not there when it began: whoever wrote them means to have them run.
    """
    references = split_names(info["options"].get("lpb_planners") or "")
    files = [path for reference in references if (path := parted(reference)[1])]
    for named in (*files, *info["arguments"]):
        path = config.invocation_params.dir / named.partition("::")[0]
        if path.resolve().is_relative_to(run.path):
            raise ConfigurationError(
                f"--lpb-resume: {run.path.name} names {named}, which lies in the run folder itself and cannot have "
                "been there when the run began: its run.json has been changed; start a new run"
            )


def _check_place(config: pytest.Config, info: dict[str, Any], run: RunFolder) -> None:
    """Raise ConfigurationError where names and paths would mean something else than they did."""
    if hasattr(config, "workerinput"):
        return
    folder, rootdir = Path(info["invocation"]), Path(info["rootdir"])
    if config.invocation_params.dir != folder:
        raise ConfigurationError(f"--lpb-resume: {run.path.name} was started in {folder}; finish it there")
    if config.rootpath != rootdir:
        raise ConfigurationError(
            f"--lpb-resume: {run.path.name} had the rootdir {rootdir}, this one is {config.rootpath}; "
            f"add --rootdir={rootdir}"
        )


def check_unchanged(info: dict[str, Any], now: dict[str, Any]) -> None:
    """Raise ConfigurationError when planners or scenarios are not those that a run began with."""
    changed = [
        f"{kind[:-1]} {name!r} ({key.replace('_', ' ')})"
        for kind, keys in (("planners", ("parameters_hash", "source_hash", "isolation")), ("scenarios", ("hash",)))
        for name, before in info[kind].items()
        for key in keys
        if name not in now[kind] or now[kind][name].get(key) != before.get(key)
    ]
    if changed:
        raise ConfigurationError(
            f"--lpb-resume: changed since the run began: {', '.join(changed)}; its trials would not be comparable: "
            "undo the changes, or start a new run"
        )


def study_of(config: pytest.Config) -> Study | None:
    """The study that is named, its values taken as options where none were given."""
    path = named_study(config)
    if path is None:
        return None
    others = [text for text in config.args if _file_of(text, config) != path]
    if others:
        raise ConfigurationError(f"a study is run by itself: {path.name} and {others[0]} are named; run one at a time")
    study = read_study(path)
    option, content = config.option, study.content
    _default(option, "lpb_planners", ",".join(study.references()))
    _default(option, "lpb_trials", content.trials)
    _default(option, "lpb_seed", content.seed)
    if option.lpb_baseline is None and content.gate is not None:
        option.lpb_baseline = study.baseline()
        _default(option, "lpb_fail_on", content.gate.fail_on)
        _default(option, "lpb_inconclusive", content.gate.inconclusive)
    _default(option, "lpb_kpis", None if content.kpis is None else ",".join(content.kpis))
    # A study measures: what planners do not solve is its result, not its failure.
    _default(option, "lpb_assert", content.verdict or "none")
    for part in content.random:
        setattr(option, f"lpb_random_{part}", True)
    return study


def take_problems(config: pytest.Config, run: RunFolder) -> None:
    """Make an old run's problems, for which its run.json stands, the run's only argument."""
    path = run.path / RUN_FILE
    if arguments_given(config):
        others = [text for text in config.args if _file_of(text, config) != path]
        if others:
            raise ConfigurationError(
                f"--lpb-problems runs the problems of {run.path.name}; {others[0]} is not among them: leave it out"
            )
    else:
        config.args = [str(path)]
    flags = [part for part in PARTS if getattr(config.option, f"lpb_random_{part}")]
    if flags:
        raise ConfigurationError(
            f"--lpb-problems runs concrete problems; nothing is drawn: leave --lpb-random-{flags[0]} out"
        )


def _default(option: Any, name: str, value: Any) -> None:
    if getattr(option, name) is None and value is not None:
        setattr(option, name, value)


def _file_of(argument: str, config: pytest.Config) -> Path:
    return Path(os.path.normpath(config.invocation_params.dir / argument.partition("::")[0]))
