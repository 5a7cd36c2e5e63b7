"""The journal of one conversation, or of one command, in the store."""

import logging
import os
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Final

from app.safety.acts import Act
from app.safety.journal import Entry, Outcome
from app.safety.left_active import KnownAs
from app.store.acts import Where, begin, settle
from app.store.fact_store import Facts, Store
from app.store.fired import forget_unnamed, note_unnamed
from app.store.trouble import StoreTrouble
from app.text.messages import UserMessage

_log = logging.getLogger(__name__)

UNNAMED: Final = KnownAs()
# The USB identity, or what finds it, which may take seconds.
Adapter = str | Callable[[], str]


def new_run() -> str:
    """Names one conversation: a module without a name is not known beyond it."""
    return os.urandom(4).hex()


class StoreJournal:
    """Written by the store's own thread, which also finds the `adapter`."""

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
        # The acts without an outcome.
        self._acts: dict[Entry, Act] = {}
        self._has_noted_deploy = False

    @property
    def is_ready(self) -> bool:
        return True

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object]) -> Entry:
        given = dict(detail)

        def write(facts: Facts) -> str:
            where = self._where()
            if act is Act.DEPLOY and not self._known_as.name:
                self._has_noted_deploy = note_unnamed(facts, port=self._port, adapter=where.adapter)
            return begin(facts, act, frame, given, where)

        entry = self._store.write(write)
        self._acts[entry] = act
        entry.add_done_callback(self._tell)
        return entry

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object]) -> None:
        """Behind its entry: the queue keeps the order. An intent that was not written has no outcome to write."""
        kept = dict(result)
        act = self._acts.pop(entry, None)
        if act is None:
            return

        def write(facts: Facts) -> None:
            if entry.cancelled() or entry.exception() is not None:
                return
            where = self._where()
            settle(facts, entry.result(), act, where, outcome, kept)
            if self._has_noted_deploy and outcome is Outcome.NOT_SENT:
                forget_unnamed(facts, port=self._port, adapter=where.adapter)
            self._has_noted_deploy = False

        self._store.write(write).add_done_callback(self._tell)

    def _where(self) -> Where:
        adapter = self._adapter if isinstance(self._adapter, str) else self._adapter()
        return Where(self._port, self._origin, adapter, self._known_as)

    def _tell(self, written: "Future[str] | Future[None]") -> None:
        error = None if written.cancelled() else written.exception()
        if isinstance(error, StoreTrouble):
            _log.warning("The audit log cannot be written: %s", error)
            self._on_trouble(error.message)
