"""Journal of a command: in the store, or none where the store is unavailable."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.terminal.console import say
from app.text.i18n import tr
from app.text.sentences import together

if TYPE_CHECKING:
    from concurrent.futures import Future

    from app.engine.snapshots import Snapshot
    from app.safety.journal import Journal
    from app.store.store import Store

ORIGIN = "command line"


@dataclass(frozen=True, slots=True)
class Records:
    """`store` None: it cannot be had, which has been said; nothing dangerous is sent then."""

    journal: "Journal"
    store: "Store | None"
    port: str

    def keep_snapshot(self, snapshot: "Snapshot") -> "Future[int] | None":
        """Done when it is on disk, or cannot be: a setting may be changed also where its old value cannot be kept."""
        store = self.store
        if store is None:
            return None

        def keep() -> int:
            from app.store.database import StoreTrouble

            try:
                return store.keep_snapshot(snapshot, port=self.port)
            except StoreTrouble as error:
                say(error.sentence)
                raise

        return store.queue.submit(keep)


def open_store_or_say(consequence: str = "") -> "Store | None":
    """The store; None where it cannot be opened, which is said with its consequence."""
    from app.store.database import StoreTrouble
    from app.store.store import open_store

    try:
        store = open_store()
    except StoreTrouble as error:
        say(together((error.sentence, consequence)))
        return None
    if store.notice is not None:
        say(store.notice)
    return store


def adapter_of(port: str) -> str:
    """The USB identity of the adapter; "" where it has none, or where the system does not say."""
    from app.engine.ports import PortsUnknown, list_ports
    from app.engine.reconnect import address_of

    try:
        return address_of(port, list_ports()).identity
    except PortsUnknown:
        return ""


@contextmanager
def records_of(port: str, adapter: str = "") -> Iterator[Records]:
    from app.store.database import StoreTrouble
    from app.store.store import open_store
    from app.store.store_journal import journal_for

    store: Store | None = None
    try:
        store = open_store()
        if store.notice is not None:
            say(store.notice)
        yield Records(journal_for(store, port=port, origin=ORIGIN, adapter=adapter), store, port)
    except StoreTrouble as error:
        if store is not None:
            raise
        say(error.sentence)
        yield Records(journal_for(error, port=port, origin=ORIGIN), None, port)
    finally:
        if store is not None and store.close():
            say(tr("The audit log is incomplete."))
