"""CasADi functions compiled with the C compiler of the system, kept in a folder from process to process."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from pathlib import Path

import casadi

from pytest_lpb.errors import ConfigurationError

# Results are to be those of the interpreter: no operations fused or reordered, none of this very processor's.
FLAGS = ("-O1", "-fPIC", "-shared", "-ffp-contract=off")
LIBRARIES = ("-lm",)
COMPILERS = ("cc", "gcc", "clang")
FOLDER_VARIABLE = "PYTEST_LPB_CACHE"
SHOWN_LINES = 10  # of a compiler's complaints
DIGEST_BYTES = hashlib.sha256().digest_size

_loaded: dict[str, casadi.Function] = {}


def compiled(function: casadi.Function) -> casadi.Function:
    """The same function compiled with the C compiler, from a cache on disk by content hash.

    Names and sizes of arguments and results stay. The compiled function has no derivatives: take them before.

    Raises:
        ConfigurationError: no C compiler, it fails, or the cache cannot be written or loaded from.
    """
    source = _source(function)
    compiler = _compiler()
    key = _key(source, compiler)
    if key not in _loaded:
        _loaded[key] = _load_or_build(function.name(), cache_folder() / f"{key}.so", source, compiler)
    return _loaded[key]


def cache_folder() -> Path:
    """Where compiled functions are kept: $PYTEST_LPB_CACHE, $XDG_CACHE_HOME/pytest-lpb or ~/.cache/pytest-lpb.

    Raises:
        ConfigurationError: none is set, and there is no home folder.
    """
    try:
        if chosen := os.environ.get(FOLDER_VARIABLE):
            return Path(chosen).expanduser().absolute()
        caches = os.environ.get("XDG_CACHE_HOME", "")
        # Its specification has relative ones ignored.
        return (Path(caches) if Path(caches).is_absolute() else Path("~/.cache").expanduser()) / "pytest-lpb"
    except RuntimeError as error:
        raise ConfigurationError(
            f"no folder for compiled functions: {error}; set the environment variable {FOLDER_VARIABLE}"
        ) from error


def _source(function: casadi.Function) -> str:
    """C source text. CasADi could also write the file, but to the current folder."""
    generator = casadi.CodeGenerator(function.name())
    generator.add(function)
    text: str = generator.dump()
    return text


def _key(source: str, compiler: tuple[str, ...]) -> str:
    """A name for all that a library depends on."""
    platforms = (casadi.CasadiMeta.version(), _identity(compiler), platform.machine())
    parts = (source, *compiler, *FLAGS, *LIBRARIES, *platforms)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def _compiler() -> tuple[str, ...]:
    """The command of the C compiler, as words."""
    chosen = os.environ.get("CC", "").strip()
    # A path may hold spaces, and a command arguments: CC="ccache gcc".
    commands = ([chosen], chosen.split()) if chosen else [[name] for name in COMPILERS]
    for program, *arguments in commands:
        if found := shutil.which(program):
            return str(Path(found).absolute()), *arguments
    looked_for = f"CC={chosen} is no program" if chosen else f"looked for CC (not set), {', '.join(COMPILERS)}"
    raise ConfigurationError(
        f"no C compiler found: {looked_for}; install one, e.g. apt install gcc, or leave `compile` off"
    )


@functools.cache
def _identity(compiler: tuple[str, ...]) -> str:
    """What a compiler says about itself: an update of it makes new libraries."""
    return _run((*compiler, "--version")).stdout


def _run(command: tuple[str, ...], folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            command,
            cwd=folder,
            env={**os.environ, "LC_ALL": "C"},  # the same words in all languages
            stdin=subprocess.DEVNULL,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            check=False,
        )
    except OSError as error:
        raise ConfigurationError(f"cannot run the C compiler {command[0]}: {error.strerror or error}") from error


def _load_or_build(name: str, path: Path, source: str, compiler: tuple[str, ...]) -> casadi.Function:
    """A function from a library in the cache, which is built if it is missing or damaged."""
    if _is_whole(path):
        # A whole one may still be of no use here, where another system's C library made it.
        with contextlib.suppress(RuntimeError):
            return casadi.external(name, str(path))
    _build(path, source, compiler)
    try:
        return casadi.external(name, str(path))
    except RuntimeError as error:
        raise ConfigurationError(
            f"cannot load the compiled function {name}: {_reason(error, path)}; "
            f"the environment variable {FOLDER_VARIABLE} names another folder"
        ) from error


def _is_whole(path: Path) -> bool:
    """Whether a file is there and ends with the hash of the rest: loading a truncated library can kill the process."""
    try:
        content = path.read_bytes()
    except OSError:
        return False
    digest = hashlib.sha256(content[:-DIGEST_BYTES]).digest()
    return content[-DIGEST_BYTES:] == digest


def _build(path: Path, source: str, compiler: tuple[str, ...]) -> None:
    """Compile a library and put it into place. Of several processes at that the last wins, and none is in the way."""
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".build-", dir=path.parent, ignore_cleanup_errors=True) as folder:
            library = _compile(source, compiler, Path(folder))
            digest = hashlib.sha256(library.read_bytes()).digest()
            with library.open("ab") as file:
                file.write(digest)  # loaders do not look behind a library's last section
            library.replace(path)
    except OSError as error:
        raise ConfigurationError(
            f"cannot write compiled functions to {path.parent}: {error.strerror or error}; "
            f"the environment variable {FOLDER_VARIABLE} names another folder"
        ) from error


def _compile(source: str, compiler: tuple[str, ...], folder: Path) -> Path:
    """The library made from C source text in a folder."""
    code, library = folder / "function.c", folder / "function.so"
    code.write_text(source, encoding="utf-8")
    command = (*compiler, *FLAGS, code.name, "-o", library.name, *LIBRARIES)
    result = _run(command, folder)
    if result.returncode or not library.is_file():
        lines = (result.stderr + result.stdout).rstrip().splitlines()[-SHOWN_LINES:]
        said = "\n".join(lines) or "it printed nothing"
        raise ConfigurationError(f"the C compiler failed ({' '.join(command)}, status {result.returncode}):\n{said}")
    return library


def _reason(error: RuntimeError, path: Path) -> str:
    """The line about a file in what CasADi says of all the places where it looked for it."""
    lines = [line.strip() for line in str(error).splitlines()]
    about = [line.removeprefix("Error code: ") for line in lines if line.startswith(f"Error code: {path}")]
    return (about or lines or [""])[-1]
