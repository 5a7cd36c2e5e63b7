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
from app.engine.worker import CLOSING_LIMIT_S
from ui.core.preferences import Preferences
from ui.services.storage import Storage
from ui.session.ports import Ports

# A port may take `CLOSING_LIMIT_S`; the rest is for its thread to end, and for the store, which closes after it:
# procedures still write their outcomes.
CLOSE_LIMIT_S: Final = CLOSING_LIMIT_S + 0.15
STORE_SHARE_S: Final = 0.06
PICTURE: Final = "live.png"
VALUES: Final = "values.json"
_log = logging.getLogger(__name__)


def close_down(ports: Ports, storage: Storage, preferences: Preferences) -> None:
    """Ends everything that is not a widget within `CLOSE_LIMIT_S`; the rest is left to the system."""
    ends_at = time.monotonic() + CLOSE_LIMIT_S
    saving = _begin("preferences", preferences.save)
    ports.watcher.stop(0.0)
    if not ports.stop(CLOSE_LIMIT_S - STORE_SHARE_S):
        _log.warning("The port did not close in time; it is left to the system")
    for thread in (_begin("store", storage.close), saving):
        thread.join(max(0.0, ends_at - time.monotonic()))
        if thread.is_alive():
            _log.warning("Still running at closing: %s", thread.name)


def _begin(name: str, act: Callable[[], object]) -> threading.Thread:
    """Does it in a daemon thread; logs its errors, as nobody is left to tell."""

    def work() -> None:
        try:
            act()
        except Exception:  # noqa: BLE001
            _log.exception("At closing: %s failed", name)

    thread = threading.Thread(target=work, name=f"dps-s {name}", daemon=True)
    thread.start()
    return thread


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
