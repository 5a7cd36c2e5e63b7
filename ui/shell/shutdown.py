"""Shuts the window down within one time limit, whatever a driver or a disk does.

What may block is done in a thread that can be left behind: a daemon, which the end of the program does not wait for.
"""

import logging
import os
import sys
import threading
import time
from collections.abc import Callable
from typing import Final

from ui.core.connector import Connector
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.services.storage import Storage

CLOSE_LIMIT_S: Final = 0.4
"""Half a second is promised; the rest is Qt's and the machine's own."""
STORE_SHARE_S: Final = 0.06
"""The store is closed after the port, whose procedures write down how they ended."""
_log = logging.getLogger(__name__)


class Countdown:
    """What is left of a limit, in seconds."""

    def __init__(self, limit_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._ends_at = clock() + limit_s

    @property
    def left_s(self) -> float:
        return max(0.0, self._ends_at - self._clock())


class Chore:
    """Something that may take long, begun at once beside this thread. An error in it is logged."""

    def __init__(self, name: str, act: Callable[[], object]) -> None:
        self.name = name
        self._act = act
        self._thread = threading.Thread(target=self._work, name=f"dps-s {name}", daemon=True)
        self._thread.start()

    def wait(self, limit_s: float) -> bool:
        """Whether it ended within the limit; else it is left behind."""
        self._thread.join(limit_s)
        if self._thread.is_alive():
            _log.warning("Left behind at closing: %s", self.name)
            return False
        return True

    def _work(self) -> None:
        try:
            self._act()
        except Exception:  # noqa: BLE001  the window is going; nobody is left to tell
            _log.exception("At closing: %s failed", self.name)


def close_down(connector: Connector, ports: PortWatcher, storage: Storage, preferences: Preferences) -> None:
    """End everything that outlives a widget, within `CLOSE_LIMIT_S`; what does not end is left to the system."""
    countdown = Countdown(CLOSE_LIMIT_S)
    remembering = Chore("remembering", preferences.save)
    ports.stop(0.0)
    if not connector.stop(countdown.left_s - STORE_SHARE_S):
        _log.warning("The port did not close in time; it is left to the system")
    Chore("store", storage.close).wait(countdown.left_s)
    remembering.wait(countdown.left_s)


def end_process(code: int) -> None:
    """Return, or end the program here: where a thread of ours stays behind, held by a driver, a disk or an import.

    Python's own way out frees what such a thread still uses, which may crash. A file that is being written is waited
    for: its thread is no daemon. Call it last, when everything is closed and on disk.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    ours = [thread for thread in threading.enumerate() if thread.name.startswith("dps-s ")]
    for thread in ours:
        if not thread.daemon:
            thread.join()
    if any(thread.is_alive() for thread in ours):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
