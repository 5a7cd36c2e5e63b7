"""Exchanges records in a background thread: by itself if a server is set, or on request."""

from typing import TYPE_CHECKING, Final, NamedTuple

from PySide6.QtCore import QObject, QTimer, Signal

from app.system.wall_clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.messages import UserMessage
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


class Seen(NamedTuple):
    """What is known after an exchange."""

    # With the server that is set.
    exchanged: "Exchanged | None" = None
    # The last one of this session.
    done: "Synced | None" = None
    # Why the place could not be used.
    trouble: UserMessage | None = None

    @property
    def needs_attention(self) -> bool:
        return self.trouble is not None or (self.done is not None and self.done.left_out_count > 0)

    @property
    def sentence(self) -> str:
        """In the language in use."""
        if self.trouble is not None:
            return self.trouble.translated()
        parts: list[str] = []
        if self.exchanged is not None:
            last_at = self.exchanged.last_at
            time = tr("never") if last_at is None else local_time(last_at, MINUTE)
            parts.append(tr("Not shared: {count}. Last: {time}.", count=self.exchanged.not_shared, time=time))
        if self.done is not None:
            parts.append(tr("Sent: {sent}. Received: {received}.", sent=self.done.sent, received=self.done.received))
        if self.done is not None and self.done.left_out_count:
            parts.append(tr("Left out, unreadable or altered: {count}.", count=self.done.left_out_count))
            parts += [f"{one.id[:12]}: {one.why}." for one in self.done.left_out[:_SHOWN_LEFT_OUT]]
        return join_sentences(parts) or tr("No server is set.")


class ArchiveExchange(QObject):
    """One exchange at a time, with a server or a file: none is begun while one is running. The window never waits for
    it."""

    # An exchange begins, or has ended.
    changed = Signal()

    def __init__(self, storage: Storage, parent: QObject) -> None:
        super().__init__(parent)
        # The one that is set, without its password.
        self.server: str | None = None
        self.seen = Seen()
        self._storage = storage
        self._task: BackgroundTask[Seen] = BackgroundTask("dps-s archive", self)
        self._timer = QTimer(self, interval=EVERY_MS)
        self._timer.timeout.connect(lambda: self.exchange(self.server))

    @property
    def is_running(self) -> bool:
        return self._task.is_running

    def start(self) -> None:
        """Called when the store is open."""
        self.server = archive_of(self._storage).server
        if self.server is not None:
            self._timer.start()
            self.exchange(self.server)

    def use_server(self, text: str) -> None:
        """Store the address and exchange at once; "" removes it. Raises `UserError`."""
        archive = archive_of(self._storage)
        archive.use_server(text).result()
        self.server = archive.server
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
        seen = self.seen._replace(trouble=None)

        def work(running: Running) -> Seen:
            archive = archive_of(self._storage)
            found = seen
            if place is not None:
                try:
                    found = found._replace(done=_sync(archive, place, running))
                except UserError as error:
                    found = found._replace(trouble=error.message)
            return found._replace(exchanged=None if server is None else archive.exchanged(server))

        self._task.run(work, self._on_ended, self._fail)
        self.changed.emit()

    def _fail(self, error: Exception) -> None:
        if isinstance(error, UserError):
            self._on_ended(self.seen._replace(trouble=error.message))
        elif not isinstance(error, _Ended):
            raise error

    def _on_ended(self, seen: Seen) -> None:
        self.seen = seen
        self.changed.emit()


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
