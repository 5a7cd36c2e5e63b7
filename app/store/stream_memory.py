"""Remembers that the program switched a module's serial output on, even after being killed.

The intent is on the disk before the module is told, and stands until the module has confirmed "off". A stream that was
left on is not "as found": the next conversation switches it off.

An adapter does not tell which module is behind it. So only a module on the same start, by its boot count, is the one
that was switched on; of any other one that streams it is "as found". Where the boot count was not known, the adapter
has to do.
"""

import logging
from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any

from app.store.fact_store import Store

_log = logging.getLogger(__name__)


class StreamMemory:
    """Of one port, by adapter, or by port where there is none; it outlives conversations. Without a store it forgets
    with the program."""

    def __init__(self, store: Store | None = None, adapter: str = "") -> None:
        self._store = store
        self._key = f"stream:{adapter}"
        # What was left on, as it was kept, until something is noted. It may come late, as no port waits for the store.
        self._left_on: Future[Any] = _done(None) if store is None else store.write(lambda facts: facts.state(self._key))
        self.is_taken_over = False

    @property
    def was_left_on(self) -> bool:
        """An earlier conversation did not switch it off."""
        return self._state is not None

    @property
    def boot_count(self) -> int | None:
        """On which start of the module; None: not known."""
        return None if self._state is None else self._state["boot_count"]

    @property
    def _state(self) -> Mapping[str, Any] | None:
        kept = self._left_on
        is_known = kept.done() and not kept.cancelled() and kept.exception() is None
        found: Mapping[str, Any] | None = kept.result() if is_known else None
        return found

    def take_over(self) -> None:
        """It streams, and this conversation switches it off; else the next one does."""
        self.is_taken_over = True

    def note_on(self, boot_count: int | None) -> "Future[None]":
        """Done when it is on the disk, or cannot be."""
        return self._keep({"boot_count": boot_count})

    def clear(self) -> None:
        """The module has confirmed that it is off, or does not stream."""
        self._keep(None)

    def _keep(self, state: Mapping[str, Any] | None) -> "Future[None]":
        self._left_on = _done(state)
        if self._store is None:
            return _done(None)
        kept: Future[None] = Future()

        def end(written: "Future[None]") -> None:
            error = None if written.cancelled() else written.exception()
            if error is not None:
                _log.warning("That a stream is switched on or off cannot be kept: %s", error)
            kept.set_result(None)

        self._store.set_state(self._key, state).add_done_callback(end)
        return kept


def _done(result: Any) -> "Future[Any]":
    future: Future[Any] = Future()
    future.set_result(result)
    return future
