"""Exchanges records in a background thread: automatically if a server is set, or on request."""

import logging
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from PySide6.QtCore import QObject, QTimer, Signal

from app.system.gil_yield import GilYield
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.user_error import UserError
from ui.core.background_task import BackgroundTask, Running
from ui.services.storage import Storage

if TYPE_CHECKING:
    from app.archive.archive import Archive
    from app.archive.sync import Synced

_log = logging.getLogger(__name__)
EVERY_MS: Final = 60_000
"""Interval at which new records are looked for."""
AT_LEAST_EVERY_S: Final = 300.0
"""Interval at which records of other stations are fetched even if there is nothing to share."""
Act = Callable[["Archive", Callable[["Synced"], None]], "Synced | None"]


class _Ended(Exception):
    """The window is closing."""


class Seen(NamedTuple):
    """What is known after an exchange. `done`: of the last one in this session; `trouble`: why the place could not be
    used."""

    not_shared: int
    last_at: str | None
    done: "Synced | None" = None
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
        self.sync_with(text, is_repeated=True)

    def sync(self) -> None:
        if self.server is not None:
            self.sync_with(self.server, is_repeated=True)

    def sync_with(self, place: str, *, is_repeated: bool = False) -> None:
        """A server's address or a file, in both directions."""
        self.run(lambda archive, on_page: _sync(archive, place, on_page), is_repeated=is_repeated)

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
        storage, server = self._storage, self.server
        self._task.run(lambda running: _work(storage, server, act, running), self._on_exchanged, self._fail)
        self.changed.emit()

    def _exchange_if_due(self) -> None:
        server = self.server
        if server is None or self._task.is_running:
            return

        def act(archive: "Archive", on_page: Callable[["Synced"], None]) -> "Synced | None":
            return _sync(archive, server, on_page) if _is_due(archive, server) else None

        self.run(act, is_repeated=True)

    def _on_exchanged(self, seen: Seen) -> None:
        done = self.seen.done if seen.done is None and self.seen is not None else seen.done
        self.seen = seen._replace(done=done)
        self._on_ended()

    def _fail(self, error: Exception) -> None:
        if isinstance(error, _Ended):
            return
        if not isinstance(error, UserError):
            raise error
        before = self.seen or Seen(0, None)
        self.seen = before._replace(trouble=error.message)
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


def archive_of(storage: Storage) -> "Archive":
    """In a background thread. Raises `UserError`."""
    from app.archive.archive import Archive

    store = storage.begun
    if store is None:
        raise _Ended
    store.opened.result()
    return Archive(store)


def _sync(archive: "Archive", place: str, on_page: Callable[["Synced"], None]) -> "Synced":
    from app.archive.sync import sync

    return sync(archive, place, on_page)


def _is_due(archive: "Archive", server: str) -> bool:
    last_at = archive.last_exchange(server)
    if last_at is None or archive.not_shared(server):
        return True
    age_s = (datetime.now(UTC) - datetime.fromisoformat(last_at)).total_seconds()
    return not 0 <= age_s < AT_LEAST_EVERY_S


def _work(storage: Storage, server: str | None, act: Act, running: Running) -> Seen:
    """Runs in a background thread; stops between two pages if the window closes."""
    rest = GilYield()

    def on_page(_done: "Synced") -> None:
        rest.checkpoint()
        if running.is_cancelled():
            raise _Ended

    archive = archive_of(storage)
    done, trouble = None, None
    try:
        done = act(archive, on_page)
    except UserError as error:
        trouble = error.message
    if server is None:
        return Seen(0, None, done, trouble)
    return Seen(archive.not_shared(server), archive.last_exchange(server), done, trouble)
