"""Keeps two programs of this user off one network address.

The system keeps a serial port for one program; a TCP server may serve several, and then each reads a part of the
answers. A lock file for each host and port is held while the address is open. Other users, other computers and other
programs are not kept off: TCP has no such thing.
"""

import getpass
import logging
import os
import sys
import tempfile
from pathlib import Path
from typing import IO
from urllib.parse import quote, urlsplit

from app.system import files

NETWORK_SCHEMES = ("socket://", "rfc2217://")
_THIS_COMPUTER = frozenset({"localhost", "127.0.0.1", "::1"})
_log = logging.getLogger(__name__)


class AddressHeld(Exception):
    """Another program of this user has the address open; `pid` is its process, None if it cannot be told."""

    def __init__(self, pid: int | None) -> None:
        super().__init__(f"held by process {pid}")
        self.pid = pid


def is_network_address(port: str) -> bool:
    return port.startswith(NETWORK_SCHEMES)


def sets_rate(port: str) -> bool:
    """Whether this program sets the baud rate: behind a plain socket somebody else did."""
    return not port.startswith("socket://")


def lock_address(port: str) -> IO[bytes] | None:
    """Hold the address of this URL until the returned file is closed, or the process ends; raises `AddressHeld`.

    None where no lock file can be made: a module must be reached (LOCK) also without one.
    """
    try:
        path = _lock_file(port)
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o600), "r+b")
    except (OSError, ValueError, KeyError) as error:  # no port number, which opening the address says; no user name
        _log.warning("no lock file for %s: %s", port, error)
        return None
    try:
        files.lock(file)
    except OSError as error:
        with file:
            text = file.read(20).decode("ascii", errors="replace").strip()
        raise AddressHeld(int(text) if text.isdecimal() else None) from error
    file.truncate()
    file.write(str(os.getpid()).encode())
    file.flush()
    return file


def _lock_file(port: str) -> Path:
    address = urlsplit(port)
    host = address.hostname or ""
    name = "localhost" if host in _THIS_COMPUTER else host
    return _folder() / f"{quote(name, safe='')}-{address.port}.lock"


def _folder() -> Path:
    """Return a folder of this user's, in memory where the system has one: no slow disk keeps LOCK waiting."""
    folders = [os.environ.get("XDG_RUNTIME_DIR", "")]
    if sys.platform != "win32":
        folders.append(f"/run/user/{os.getuid()}")
    for folder in folders:
        if folder and Path(folder).is_dir():
            return Path(folder) / "dps-s-configurator"
    return Path(tempfile.gettempdir()) / f"dps-s-configurator-{getpass.getuser()}"
