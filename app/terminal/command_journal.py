"""Store and audit log of a command."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial
from typing import NamedTuple

from app.engine.snapshots import Snapshot
from app.safety.journal import Journal, NoJournal
from app.store.database import FILE_NAME, StoreTrouble
from app.store.store import Store, open_store, opening_store
from app.store.store_journal import KnownAs, StoreJournal, new_run
from app.system.folders import data_folder
from app.terminal.console import notify
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.sentences import join_sentences
from app.text.user_error import UserError

ORIGIN = "command line"


class Records(NamedTuple):
    """Of one connection. Without a `store` nothing dangerous is sent. `adapter`: finds its USB identity."""

    journal: Journal
    store: Store | None
    port: str
    adapter: Callable[[], str]
    run: str
    troubles: list[UserMessage]
    """Said at the end."""

    def store_snapshot(self, snapshot: Snapshot) -> Future[int] | None:
        """The future ends when it is on disk or has failed; a failure does not prevent changing a setting."""
        store = self.store
        if store is None:
            return None

        def keep() -> int:
            try:
                return store.store_snapshot(snapshot, port=self.port)
            except StoreTrouble as error:
                notify(error.sentence)
                raise

        return store.queue.submit(keep)


def open_store_or_notify(consequence: str = "") -> Store | None:
    """The store; None if it cannot be opened, which is reported with `consequence`."""
    try:
        store = open_store()
    except StoreTrouble as error:
        notify(join_sentences((error.sentence, consequence)))
        return None
    if store.database.notice is not None:
        notify(store.database.notice.translated())
    return store


def existing_store() -> Store | None:
    """The store, where there is one: reading makes none."""
    return open_store_or_notify() if (data_folder() / FILE_NAME).exists() else None


def adapter_of(port: str) -> str:
    """The USB identity of the adapter; "" if it has none or the ports cannot be listed."""
    from app.engine.ports import list_ports  # not loaded where only the store is asked
    from app.engine.reconnect import address_of

    try:
        return address_of(port, list_ports()).identity
    except UserError:
        return ""


@contextmanager
def closing_store(store: Store | None) -> Iterator[None]:
    """Of what is to be logged; what could not be written in time is said."""
    try:
        yield
    finally:
        if store is not None and store.close():
            notify(tr("The audit log is incomplete."))


def records_on(store: Store | None, port: str, *, origin: str = ORIGIN, module: str = "") -> Records:
    """The store's thread finds the adapter, which may take seconds, while the port is opened. `module`: its name."""
    if store is None:
        return Records(NoJournal(), None, port, partial(adapter_of, port), "", [])
    adapter = store.queue.submit(partial(adapter_of, port)).result
    known_as = KnownAs(clean(module), new_run())
    troubles: list[UserMessage] = []
    journal = StoreJournal(
        store, port=port, origin=origin, adapter=adapter, known_as=known_as, on_trouble=troubles.append
    )
    return Records(journal, store, port, adapter, known_as.run, troubles)


@contextmanager
def records_beside(port: str, limit_s: float) -> Iterator[Records]:
    """For LOCK, which waits for no disk: the store opens beside the port. At the end, at most `limit_s` later, what was
    not written is said, with the store's trouble."""
    store = opening_store()
    records = records_on(store, port)
    try:
        yield records
    finally:
        ends_at = time.monotonic() + limit_s
        opened = store.queue.submit(lambda: store.database.notice)
        try:
            notice = opened.result(limit_s)
            if notice is not None:
                notify(notice.translated())
        except UserError as error:
            records.troubles.append(error.message)
        except TimeoutError:
            pass  # said as what is missing
        is_late = store.close(max(0.0, ends_at - time.monotonic())) > 0
        for trouble in dict.fromkeys(records.troubles):
            notify(trouble.translated())
        if is_late or records.troubles:
            notify(tr("The audit log is incomplete."))


@contextmanager
def records_of(port: str) -> Iterator[Records]:
    """With a store of its own; None that cannot be opened has been reported."""
    store = open_store_or_notify()
    with closing_store(store):
        yield records_on(store, port)
