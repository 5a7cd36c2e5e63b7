"""Queries the system about a serial adapter and programs that claim it (Linux only).

Only reads files, takes milliseconds and never raises.
"""

import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

ROOT = Path("/")
# Of serial ports, on Debian and Ubuntu.
USUAL_GROUP = "dialout"
PORT_GRABBERS = ("ModemManager", "brltty")


class AdapterFacts(NamedTuple):
    grabbers: tuple[str, ...] = ()
    """Programs that grab serial ports and are running."""
    group: str | None = USUAL_GROUP
    """The group that may open the port; None where only root may."""


def facts_about(port: str, *, root: Path = ROOT) -> AdapterFacts:
    """The facts about a device; empty for a URL."""
    if not sys.platform.startswith("linux") or "://" in port:
        return AdapterFacts()
    return AdapterFacts(running(PORT_GRABBERS, root), _group_of(root / port.lstrip("/")))


def running(names: Iterable[str], root: Path) -> tuple[str, ...]:
    """Those of these programs that are running; names of up to 15 bytes, to which the kernel cuts them."""
    present = set()
    with suppress(OSError):
        for comm in (root / "proc").glob("[0-9]*/comm"):
            with suppress(OSError):  # the process has ended
                present.add(comm.read_text(errors="replace", encoding="utf-8").strip())
    return tuple(name for name in names if name in present)


def _group_of(device: Path) -> str | None:
    """The group that may open `device`, as far as it can be told; None where only root may."""
    try:
        import grp

        status = device.stat()
        if not status.st_mode & 0o060 or status.st_gid == 0:
            return None
        return grp.getgrgid(status.st_gid).gr_name
    except (ImportError, OSError, KeyError):  # Windows; the device is gone; a group without a name
        return USUAL_GROUP
