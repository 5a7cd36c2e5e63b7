"""List of all shortcuts, built from the actions of the window, and the about box: version, licences, components."""

import platform
from collections.abc import Iterator
from importlib.metadata import PackageMetadata, PackageNotFoundError, metadata
from typing import Final, NamedTuple

from PySide6.QtCore import QObject, QSize, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMessageBox, QWidget

from app import version
from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.services.context import PageEntry
from ui.services.page import Page
from ui.style.icons import app_icon
from ui.widgets.controls import Shortcut, name_of
from ui.widgets.document_window import DocumentWindow
from ui.widgets.visibility_timer import VisibilityTimer

_NATIVE: Final = QKeySequence.SequenceFormat.NativeText
_ALWAYS: Final = (
    ("Esc", marked("Close or cancel; never sends anything")),
    ("Tab", marked("Next control")),
    ("Alt", marked("Menu")),
)


class Key(NamedTuple):
    """A shortcut in the language in use. `page` is the key of its page, "" for one that works everywhere."""

    page: str
    keys: str
    does: str


def keys_of(window: QMainWindow) -> tuple[Key, ...]:
    """All actions with a shortcut, those that work everywhere first."""
    keys = [key for action in window.findChildren(QAction) if (key := _key_of(action)) is not None]
    return tuple(dict.fromkeys(sorted(keys, key=lambda key: key.page)))


def _key_of(action: QAction) -> Key | None:
    keys = ", ".join(shortcut.toString(_NATIVE) for shortcut in action.shortcuts() if not shortcut.isEmpty())
    does = _words(action)
    return Key(_page_of(action), keys, does) if keys and does else None


def _words(action: QAction) -> str:
    """The text of a menu entry, or the name of the control that a page's shortcut clicks."""
    if isinstance(action, Shortcut):
        return name_of(action.control)
    return action.text().replace("&&", "\0").replace("&", "").replace("\0", "&").rstrip(" …")


def _page_of(action: QAction) -> str:
    around: QObject | None = action.parent()
    while around is not None and not isinstance(around, Page):
        around = around.parent()
    return "" if around is None else around.key


class ShortcutsView(DocumentWindow):
    """One table for the window, then one for each page."""

    def __init__(self, window: QMainWindow, texts: Texts, entries: tuple[PageEntry, ...]) -> None:
        super().__init__("keys_view", marked("Keyboard shortcuts"), texts, window)
        self._window, self._entries = window, entries
        VisibilityTimer(self, self.refresh)

    def refresh(self) -> None:
        self.show_markdown("\n".join(self._lines()))

    def _lines(self) -> Iterator[str]:
        shortcuts = keys_of(self._window)
        always = [Key("", keys, tr(does)) for keys, does in _ALWAYS]
        yield from _table(tr("Everywhere"), [key for key in shortcuts if not key.page] + always)
        for entry in self._entries:
            of_page = [key for key in shortcuts if key.page == entry.key]
            if of_page:
                yield from _table(tr(entry.title), of_page)


def _table(title: str, keys: list[Key]) -> Iterator[str]:
    yield f"## {title}\n"
    yield f"| {tr('Key')} | {tr('Action')} |"
    yield "| --- | --- |"
    for key in keys:
        yield f"| **{key.keys}** | {key.does.replace('|', '/')} |"
    yield ""


_PARTS: Final = ("PySide6-Essentials", "shiboken6", "numpy", "pyqtgraph", "pyserial", "platformdirs", "mcap")

_CLASSIFIER: Final = "License :: "


def show_about(window: QWidget) -> QMessageBox:
    """Shows a modeless message box."""
    box = QMessageBox(window)
    box.setObjectName("about_box")
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowModality(Qt.WindowModality.NonModal)
    box.setWindowTitle(tr("About"))
    box.setIconPixmap(app_icon().pixmap(QSize(64, 64)))
    box.setText(f"{tr('DPS-S Configurator')} {version()}")
    box.setInformativeText("\n".join((tr("MIT licence. Made with:"), *_made_with())))
    box.show()
    return box


def _made_with() -> Iterator[str]:
    """Name, version and licence of each component, from its metadata."""
    yield f"Python {platform.python_version()} (PSF-2.0)"
    for name in _PARTS:
        try:
            data = metadata(name)
        except PackageNotFoundError:  # left out of some bundles
            continue
        licence = _licence(data)
        yield f"{data['Name']} {data['Version']}" + (f" ({licence})" if licence else "")


def _licence(data: PackageMetadata) -> str:
    """From the current field, the older one, or the classifiers; "" where there is none."""
    fields = data.json
    written = str(fields.get("license_expression") or fields.get("license") or "").strip()
    if written:
        return written.splitlines()[0]
    classifiers = fields.get("classifier") or ()
    named = [classifier.rpartition(" :: ")[2] for classifier in classifiers if classifier.startswith(_CLASSIFIER)]
    return named[0].removesuffix(" License") if named else ""
