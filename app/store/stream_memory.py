"""Remembers that the program switched a module's serial output on, even after being killed.

The intent is on the disk before the module is told, and stands until the module has confirmed "off". A stream that was
left on is not "as found": the next session switches it off.

An adapter does not tell which module is behind it. So only a module on the same start, by its boot count, is the one
that was switched on; of any other one that streams it is "as found". Where the boot count was not known, the adapter
has to do.
"""

import logging
from collections.abc import Mapping
from concurrent.futures import Future

from app.store.database import StoreTrouble
from app.store.store import Store

_log = logging.getLogger(__name__)


class StreamMemory:
    """Of one connection, by adapter, or by port where there is none; without a store it remembers nothing. Made outside
    of the port's thread. `was_left_on`: an earlier session did not switch it off."""

    def __init__(self, store: Store | None = None, adapter: str = "") -> None:
        self._store, self._key = store, f"stream:{adapter}"
        self.was_left_on = False
        self.boot_count: int | None = None
        """On which start of the module; None: not known."""
        self.is_taken_over = False
        """It streamed, and this session switches it off."""
        try:
            left_on = None if store is None else store.facts.state(self._key)
        except StoreTrouble as error:
            _log.warning("Whether a stream was left on cannot be read: %s", error)
            return
        if left_on is not None:
            self.was_left_on, self.boot_count = True, left_on.get("boot_count")

    def note_on(self, boot_count: int | None) -> Future[None]:
        """Done when it is on the disk, or cannot be."""
        return self._keep({"boot_count": boot_count})

    def clear(self) -> None:
        """The module has confirmed that it is off, or does not stream."""
        self.was_left_on = False
        self._keep(None)

    def _keep(self, state: Mapping[str, object] | None) -> Future[None]:
        store, done = self._store, Future[None]()
        if store is None:
            done.set_result(None)
            return done

        def write() -> None:
            try:
                store.facts.set_state(self._key, state)
            except StoreTrouble as error:
                _log.warning("That a stream is switched on or off cannot be kept: %s", error)

        return store.queue.submit(write)
