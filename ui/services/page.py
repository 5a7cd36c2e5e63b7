"""The base class of the window's pages, and their header: title, actions at the right, what is rare in a menu."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAccessible, QAction, QHideEvent, QKeyEvent, QShowEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QToolButton, QWidget
from shiboken6 import isValid

from app.engine.worker import Batch
from app.text.i18n import tr
from ui.session.page_job import PageJob
from ui.style.icons import Icon
from ui.style.theme import scaled
from ui.widgets.controls import control, named
from ui.widgets.step_button import application

if TYPE_CHECKING:
    from ui.session.shown_module import ShownModule

HEIGHT_PX: Final = 40
# Steps of Esc, each with what is true while it is possible.
WaysBack = Iterable[tuple[object, Callable[[], object]]]


class PageHeader(QWidget):
    """`name` is the page's key. The same height on every page."""

    def __init__(self, name: str, title: str, *actions: QWidget) -> None:
        super().__init__()
        self.setObjectName(f"{name}_header")
        self.title = named(QLabel(title), f"{name}_title", "title")
        self._menu = named(QMenu(self), f"{name}_more_menu")
        self.more = control(QToolButton(), f"{name}_more", says=tr("More"), picture=Icon.MORE, role="quiet")
        self.more.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.more.setMenu(self._menu)
        self.row = QHBoxLayout(self)
        self.row.setContentsMargins(0, 0, 0, 0)
        self.row.addWidget(self.title, 1)
        self.setMinimumHeight(scaled(HEIGHT_PX))
        for action in actions:
            self.add(action)

    def add(self, action: QWidget) -> None:
        """One more action, at the right of those that are there."""
        self.row.addWidget(action)

    def add_rare(self, name: str, text: str, slot: object) -> QAction:
        """An entry of the menu behind "⋯", which comes after what was added before."""
        if self._menu.isEmpty():
            self.add(self.more)
        action = named(self._menu.addAction(text), name)
        action.setAutoRepeat(False)
        action.triggered.connect(slot)
        return action


class Page(QWidget):
    """What it polls while it is seen, and what follows language and theme: see `VisibilityTimer`."""

    accessible_role: ClassVar = QAccessible.Role.Section
    connect_wanted = Signal(object)  # To this `Target`; the window asks first where that is risky
    ports_wanted = Signal()  # To choose one
    page_wanted = Signal(str)  # The key of a page
    # The page itself says that nothing is connected, and leads on.
    shows_link: bool = False
    # Of the files that may be dropped on the window for this page.
    suffixes: tuple[str, ...] = ()

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(f"{name}_page")
        self._module: ShownModule | None = None
        application().focusChanged.connect(self._on_focus_changed)

    @property
    def module(self) -> "ShownModule":
        """The one that is shown; set before the page is seen first."""
        if self._module is None:
            raise RuntimeError(f"{self.objectName()} was not given a module")
        return self._module

    def show_module(self, module: "ShownModule") -> None:
        """Show this module from now on: another conversation has begun, or another port was chosen. A page keeps
        nothing of a module itself, so nothing of the former one can be left on it."""
        former, self._module = self._module, module
        if former is not None:
            for signal, slot in self._slots(former):
                signal.disconnect(slot)
        for signal, slot in self._slots(module):
            signal.connect(slot)
        self.end_notices()
        self._refresh_if_seen()

    def _slots(self, module: "ShownModule") -> tuple[tuple[Any, Callable[..., None]], ...]:
        return (
            (module.changed, self._refresh_if_seen),
            (module.check_changed, self._refresh_if_seen),
            (module.ended, self.on_ended),
            (module.batch, self.on_batch),
        )

    # What a page does

    def refresh(self) -> None:
        """Draw what `module` is now. Called while the page is seen, and when it comes into sight."""

    def on_batch(self, batch: Batch) -> None:
        """Take each batch of the module shown, whether the page is seen or not."""

    def on_ended(self) -> None:
        """Its conversation is over: what was prepared for it is done no more."""

    def open_file(self, path: Path) -> None:
        """A file of one of `suffixes`."""
        raise LookupError(f"{self.objectName()} opens no files such as {path}")

    def open_files(self, paths: Sequence[Path]) -> None:
        """Several at once."""
        for path in paths:
            self.open_file(path)

    def go_to(self, view: str) -> None:
        """Show this view of a page that has several."""
        raise LookupError(f"{self.objectName()} has no view {view}")

    def ways_back(self) -> WaysBack:
        """Return what Esc may do, of which it does the first that is possible; it never sends anything but LOCK."""
        return ()

    def notices(self) -> list[PageJob]:
        """Return all that says something on it."""
        return self.findChildren(PageJob)

    # What is the same for all

    def make_header(self, title: str, *actions: QWidget) -> PageHeader:
        """The first row of the page."""
        return PageHeader(self.objectName().removesuffix("_page"), title, *actions)

    def on_escape(self) -> bool:
        """Esc was pressed: go back one step; whether there was one."""
        step = next((step for is_possible, step in self.ways_back() if is_possible), None)
        if step is not None:
            step()
        return step is not None

    def end_notices(self, *, is_page_left: bool = False) -> None:
        """End what was said of another module, or before the page was left; see `PageJob.end`."""
        for notice in self.notices():
            notice.end(is_page_left=is_page_left)

    def _refresh_if_seen(self) -> None:
        if self.isVisible():
            self.refresh()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._module is not None:
            self.refresh()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        if self.isHidden():  # else the window was, or what the page lies in
            self.end_notices(is_page_left=True)

    def _on_focus_changed(self, old: QWidget | None, now: QWidget | None) -> None:
        """Qt gives the focus of a control that is disabled to the next one, which whoever types would press."""
        is_taken = old is not None and now is not None and isValid(old) and self.isAncestorOf(old)
        if old is not None and is_taken and old.isVisible() and not old.isEnabled():
            self.setFocus()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() != Qt.Key.Key_Escape or not self.on_escape():
            super().keyPressEvent(event)
