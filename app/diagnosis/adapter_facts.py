"""Queries the system about a serial adapter and programs that claim it (Linux only).

Only reads files, takes milliseconds and never raises.
"""

import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

ROOT = Path("/")
PORT_GRABBERS = ("ModemManager", "brltty")
SLOW_LATENCY_MS = 4
"""Largest harmless latency timer; the default of an FTDI adapter is 16 ms."""


class Access(NamedTuple):
    """Who may open a device file."""

    group: str | None = None
    """The group that has access; None where there is none but root."""
    is_member: bool = False
    """The user database lists this user in the group …"""
    is_effective: bool = False
    """… and this session has the group; otherwise the user must log out and in again."""


class AdapterFacts(NamedTuple):
    grabbers: tuple[str, ...] = ()
    """Programs that grab serial ports and are running."""
    access: Access | None = None
    latency_path: str | None = None
    """sysfs file of the latency timer."""
    latency_ms: int | None = None


def facts_about(port: str, *, root: Path = ROOT) -> AdapterFacts:
    """The facts about a device; empty for a URL."""
    if not sys.platform.startswith("linux") or "://" in port:
        return AdapterFacts()
    latency = _latency_file(port, root)
    return AdapterFacts(
        grabbers=running(PORT_GRABBERS, root),
        access=access_to(root / port.lstrip("/")),
        latency_path=None if latency is None else f"/{latency.relative_to(root)}",
        latency_ms=None if latency is None else _number_in(latency),
    )


def running(names: Iterable[str], root: Path) -> tuple[str, ...]:
    """Those of these programs that are running; names of up to 15 bytes, to which the kernel cuts them."""
    present = set()
    with suppress(OSError):
        for comm in (root / "proc").glob("[0-9]*/comm"):
            with suppress(OSError):  # the process has ended
                present.add(comm.read_text(errors="replace", encoding="utf-8").strip())
    return tuple(name for name in names if name in present)


def access_to(device: Path) -> Access | None:
    """Who may open `device`; None where it does not exist or the system has no groups."""
    try:
        import grp
        import pwd
    except ImportError:  # Windows
        return None
    try:
        status = device.stat()
        if not status.st_mode & 0o060 or status.st_gid == 0:
            return Access()
        group = grp.getgrgid(status.st_gid)
    except (OSError, KeyError):
        return None
    try:
        user = pwd.getpwuid(os.getuid())
    except KeyError:  # a user without a name, as in some containers
        return Access(group=group.gr_name)
    is_member = user.pw_name in group.gr_mem or user.pw_gid == status.st_gid
    is_effective = status.st_gid in (os.getegid(), *os.getgroups())
    return Access(group=group.gr_name, is_member=is_member, is_effective=is_effective)


def _latency_file(port: str, root: Path) -> Path | None:
    name = os.path.realpath(root / port.lstrip("/")).rsplit("/", 1)[-1]
    path = root / "sys/bus/usb-serial/devices" / name / "latency_timer"
    return path if path.exists() else None


def _number_in(path: Path) -> int | None:
    with suppress(OSError, ValueError):
        return int(path.read_text(encoding="utf-8").strip())
    return None
