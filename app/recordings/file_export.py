"""Writes a file in a background thread, whole or not at all."""

import threading
from collections.abc import Callable, Iterable
from pathlib import Path

from app.recordings.export import ExportCancelled
from app.system.files import whole_file

__all__ = ["ExportCancelled", "FileExport"]


class FileExport:
    """One file being written in a thread of its own, so that the window goes on.

    Not a daemon: a window that closes meanwhile lets the file be finished.
    """

    def __init__(self, path: Path, parts: Callable[[], Iterable[bytes]], count: int = 1) -> None:
        self.path = path
        self.error: Exception | None = None
        self._parts, self._count = parts, max(1, count)
        self._written = 0
        self._is_cancelled = False
        self._thread = threading.Thread(target=self._write, name="dps-s save", daemon=False)
        self._thread.start()

    @property
    def is_done(self) -> bool:
        """It ended, well or not; ``error`` tells."""
        return not self._thread.is_alive()

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return min(1.0, self._written / self._count)

    def cancel(self) -> None:
        """Stop at the next part, within 0.1 s."""
        self._is_cancelled = True

    def wait(self, timeout_s: float) -> bool:
        """Whether it ended within the time."""
        self._thread.join(timeout_s)
        return self.is_done

    def _write(self) -> None:
        try:
            with whole_file(self.path) as file:
                for part in self._parts():
                    file.write(part)
                    self._written += 1
                    if self._is_cancelled:
                        raise ExportCancelled
        except Exception as error:  # noqa: BLE001  said in the window; a thread has nobody else to tell
            self.error = error
