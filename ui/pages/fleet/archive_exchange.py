"""Exchanges records in a background thread: by itself if a server is set, or on request."""

from typing import TYPE_CHECKING, Final, NamedTuple

from PySide6.QtCore import QObject, QTimer, Signal

from app.system.wall_clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.sentences import join_sentences
from app.text.user_error import UserError
from ui.core.background_task import BackgroundTask, Running
from ui.services.storage import Storage

if TYPE_CHECKING:  # without a server none of it is loaded
    from app.archive.archive import Archive, Exchanged
    from app.archive.sync import Synced

EVERY_MS: Final = 300_000
_SHOWN_LEFT_OUT: Final = 3


class _Ended(Exception):
    """The window is closing."""


class ExchangeState(NamedTuple):
    """What is known after an exchange, as a sentence; `is_trouble`: the place could not be used."""

    sentence: str
    needs_attention: bool = False
    is_trouble: bool = False


class ArchiveExchange(QObject):
    """One exchange at a time, with a server or a file: none is begun while one is running. The window never waits for
    it."""

    # An exchange begins, or has ended.
    changed = Signal()

    def __init__(self, storage: Storage, parent: QObject) -> None:
        super().__init__(parent)
        # The one that is set, without its password.
        self.server: str | None = None
        self.state = ExchangeState(tr("No server is set."))
        self._storage = storage
        self._task: BackgroundTask[ExchangeState] = BackgroundTask("dps-s archive", self)
        self._timer = QTimer(self, interval=EVERY_MS)
        self._timer.timeout.connect(lambda: self.exchange(self.server))

    @property
    def is_running(self) -> bool:
        return self._task.is_running

    def start(self) -> None:
        """Called when the store is open."""
        store = self._storage.ready
        self.server = None if store is None else store.state("server")
        if self.server is not None:
            self._timer.start()
            self.exchange(self.server)

    def use_server(self, text: str) -> None:
        """Keep the address and exchange at once; "" forgets it. Raises `UserError`."""
        from app.archive.postgres import server_url

        self.server = server_url(text).shown if text.strip() else None
        archive_of(self._storage).store.set_state("server", self.server)
        if self.server is None:
            self._timer.stop()
        else:
            self._timer.start()
        self.exchange(text if self.server else None)

    def exchange(self, place: str | None) -> None:
        """With a server or a file, in both directions; None: count only what is not shared with the server."""
        if self.is_running:
            return
        server = self.server

        def work(running: Running) -> ExchangeState:
            archive = archive_of(self._storage)
            done = None if place is None else _sync(archive, place, running)
            return _state(None if server is None else archive.exchanged(server), done)

        self._task.run(work, self._on_ended, self._fail)
        self.changed.emit()

    def _fail(self, error: Exception) -> None:
        if isinstance(error, UserError):
            self._on_ended(ExchangeState(error.sentence, needs_attention=True, is_trouble=True))
        elif not isinstance(error, _Ended):
            raise error

    def _on_ended(self, state: ExchangeState) -> None:
        self.state = state
        self.changed.emit()


def _state(exchanged: "Exchanged | None", done: "Synced | None") -> ExchangeState:
    """`exchanged`: with the server that is set. `done`: just now, with it or with a file."""
    parts: list[str] = []
    if exchanged is not None:
        time = tr("never") if exchanged.last_at is None else local_time(exchanged.last_at, MINUTE)
        parts.append(tr("Not shared: {count}. Last: {time}.", count=exchanged.not_shared, time=time))
    if done is not None:
        parts.append(tr("Sent: {sent}. Received: {received}.", sent=done.sent, received=done.received))
    if done is not None and done.left_out_count:
        parts.append(tr("Left out, unreadable or altered: {count}.", count=done.left_out_count))
        parts += [f"{one.id[:12]}: {one.why}." for one in done.left_out[:_SHOWN_LEFT_OUT]]
    sentence = join_sentences(parts) or tr("No server is set.")
    return ExchangeState(sentence, needs_attention=done is not None and done.left_out_count > 0)


def archive_of(storage: Storage) -> "Archive":
    """In a background thread. Raises `UserError`."""
    from app.archive.archive import Archive

    store = storage.begun
    if store is None:
        raise _Ended
    return Archive(store)


def _sync(archive: "Archive", place: str, running: Running) -> "Synced":
    """Stops between two pages if the window closes."""
    from app.archive.sync import sync

    def on_page(_done: "Synced") -> None:
        if running.is_cancelled():
            raise _Ended

    return sync(archive, place, on_page)
