"""Journal of one connection in the store."""

import logging
import secrets
from collections.abc import Callable, Mapping
from typing import Final

from app.safety.acts import Act
from app.safety.journal import Entry, Journal, NoJournal, Outcome
from app.store.database import StoreTrouble
from app.store.store import Store

_log = logging.getLogger(__name__)
RUN: Final = secrets.token_hex(4)
"""Names this run of the program: a module without a name is not known beyond it."""


class StoreJournal:
    """The journal of one connection, written by the store's own thread."""

    def __init__(self, store: Store, *, port: str, origin: str, adapter: str = "", module: str = "") -> None:
        """`module`: its name, where it has one."""
        self._store = store
        self._port = port
        self._origin = origin
        self._adapter = adapter
        self._module = module

    @property
    def is_ready(self) -> bool:
        return True

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object]) -> Entry:
        where = {"adapter": self._adapter, "module": self._module, "run": RUN}
        store, kept = self._store, {**{name: text for name, text in where.items() if text}, **detail}
        return self._write(lambda: store.begin(act, frame, kept, port=self._port, origin=self._origin))

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object]) -> None:
        kept = dict(result)
        self._settle(entry, lambda number: self._store.settle(number, outcome, kept))

    def begin_baud(self, old_rate: int, new_rate: int) -> Entry:
        return self._write(lambda: self._store.begin_baud(old_rate, new_rate, port=self._port, adapter=self._adapter))

    def settle_baud(self, entry: Entry, outcome: str) -> None:
        self._settle(entry, lambda number: self._store.settle_baud(number, outcome))

    def _write(self, write: Callable[[], int]) -> Entry:
        def work() -> int:
            try:
                return write()
            except StoreTrouble as error:
                _log.warning("The audit log cannot be written: %s", error)
                raise

        return self._store.queue.submit(work)

    def _settle(self, entry: Entry, settle: Callable[[int], None]) -> None:
        """Behind its entry: the queue keeps the order. An intent that was not written has no outcome to write."""

        def work() -> None:
            if entry.cancelled() or entry.exception() is not None:
                return
            try:
                settle(entry.result())
            except StoreTrouble as error:
                _log.warning("The outcome of an act is not in the audit log: %s", error)

        self._store.queue.submit(work)


def journal_for(store: Store | StoreTrouble, *, port: str, origin: str, adapter: str = "", module: str = "") -> Journal:
    """The journal of a connection, whether there is a store or not."""
    if isinstance(store, Store):
        return StoreJournal(store, port=port, origin=origin, adapter=adapter, module=module)
    return NoJournal(store.message)
