"""Shuts the window down within a time limit, whatever a driver or a disk does; saves what an unattended run saw.

What may block runs in daemon threads, for which the end of the process does not wait.
"""

import json
import logging
import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QWidget

from app.engine.conversation import STATUS_KEYS
from ui.core.preferences import Preferences
from ui.services.storage import Storage
from ui.session.ports import Ports

CLOSE_LIMIT_S: Final = 0.4
"""Closing may take half a second; the rest is left for Qt."""
STORE_SHARE_S: Final = 0.06
"""Reserved for the store, which closes after the port: its procedures still write their outcomes."""
_log = logging.getLogger(__name__)


class BoundedThread:
    """Runs `act` in a daemon thread; logs its errors."""

    def __init__(self, name: str, act: Callable[[], object]) -> None:
        self.name = name
        self._act = act
        self._thread = threading.Thread(target=self._work, name=f"dps-s {name}", daemon=True)
        self._thread.start()

    def wait(self, limit_s: float) -> bool:
        self._thread.join(limit_s)
        if self._thread.is_alive():
            _log.warning("Still running at closing: %s", self.name)
            return False
        return True

    def _work(self) -> None:
        try:
            self._act()
        except Exception:  # noqa: BLE001  the window is going; nobody is left to tell
            _log.exception("At closing: %s failed", self.name)


def close_down(ports: Ports, storage: Storage, preferences: Preferences) -> None:
    """Ends everything that is not a widget within `CLOSE_LIMIT_S`; the rest is left to the system."""
    ends_at = time.monotonic() + CLOSE_LIMIT_S

    def left_s() -> float:
        return max(0.0, ends_at - time.monotonic())

    saving = BoundedThread("preferences", preferences.save)
    ports.watcher.stop(0.0)
    if not ports.stop(left_s() - STORE_SHARE_S):
        _log.warning("The port did not close in time; it is left to the system")
    BoundedThread("store", storage.close).wait(left_s())
    saving.wait(left_s())


def end_process(code: int) -> None:
    """Exits at once if one of our threads is still blocked by a driver, a disk or an import; else returns.

    Python's own finalisation frees objects that such a thread uses, which may crash. Non-daemon threads, which write
    files, are joined first. Call it last.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    ours = [thread for thread in threading.enumerate() if thread.name.startswith("dps-s ")]
    for thread in ours:
        if not thread.daemon:
            thread.join()
    if any(thread.is_alive() for thread in ours):
        for stream in (sys.stdout, sys.stderr):
            with suppress(AttributeError, OSError, ValueError):  # none, a full disk, a closed one
                stream.flush()
        os._exit(code)


PICTURE = "live.png"
VALUES = "values.json"


def has_seen_status(ports: Ports) -> bool:
    """Whether the module's status is known and not stale."""
    view, now = ports.module.view, ports.clock()
    return all(view.fresh(key, now) is not None for key in STATUS_KEYS)


def values_seen(ports: Ports) -> dict[str, object]:
    port, view, now = ports.current, ports.module.view, ports.clock()
    known = {key: known for key in sorted(view.values) if (known := view.known(key, now)) is not None}
    return {
        "port": port.connection.port,
        "baud_rate": port.connection.baud_rate,
        "answers": view.is_going,
        "link": {"frames": ports.module.statistics.totals.frames},
        "values": {
            key: {
                "value": reading.value,
                "how": reading.how.value,
                "age_s": round(now - reading.at, 3),
                "is_stale": reading.is_stale,
            }
            for key, reading in known.items()
        },
    }


def write_evidence(folder: Path, window: QWidget, ports: Ports) -> None:
    """Writes both files into `folder`, which is created if needed. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(values_seen(ports), indent=2, ensure_ascii=False)
    (folder / VALUES).write_text(text + "\n", encoding="utf-8")
    picture = folder / PICTURE
    if not window.grab().save(str(picture)):
        raise OSError(f"{picture} could not be written")
