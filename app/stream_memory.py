"""Remembers that the program switched a module's serial output on, also after it was killed.

The intent is on the disk before the module is told, and stands until the module has confirmed "off". A stream that was
left on is not "as found": the next session switches it off.
"""

import logging
from concurrent.futures import Future

from app.store.database import StoreTrouble
from app.store.store import Store

_log = logging.getLogger(__name__)


class StreamMemory:
    """Of one connection; remembers nothing. `was_left_on`: an earlier session did not switch it off."""

    was_left_on = False
    is_taken_over = False
    """It streamed, and this session switches it off."""

    def note_on(self) -> Future[None]:
        """Done when it is on the disk, or cannot be."""
        done: Future[None] = Future()
        done.set_result(None)
        return done

    def forget(self) -> None:
        """The module has confirmed that it is off, or does not stream."""


class StoredStreamMemory(StreamMemory):
    """In the store, by adapter, or by port where there is none. Made outside of the port's thread."""

    def __init__(self, store: Store, adapter: str) -> None:
        self._store, self._adapter = store, adapter
        try:
            self.was_left_on = store.is_stream_left_on(adapter)
        except StoreTrouble as error:
            _log.warning("Whether a stream was left on cannot be read: %s", error)

    def note_on(self) -> Future[None]:
        return self._store.queue.submit(lambda: self._write(is_on=True))

    def forget(self) -> None:
        self.was_left_on = False
        self._store.queue.submit(lambda: self._write(is_on=False))

    def _write(self, *, is_on: bool) -> None:
        try:
            (self._store.note_stream_on if is_on else self._store.forget_stream_on)(self._adapter)
        except StoreTrouble as error:
            _log.warning("That a stream is switched on or off cannot be kept: %s", error)
