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
    """Of one connection; remembers nothing. `was_left_on`: an earlier session did not switch it off."""

    was_left_on = False
    boot_count: int | None = None
    """On which start of the module; None: not known."""
    is_taken_over = False
    """It streamed, and this session switches it off."""

    def note_on(self, boot_count: int | None) -> Future[None]:  # noqa: ARG002  for the one in the store
        """Done when it is on the disk, or cannot be."""
        done: Future[None] = Future()
        done.set_result(None)
        return done

    def clear(self) -> None:
        """The module has confirmed that it is off, or does not stream."""


class StoredStreamMemory(StreamMemory):
    """In the store, by adapter, or by port where there is none. Made outside of the port's thread."""

    def __init__(self, store: Store, adapter: str) -> None:
        self._store, self._key = store, f"stream:{adapter}"
        try:
            left_on = store.facts.state(self._key)
        except StoreTrouble as error:
            _log.warning("Whether a stream was left on cannot be read: %s", error)
            return
        self.was_left_on = left_on is not None
        self.boot_count = None if left_on is None else left_on.get("boot_count")

    def note_on(self, boot_count: int | None) -> Future[None]:
        return self._keep({"at": self._store.database.now(), "boot_count": boot_count})

    def clear(self) -> None:
        self.was_left_on = False
        self._keep(None)

    def _keep(self, state: Mapping[str, object] | None) -> Future[None]:
        def write() -> None:
            try:
                self._store.facts.set_state(self._key, state)
            except StoreTrouble as error:
                _log.warning("That a stream is switched on or off cannot be kept: %s", error)

        return self._store.queue.submit(write)
