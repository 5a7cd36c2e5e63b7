"""List of all shortcuts, built from the actions of the window, and the about box: version, licences, components."""

import platform
from contextlib import suppress
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as version_of
from typing import Final

from PySide6.QtCore import QObject, QSize, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMessageBox, QWidget

from app import version
from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.services.page import Page
from ui.style.icons import app_icon
from ui.widgets.controls import Shortcut, name_of
from ui.widgets.document_window import DocumentWindow
from ui.widgets.visibility_timer import VisibilityTimer

_ALWAYS: Final = (
    ("Esc", marked("Close or cancel; never sends anything")),
    ("Tab", marked("Next control")),
    ("Alt", marked("Menu")),
)


def keys_of(window: QMainWindow) -> list[tuple[str, str, str]]:
    """Where each shortcut works (a page, or ""), the shortcut, and what it does, in the language in use."""
    keys = {("", key, tr(does)): None for key, does in _ALWAYS}
    for action in window.findChildren(QAction):
        shortcuts = QKeySequence.listToString(action.shortcuts(), QKeySequence.SequenceFormat.NativeText)
        if shortcuts and _words(action):
            keys[_page_of(action), shortcuts.replace("; ", ", "), _words(action)] = None
    return sorted(keys, key=lambda key: key[0])


def _words(action: QAction) -> str:
    """The text of a menu entry, or the name of the control that a page's shortcut clicks."""
    if isinstance(action, Shortcut):
        return name_of(action.control)
    return action.text().replace("&&", "\0").replace("&", "").replace("\0", "&").rstrip(" …")


def _page_of(action: QAction) -> str:
    """The title of the page that it is of; "" for one that works everywhere."""
    around: QObject | None = action.parent()
    while around is not None and not isinstance(around, Page):
        around = around.parent()
    return "" if around is None else around.accessibleName()


class ShortcutsView(DocumentWindow):
    """One table, first what works everywhere."""

    def __init__(self, window: QMainWindow, texts: Texts) -> None:
        super().__init__("keys_view", marked("Keyboard shortcuts"), texts, window)
        self._window = window
        VisibilityTimer(self, self.refresh)

    def refresh(self) -> None:
        rows = [(place or tr("Everywhere"), f"**{keys}**", does) for place, keys, does in keys_of(self._window)]
        cells = [(tr("Pages"), tr("Key"), tr("Action")), ("---",) * 3, *rows]
        self.show_markdown("\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in row)} |" for row in cells))


_PARTS: Final = {
    "PySide6-Essentials": "LGPL-3.0-only",
    "shiboken6": "LGPL-3.0-only",
    "numpy": "BSD-3-Clause",
    "pyqtgraph": "MIT",
    "pyserial": "BSD-3-Clause",
    "platformdirs": "MIT",
    "mcap": "MIT",
}
"""Each with its licence."""


def show_about(window: QWidget) -> QMessageBox:
    box = QMessageBox(window)
    box.setObjectName("about_box")
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowModality(Qt.WindowModality.NonModal)
    box.setWindowTitle(tr("About"))
    box.setIconPixmap(app_icon().pixmap(QSize(64, 64)))
    box.setText(f"{tr('DPS-S Configurator')} {version()}")
    lines = [tr("MIT licence. Made with:"), f"Python {platform.python_version()} (PSF-2.0)"]
    for name, licence in _PARTS.items():
        with suppress(PackageNotFoundError):  # some bundles leave the metadata out
            lines.append(f"{name} {version_of(name)} ({licence})")
    box.setInformativeText("\n".join(lines))
    box.show()
    return box
