"""Queries the system about a serial adapter and programs that claim it (Linux only).

Only reads files, takes milliseconds and never raises.
"""

import os
import sys
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import NamedTuple

from app.engine.ports import PortInfo

ROOT = Path("/")
PORT_GRABBERS = ("ModemManager", "brltty")
RULE_NAME = "60-dps-s.rules"
RULE_FOLDERS = ("etc/udev/rules.d", "usr/lib/udev/rules.d", "lib/udev/rules.d", "run/udev/rules.d")
_RULE_SOURCE = Path(__file__).parents[2] / "packaging" / "linux" / RULE_NAME
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
    has_rule: bool = False
    """Our udev rule is installed."""
    rule_source: str = f"packaging/linux/{RULE_NAME}"
    """Path of the rule that could be installed; empty where the program came without it, as in a wheel."""
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
        has_rule=any((root / folder / RULE_NAME).exists() for folder in RULE_FOLDERS),
        rule_source=str(_RULE_SOURCE) if _RULE_SOURCE.exists() else "",
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


class PortHistory:
    """Tracks from lists of ports which adapters came and soon went. Bounded; belongs to one thread."""

    SHORT_VISIT_S = 8.0
    """An adapter that is gone this soon was not unplugged by a person."""
    MAX_KEPT = 64

    def __init__(self) -> None:
        self._came_at: dict[str, float] | None = None
        """Of the adapters that are present. Of those of the first list it is unknown."""
        self._at_device: dict[str, str] = {}
        self._short_visits: deque[tuple[float, str]] = deque(maxlen=self.MAX_KEPT)
        """When it left, and which adapter."""

    def poll(self, ports: Iterable[PortInfo], now: float) -> None:
        """Compares a list of ports with the one before."""
        present = {port.identity or port.device: port.device for port in ports}
        before = dict.fromkeys(present, -inf) if self._came_at is None else self._came_at
        self._short_visits += [
            (now, key) for key, at in before.items() if key not in present and now - at <= self.SHORT_VISIT_S
        ]
        self._came_at = {key: before.get(key, now) for key in present}
        self._at_device |= {device: key for key, device in present.items()}
        while len(self._at_device) > self.MAX_KEPT:
            del self._at_device[next(iter(self._at_device))]

    def short_visits(self, port: str, now: float, *, within_s: float = 120.0) -> int:
        """Number of short visits of the adapter at `port` (device name or identity) within that time."""
        adapter = self._at_device.get(port, port)
        return sum(key == adapter and now - left_at <= within_s for left_at, key in self._short_visits)
