"""Exchanges records in a background thread: automatically if a server is set, or on request."""

import logging
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from PySide6.QtCore import QObject, QTimer, Signal

from app.store.store import Store
from app.system.gil_yield import GilYield
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.user_error import UserError
from ui.core.background_task import BackgroundTask, Running
from ui.services.storage import Storage

if TYPE_CHECKING:
    from app.archive.archive import Archive
    from app.archive.exchange import ArchiveStatus, Exchanged

_log = logging.getLogger(__name__)
EVERY_MS: Final = 60_000
"""Interval at which new records are looked for."""
AT_LEAST_EVERY_S: Final = 300.0
"""Interval at which records of other stations are fetched even if there is nothing to share."""
Act = Callable[["Archive", Callable[["Exchanged"], None]], "Exchanged | None"]


class _Ended(Exception):
    """The window is closing."""


class Seen(NamedTuple):
    """Result of one exchange. `trouble`: why the server or file could not be used."""

    status: "ArchiveStatus"
    done: "Exchanged | None" = None
    trouble: UserMessage | None = None


class ArchiveExchange(QObject):
    """One exchange at a time; the window never waits for it."""

    changed = Signal()

    def __init__(self, storage: Storage, parent: QObject) -> None:
        super().__init__(parent)
        self._storage = storage
        self._task: BackgroundTask[Seen] = BackgroundTask("dps-s archive", self)
        self._waiting: list[Act] = []
        self._is_repeated = False
        self._timer = QTimer(self, interval=EVERY_MS)
        self._timer.timeout.connect(self._exchange_if_due)
        self.server: str | None = None
        """The configured server."""
        self.seen: Seen | None = None
        self.trouble: UserMessage | None = None
        self.altered = 0
        """Number of altered rows on the server, at the last exchange."""

    @property
    def is_running(self) -> bool:
        return self._task.is_running

    @property
    def folder(self) -> Path:
        return self._storage.folder

    def start(self) -> None:
        """Called after the pages are made, to keep the start fast."""
        from app.archive.server_url import stored_server

        self.server = stored_server(self.folder)
        if self.server is not None:
            self._timer.start()
            self._exchange_if_due()

    def use_server(self, text: str) -> None:
        """Store the address and exchange at once; "" removes it. Raises `UserError`."""
        from app.archive.server_url import store_server

        self.server = store_server(self.folder, text)
        if self.server is None:
            self._timer.stop()
            self.refresh()
            return
        self._timer.start()
        self._sync(text)

    def sync(self) -> None:
        if self.server is not None:
            self._sync(self.server)

    def refresh(self) -> None:
        """Count what is not shared, without contacting the server; a running exchange does so at its end."""
        if not self.is_running:
            self.run(lambda _archive, _on_page: None)

    def run(self, act: Act, *, is_repeated: bool = False) -> None:
        """Run one exchange; its result is in `seen` when `changed` is emitted. It waits for the one that runs, unless
        that one `is_repeated`: it is broken off, as it comes again by itself."""
        if self.is_running and not self._is_repeated:
            self._waiting.append(act)
            return
        self._is_repeated = is_repeated
        server, storage = self.server, self._storage
        self._task.run(lambda running: _work(storage, server, act, running), self._on_exchanged, self._fail)
        self.changed.emit()

    def _sync(self, url: str, *, is_due: Callable[["Archive", str], bool] = lambda _archive, _url: True) -> None:
        def sync(archive: "Archive", on_page: Callable[["Exchanged"], None]) -> "Exchanged | None":
            if not is_due(archive, url):
                return None
            from app.archive import exchange

            done = exchange.sync(archive, url, on_page=on_page)
            self.altered = done.refused_count  # read by the window afterwards
            return done

        self.run(sync, is_repeated=True)

    def _exchange_if_due(self) -> None:
        if self.server is not None and not self._task.is_running:
            self._sync(self.server, is_due=_is_due)

    def _on_exchanged(self, seen: Seen) -> None:
        self.seen, self.trouble = seen, seen.trouble
        self._on_ended()

    def _fail(self, error: Exception) -> None:
        if isinstance(error, UserError):
            self.trouble = error.message
        elif not isinstance(error, _Ended):
            _log.error("The archive could not be used", exc_info=error)
            self.trouble = UserMessage(type(error).__name__)
        self._on_ended()

    def _on_ended(self) -> None:
        self.changed.emit()
        if self._waiting:
            self.run(self._waiting.pop(0))


def last_time(at: str | None) -> str:
    """Time of the last exchange if it was today, else its date."""
    if at is None:
        return tr("never")
    when = datetime.fromisoformat(at).astimezone()
    return f"{when:%H:%M}" if when.date() == datetime.now(UTC).astimezone().date() else f"{when:%Y-%m-%d}"


def _is_due(archive: "Archive", server: str) -> bool:
    from app.archive.exchange import status_of

    status = status_of(archive, server)
    if status.not_shared or status.last_at is None:
        return True
    age_s = (datetime.now(UTC) - datetime.fromisoformat(status.last_at)).total_seconds()
    return not 0 <= age_s < AT_LEAST_EVERY_S


@contextmanager
def opened_archive(storage: Storage) -> Iterator["Archive"]:
    """In a background thread. Raises `UserError`."""
    from app.archive.archive import Archive

    store = storage.open_store()
    if not isinstance(store, Store):
        raise store
    with closing(Archive(store)) as archive:
        yield archive


def _work(storage: Storage, server: str | None, act: Act, running: Running) -> Seen:
    """Runs in a background thread; stops between two pages if the window closes."""
    from app.archive.exchange import status_of

    rest = GilYield()

    def on_page(_done: "Exchanged") -> None:
        rest.checkpoint()
        if running.is_cancelled():
            raise _Ended

    with opened_archive(storage) as archive:
        done, trouble = None, None
        try:
            done = act(archive, on_page)
        except UserError as error:
            trouble = error.message
        return Seen(status_of(archive, server), done, trouble)
