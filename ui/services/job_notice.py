"""What a page says of a job: its progress with "Cancel" while it runs, then its result until it is dismissed, the page
is left, or another module is connected."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal

from app.settings.profiles import Profile
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled, not_written
from app.text.user_error import UserError
from ui.core.background_task import BackgroundTask
from ui.services.announcer import announce
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

Result = TypeVar("Result")


class JobNotice(QObject):
    """`changed`: a job began or ended, or the notice changed."""

    changed = Signal()

    def __init__(self, parent: QObject | None = None, *, is_of_module: bool = True) -> None:
        """`is_of_module`: else of files, and another module ends nothing of it."""
        super().__init__(parent)
        self.is_of_module = is_of_module
        self._notice: Callable[[], Notice | None] | None = None
        self._writing: BackgroundTask[Any] = BackgroundTask("dps-s save", self, finished_at_close=True)

    def set_notice(self, make: Callable[[], Notice | None] | None) -> None:
        """Set the notice; `make` is called whenever it is shown, None removes it. Screen readers hear it once."""
        self._notice = make
        notice = self.result_notice()
        if notice is not None:
            announce(notice.text, is_urgent=notice.meaning is Meaning.DANGER)
        self.changed.emit()

    def notify(self, meaning: Meaning, make: Callable[[], str]) -> None:
        self.set_notice(lambda: Notice(meaning, make()))

    def read_profile(self, path: Path) -> Profile | None:
        """None where the file is no profile, which is said."""
        from app.settings.profile_file import ProfileRefused, read_profile  # the first paint does not wait for TOML

        try:
            return read_profile(path)
        except ProfileRefused as refusal:
            faults = refusal  # the name of an except clause ends with it

        def text() -> str:
            return labelled(tr("{file} is not a profile", file=path.name), join_sentences(faults.sentences[:3]))

        self.notify(Meaning.ATTENTION, text)
        return None

    def write_file(self, path: Path, write: Callable[[], Result], saved: Callable[[Result], str]) -> None:
        """Writes a file in the background, as the disk may be slow, and says what came of it; `saved` is given what
        `write` returned."""
        self.set_notice(lambda: progress_notice(tr("Saving…"), None))

        def tell(result: Result) -> None:
            self.notify(Meaning.GOOD, partial(saved, result))

        self._writing.run(lambda _running: write(), tell, partial(self._tell_unwritten, path))

    @property
    def is_writing(self) -> bool:
        return self._writing.is_running

    def _tell_unwritten(self, path: Path, error: Exception) -> None:
        if not isinstance(error, UserError | OSError | RuntimeError):
            raise error
        meaning = Meaning.ATTENTION if isinstance(error, UserError) else Meaning.DANGER
        self.notify(meaning, partial(not_written, path, error))

    def dismiss(self) -> None:
        self.set_notice(None)

    def end(self, *, is_page_left: bool) -> None:
        """Another module is connected, or only the page was left, which does not end what a person has to act on."""
        notice = self.result_notice()
        if not is_page_left and not self.is_of_module:
            return
        is_news = notice is None or (notice.meaning in (Meaning.GOOD, Meaning.INFORMATION) and not notice.choices)
        if self._notice is not None and (is_news or not is_page_left):
            self.dismiss()

    def result_notice(self) -> Notice | None:
        """The last result; None if there is none, or it was dismissed. What offers no choice can be closed."""
        notice = None if self._notice is None else self._notice()
        return notice if notice is None or notice.choices else notice._replace(dismiss=self.dismiss)


def progress_notice(text: str, cancel: Callable[[], None] | None) -> Notice:
    """Of a running job."""
    choices = () if cancel is None else (Choice("cancel", tr("Cancel"), cancel),)
    return Notice(Meaning.INFORMATION, text, choices)
