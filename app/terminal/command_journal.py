"""Store and audit log of a command. The store opens beside the port, and no port waits for it."""

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from functools import cache, partial
from typing import NamedTuple, TypeVar

from app.modules.names import store_as_found
from app.safety.journal import Journal
from app.safety.left_active import KnownAs
from app.store.acts import Where
from app.store.fact_store import CLOSE_LIMIT_S, Facts, Store
from app.store.opening import FILE_NAME
from app.store.rows import Row
from app.store.store_journal import StoreJournal, new_run
from app.system.folders import data_folder
from app.terminal.console import notify
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.user_error import UserError
from protocol.fields import Value

ORIGIN = "command line"
READ_LIMIT_S = 1.0
"""How long a command waits for what it asks of the store."""
Result = TypeVar("Result")


class Records(NamedTuple):
    """Of one connection. `find_adapter` returns its USB identity, which may take seconds."""

    journal: Journal
    store: Store
    port: str
    find_adapter: Callable[[], str]
    known_as: KnownAs
    troubles: list[UserMessage]
    """Why entries are missing in the audit log; said at the end."""

    def keep_as_found(self, settings: Mapping[str, Value], boot_count: int | None) -> "Future[Row]":
        """The future ends when it is on disk or has failed; a failure does not prevent changing a setting."""
        return self.store.write(partial(store_as_found, settings=settings, boot_count=boot_count, port=self.port))

    def where(self) -> Where:
        """For the store's thread."""
        return Where(self.port, ORIGIN, self.find_adapter(), self.known_as)

    def ask(self, work: Callable[[Facts], Result]) -> Result | None:
        """None where the store is in trouble, which is said at the end, or too slow."""
        try:
            return self.store.write(work).result(READ_LIMIT_S)
        except (UserError, TimeoutError):
            return None


@contextmanager
def opened_store(
    limit_s: float = CLOSE_LIMIT_S, *, starts_late: bool = False
) -> Iterator[tuple[Store, list[UserMessage]]]:
    """The store, at once, and a list for why entries are missing. At the end, at most `limit_s` later, what a person
    should know of the store is said, and whether anything was not written."""
    store = Store(starts_late=starts_late)
    troubles: list[UserMessage] = []
    try:
        yield store, troubles
    finally:
        ends_at = time.monotonic() + limit_s
        store.start()
        notice = notice_of(store, limit_s)
        left = store.close(max(0.0, ends_at - time.monotonic()))
        for said in dict.fromkeys([notice, *troubles]):
            if said is not None:
                notify(said.translated())
        if left or troubles:
            notify(tr("The audit log is incomplete."))


def notice_of(store: Store, limit_s: float = CLOSE_LIMIT_S) -> UserMessage | None:
    """What a person should know of it, or why there is none; None where that is not known in time."""
    try:
        return store.opened.result(limit_s)
    except UserError as error:
        return error.message
    except TimeoutError:
        return None


@contextmanager
def records_of(
    port: str, limit_s: float = CLOSE_LIMIT_S, *, module: str = "", starts_late: bool = False
) -> Iterator[Records]:
    """With a store of its own."""
    with opened_store(limit_s, starts_late=starts_late) as (store, troubles):
        yield records_on(store, troubles, port, module=module)


def records_on(
    store: Store, troubles: list[UserMessage], port: str, *, origin: str = ORIGIN, module: str = ""
) -> Records:
    """The store's thread finds the adapter, while the port is opened. `module`: its name."""
    find_adapter = cache(partial(adapter_of, port))
    known_as = KnownAs(clean(module), new_run())
    journal = StoreJournal(
        store, port=port, origin=origin, adapter=find_adapter, known_as=known_as, on_trouble=troubles.append
    )
    return Records(journal, store, port, find_adapter, known_as, troubles)


def existing_store() -> Store | None:
    """The store, where there is one: reading makes none."""
    try:
        return Store() if (data_folder() / FILE_NAME).exists() else None
    except OSError:
        return Store()  # a folder that may not be entered; whoever reads is told


def adapter_of(port: str) -> str:
    """The USB identity of the adapter; "" if it has none or the ports cannot be listed."""
    from app.engine.ports import list_ports  # not loaded where only the store is asked
    from app.engine.reconnect import address_of

    try:
        return address_of(port, list_ports()).identity
    except UserError:
        return ""


def in_background(work: Callable[[], Result]) -> "Future[Result]":
    """What waits for the store, while the conversation goes on."""
    future: Future[Result] = Future()

    def run() -> None:
        try:
            future.set_result(work())
        except Exception as error:  # noqa: BLE001  passed on by the future
            future.set_exception(error)

    threading.Thread(target=run, name="dps-s keeping", daemon=True).start()
    return future
