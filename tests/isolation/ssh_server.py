"""A server for ssh on this host alone, with keys of its own, for as long as a test needs it."""

from __future__ import annotations

import getpass
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

SERVER = """\
Port {port}
ListenAddress 127.0.0.1
HostKey {folder}/host_key
AuthorizedKeysFile {folder}/user_key.pub
PidFile none
StrictModes no
UsePAM no
"""
# `cell` is let in; the server does not know the key of `stranger`, nor the client the server as `impostor`'s.
# The first value that is found holds, but for files of keys: all of them do.
CLIENT = """\
Host closed
    Port 1
Host impostor
    HostKeyAlias nobody-has-seen-it
Host stranger
    IdentityFile {folder}/other_key
Host !stranger *
    IdentityFile {folder}/user_key
Host *
    HostName 127.0.0.1
    Port {port}
    User {user}
    IdentitiesOnly yes
    IdentityAgent none
    GlobalKnownHostsFile /dev/null
    UserKnownHostsFile {folder}/known_hosts
    HostKeyAlias lpb
"""
PATIENCE_S = 10.0


def client_config(folder: Path) -> Path:
    """The file of the client's options."""
    return folder / "client"


@contextmanager
def ssh_server(folder: Path) -> Iterator[Path]:
    """A server, and the client's options for it; skips the test where there is none."""
    program = shutil.which("sshd") or shutil.which("sshd", path="/usr/sbin:/usr/local/sbin:/sbin")
    if program is None or shutil.which("ssh") is None:
        pytest.skip("no sshd and ssh (openssh-server and openssh-client)")
    for name in ("host_key", "user_key", "other_key"):
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / name)], check=True)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    public = (folder / "host_key.pub").read_text().split()
    (folder / "known_hosts").write_text(f"lpb {public[0]} {public[1]}\n")
    (folder / "server").write_text(SERVER.format(port=port, folder=folder))
    client_config(folder).write_text(CLIENT.format(port=port, folder=folder, user=getpass.getuser()))
    tested = subprocess.run([program, "-t", "-f", folder / "server"], capture_output=True, text=True, check=False)
    if tested.returncode:
        pytest.skip(f"sshd cannot run here: {tested.stderr.strip()}")
    with (
        (folder / "log").open("wb") as log,
        subprocess.Popen(
            [program, "-D", "-e", "-f", folder / "server"], stdin=subprocess.DEVNULL, stderr=log
        ) as server,
    ):
        try:
            _wait_for(port)
            yield client_config(folder)
        finally:
            server.terminate()


def _wait_for(port: int) -> None:
    until = time.monotonic() + PATIENCE_S
    while True:
        try:
            socket.create_connection(("127.0.0.1", port), 1.0).close()
            return
        except ConnectionRefusedError:
            assert time.monotonic() < until, "sshd does not listen"
            time.sleep(0.02)
