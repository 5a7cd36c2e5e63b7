"""Journal of one connection in the store."""

import logging
import os
from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from app.safety.acts import Act
from app.safety.journal import Entry, Outcome
from app.store.database import StoreTrouble
from app.store.fired import forget_unnamed, note_unnamed
from app.store.store import Store
from app.text.messages import UserMessage

_log = logging.getLogger(__name__)


def new_run() -> str:
    """Names one connection: a module without a name is not known beyond it."""
    return os.urandom(4).hex()


class KnownAs(NamedTuple):
    """By what a module is known in the audit log: `name`, "" where it has none, and the `run`, its connection."""

    name: str = ""
    run: str = ""
    is_in_doubt: bool = False
    """It may be another module than the one of this connection."""


UNNAMED: Final = KnownAs()
Adapter = str | Callable[[], str]
"""The USB identity, or what finds it, which may take seconds."""


def detail_of(known_as: KnownAs, adapter: str) -> dict[str, object]:
    """As part of an entry."""
    where = {"adapter": adapter, "module": known_as.name, "run": known_as.run, "is_in_doubt": known_as.is_in_doubt}
    return {name: value for name, value in where.items() if value}


class StoreJournal:
    """The journal of one connection, written by the store's own thread, which also finds the `adapter`."""

    def __init__(
        self,
        store: Store,
        *,
        port: str,
        origin: str,
        adapter: Adapter = "",
        known_as: KnownAs = UNNAMED,
        on_trouble: Callable[[UserMessage], object] = bool,
    ) -> None:
        """`on_trouble` is called in the store's thread with the reason why an entry could not be written."""
        self._store = store
        self._port = port
        self._origin = origin
        self._adapter = adapter
        self._known_as = known_as
        self._on_trouble = on_trouble
        self._has_noted_deploy = False

    @property
    def is_ready(self) -> bool:
        return True

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object]) -> Entry:
        given = dict(detail)

        def write() -> int:
            adapter = self._adapter if isinstance(self._adapter, str) else self._adapter()
            kept = {**detail_of(self._known_as, adapter), **given}
            try:
                if act is Act.DEPLOY and not self._known_as.name:
                    self._has_noted_deploy = note_unnamed(self._store.facts, port=self._port, adapter=adapter)
                return self._store.begin(act, frame, kept, port=self._port, origin=self._origin)
            except StoreTrouble as error:
                _log.warning("The audit log cannot be written: %s", error)
                self._on_trouble(error.message)
                raise

        return self._store.queue.submit(write)

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object]) -> None:
        """Behind its entry: the queue keeps the order. An intent that was not written has no outcome to write."""
        kept = dict(result)

        def write() -> None:
            if entry.cancelled() or entry.exception() is not None:
                return
            try:
                self._store.settle(entry.result(), outcome, kept)
                if self._has_noted_deploy and outcome is Outcome.NOT_SENT:
                    adapter = self._adapter if isinstance(self._adapter, str) else self._adapter()
                    forget_unnamed(self._store.facts, port=self._port, adapter=adapter)
                self._has_noted_deploy = False
            except StoreTrouble as error:
                _log.warning("The outcome of an act is not in the audit log: %s", error)

        self._store.queue.submit(write)
