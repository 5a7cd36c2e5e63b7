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
from typing import Any

from app.store.fact_store import Store

_log = logging.getLogger(__name__)


class StreamMemory:
    """Of one connection, by adapter, or by port where there is none; without a store it remembers nothing. What is
    read of the store may come late, as no port waits for it."""

    def __init__(self, store: Store | None = None, adapter: str = "") -> None:
        self._store = store
        self._key = f"stream:{adapter}"
        self._left_on: Future[Any] | None = None if store is None else store.write(lambda facts: facts.state(self._key))
        self._is_cleared = False
        self.is_taken_over = False

    @property
    def was_left_on(self) -> bool:
        """An earlier session did not switch it off."""
        return self._found is not None

    @property
    def boot_count(self) -> int | None:
        """On which start of the module; None: not known."""
        found = self._found
        return None if found is None else found["boot_count"]

    @property
    def _found(self) -> dict[str, Any] | None:
        left_on = self._left_on
        if left_on is None or self._is_cleared or not left_on.done() or left_on.cancelled():
            return None
        return None if left_on.exception() is not None else left_on.result()

    def take_over(self) -> None:
        """It streams, and this session switches it off."""
        self.is_taken_over = True
        self._left_on = None

    def note_on(self, boot_count: int | None) -> "Future[None]":
        """Done when it is on the disk, or cannot be."""
        return self._keep({"boot_count": boot_count})

    def clear(self) -> None:
        """The module has confirmed that it is off, or does not stream."""
        self._is_cleared = True
        self._keep(None)

    def _keep(self, state: Mapping[str, object] | None) -> "Future[None]":
        done: Future[None] = Future()
        if self._store is None:
            done.set_result(None)
            return done

        def end(written: "Future[None]") -> None:
            error = None if written.cancelled() else written.exception()
            if error is not None:
                _log.warning("That a stream is switched on or off cannot be kept: %s", error)
            done.set_result(None)

        self._store.set_state(self._key, state).add_done_callback(end)
        return done
