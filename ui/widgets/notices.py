"""Notices: what a person has to know or to decide, by their cause, until each is closed or its cause is over."""

from collections.abc import Callable
from functools import partial
from typing import Final, NamedTuple

from PySide6.QtCore import QObject, Signal

from ui.style.appearance import announce
from ui.style.theme import Meaning

_GRAVEST_FIRST: Final = (Meaning.DANGER, Meaning.ATTENTION, Meaning.INFORMATION, Meaning.GOOD)


class Choice(NamedTuple):
    """A button of a notice. `key` is a part of its object name, `text` is in the language in use."""

    key: str
    text: str
    act: Callable[[], object]
    is_main: bool = False
    # Changes the module or loses data: a `StepButton`, which counts only deliberate presses.
    is_step: bool = False
    # A hidden button keeps its place for another step of the same act.
    is_shown: bool = True
    # A disabled one shows what will be possible; the text of the notice says when.
    is_enabled: bool = True


class Notice(NamedTuple):
    """`text` is in the language in use. `dismiss` adds a button to close it. `cause` tells a notice whose text changes
    from another one."""

    meaning: Meaning
    text: str
    choices: tuple[Choice, ...] = ()
    dismiss: Callable[[], object] | None = None
    cause: str = ""

    @property
    def key(self) -> str:
        return self.cause or self.text


class NoticeList(QObject):
    """Keeps the notices of the window (in `Attention`), or of what a page does (`PageJob`). `changed`: they did."""

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        # By its cause; what finds it gives None once it is over.
        self._said: dict[str, Callable[[], Notice | None]] = {}

    @property
    def said(self) -> list[Notice]:
        """The notices of what was said last, the gravest first. One that offers no choice can be closed."""
        notices = []
        for cause, find in self._said.items():
            notice = find()
            if notice is not None:
                is_closable = notice.dismiss is not None or not notice.choices
                notices.append(notice._replace(dismiss=partial(self._close, cause) if is_closable else None))
        return sorted(notices, key=lambda notice: _GRAVEST_FIRST.index(notice.meaning))

    def set_notice(self, notice: Notice | Callable[[], Notice | None], cause: str = "") -> None:
        """Put a notice in place of one of the same cause. Screen readers hear it once. What finds it is called whenever
        it is shown."""
        self._said[cause] = find = notice if callable(notice) else lambda: notice
        if (shown := find()) is not None:
            announce(shown.text, is_urgent=shown.meaning is Meaning.DANGER)
        self.changed.emit()

    def notify(self, meaning: Meaning, text: str, cause: str = "") -> None:
        self.set_notice(Notice(meaning, text), cause)

    def dismiss(self) -> None:
        """Nothing that was said holds any more."""
        self._said.clear()
        self.changed.emit()

    def _close(self, cause: str) -> None:
        self._said.pop(cause, None)
        self.changed.emit()
