"""The journal of one connection, kept in the store where there is one."""

import logging
from collections.abc import Mapping

from app.acts import Act
from app.journal import Journal, JournalFailed, NoJournal, Outcome
from app.store.database import StoreTrouble
from app.store.store import Store

_log = logging.getLogger(__name__)


class StoreJournal:
    """The journal of one connection, kept in the store."""

    def __init__(
        self, store: Store, *, port: str, origin: str, adapter: str = "", module_id: int | None = None
    ) -> None:
        self._store = store
        self._port = port
        self._origin = origin
        self._adapter = adapter
        self._module_id = module_id

    @property
    def is_ready(self) -> bool:
        return True

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object]) -> int:
        try:
            return self._store.begin(
                act, frame, detail, port=self._port, origin=self._origin, module_id=self._module_id
            )
        except StoreTrouble as error:
            raise JournalFailed(error.sentence) from error

    def settle(self, entry: int, outcome: Outcome, result: Mapping[str, object]) -> None:
        try:
            self._store.settle(entry, outcome, result)
        except StoreTrouble as error:
            _log.warning("The outcome of an act is not in the audit log: %s", error)

    def begin_baud(self, old_rate: int, new_rate: int) -> int:
        try:
            return self._store.begin_baud(old_rate, new_rate, port=self._port, adapter=self._adapter)
        except StoreTrouble as error:
            raise JournalFailed(error.sentence) from error

    def settle_baud(self, entry: int, outcome: str) -> None:
        try:
            self._store.settle_baud(entry, outcome)
        except StoreTrouble as error:
            _log.warning("The end of a change of baud rate is not in the store: %s", error)


def journal_for(store: Store | StoreTrouble, *, port: str, origin: str, adapter: str = "") -> Journal:
    """The journal of a connection, whether there is a store or not."""
    if isinstance(store, Store):
        return StoreJournal(store, port=port, origin=origin, adapter=adapter)
    return NoJournal(store.sentence)
