"""Windows of the help: the user guide, the list of all shortcuts, the about box."""

import platform
from collections.abc import Iterator, Sequence
from contextlib import suppress
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject, QSize, Qt, QUrl
from PySide6.QtGui import (
    QAction,
    QDesktopServices,
    QImage,
    QKeySequence,
    QTextBlock,
    QTextBlockFormat,
    QTextCursor,
    QTextDocument,
    QTextOption,
)
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QMainWindow, QMessageBox, QTextBrowser, QWidget

from app import version
from app.text.i18n import ENGLISH, language, tr
from protocol.translatable import marked
from ui.files.file_dialogs import show_over_page
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.shell.actions import MenuEntry
from ui.shell.main_window import MainWindow
from ui.style.icons import app_icon
from ui.style.theme import Space, current
from ui.widgets.controls import Shortcut, control, in_column, name_of, named
from ui.widgets.visibility_timer import VisibilityTimer


class DocumentWindow(QDialog):
    """Shown again it is where the reader left it."""

    def __init__(self, name: str, title: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.text = control(QTextBrowser(), f"{name}_text", says=title)
        self.text.setOpenExternalLinks(False)
        self.text.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        self.text.setWordWrapMode(QTextOption.WrapMode.WrapAtWordBoundaryOrAnywhere)
        self.buttons = named(QDialogButtonBox(QDialogButtonBox.StandardButton.Close), f"{name}_buttons")
        self.buttons.rejected.connect(self.reject)
        self.setWindowTitle(title)
        self.setAccessibleName(title)
        close = self.buttons.button(QDialogButtonBox.StandardButton.Close)
        control(close, f"{name}_close", text=tr("Close"), key="Esc")
        in_column((self.text, 1), self.buttons, of=self, spacing=Space.S, margins=Space.M)

    def show_markdown(self, text: str, base: QUrl | None = None) -> None:
        """`base`: the URL of the folder with pictures and other pages, with a trailing slash."""
        document = self.text.document()
        if base is not None:
            document.setBaseUrl(base)
        document.setMarkdown(text)
        document.setDocumentMargin(Space.M)
        cursor, block = QTextCursor(document), document.begin()
        while block.isValid():
            cursor.setPosition(block.position())
            if cursor.currentTable() is None:
                room = QTextBlockFormat()
                room.setTopMargin(Space.L if block.blockFormat().headingLevel() > 1 else 0)
                room.setBottomMargin(Space.XS if block.textList() is not None else Space.S)
                cursor.mergeBlockFormat(room)
            block = block.next()

    def bring_up(self) -> None:
        show_over_page(self, is_large=True)


GUIDE: Final = Path(__file__).parent / "guide"
_CHAPTER_LEVEL: Final = 2
_INK: Final = "#1a1c1e"
_PAPER: Final = "#ffffff"
"""Colours in the drawings, replaced by those of the theme."""


def guide_page(folder: Path = GUIDE) -> Path | None:
    """The guide in the language in use, else in English; None if neither is installed."""
    pages = (folder / f"{language()}.md", folder / f"{ENGLISH}.md")
    return next((page for page in pages if page.is_file()), None)


class GuideViewer(DocumentWindow):
    def __init__(self, parent: QWidget, folder: Path = GUIDE) -> None:
        super().__init__("guide_viewer", tr("User guide"), parent)
        self._folder = folder
        self._is_loaded = False
        self.text.setOpenLinks(False)
        self.text.anchorClicked.connect(self.open_link)
        VisibilityTimer(self, self._load_once, restyle=self._load_again)

    def _load_once(self) -> None:
        """When it is first shown: its pictures are as wide as it is."""
        if not self._is_loaded:
            self._load()
            self.text.moveCursor(QTextCursor.MoveOperation.Start)

    def _load(self) -> None:
        page = guide_page(self._folder)
        if page is not None:
            self._is_loaded = True
            self.show_markdown(page.read_text(encoding="utf-8"), QUrl.fromLocalFile(f"{self._folder.as_posix()}/"))
            self._show_pictures(page.stem)

    def _load_again(self) -> None:
        """In the colours of another theme; the reader stays where they are."""
        if self._is_loaded:
            bar = self.text.verticalScrollBar()
            place = bar.value() / max(1, bar.maximum())
            self._load()
            self.text.document().documentLayout().documentSize()
            bar.setValue(round(place * bar.maximum()))

    def open_link(self, link: QUrl) -> None:
        """Follows a link within the guide, or opens it in the system's browser."""
        if link.scheme() in ("http", "https"):
            QDesktopServices.openUrl(link)
        elif link.hasFragment():  # headings have no anchors in Qt's Markdown
            found = (block for block in self._headings() if anchor_of(block.text()) == link.fragment().lower())
            if (block := next(found, None)) is not None:
                self._show_block(block)

    def go_to_chapter(self, english: str) -> None:
        """Scrolls to the chapter with this title in the English guide, else to the start."""
        page = self._folder / f"{ENGLISH}.md"
        titles = [line[3:].strip() for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("## ")]
        chapters = [block for block in self._headings() if block.blockFormat().headingLevel() == _CHAPTER_LEVEL]
        if english in titles:  # chapters have the same order in all languages
            self._show_block(chapters[titles.index(english)])
        else:
            self.text.moveCursor(QTextCursor.MoveOperation.Start)

    def _headings(self) -> Iterator[QTextBlock]:
        block = self.text.document().begin()
        while block.isValid():
            if block.blockFormat().headingLevel():
                yield block
            block = block.next()

    def _show_block(self, block: QTextBlock) -> None:
        cursor = self.text.textCursor()
        cursor.setPosition(block.position())
        self.text.setTextCursor(cursor)
        layout = self.text.document().documentLayout()
        layout.documentSize()  # completes the layout, and with it the range of the scroll bar
        top = layout.blockBoundingRect(block).top()
        self.text.verticalScrollBar().setValue(round(top))

    def _show_pictures(self, in_language: str) -> None:
        """Scales screenshots down to the width of the text, and recolours the drawings for the theme."""
        document, theme, ratio = self.text.document(), current(), self.devicePixelRatioF()
        room_px_of_text = self.text.viewport().width() - 2 * round(document.documentMargin())
        room_px_of_lists = room_px_of_text - round(document.indentWidth())  # drawings stand in lists
        for picture in sorted((self._folder / "images").glob(f"*-{in_language}.*")):
            if picture.suffix == ".svg":
                svg = picture.read_text(encoding="utf-8").replace(_INK, theme.text).replace(_PAPER, theme.surface)
                image, room_px = QImage.fromData(svg.encode()), room_px_of_lists
            else:
                image, room_px = QImage(str(picture)), room_px_of_text
            if image.width() > room_px:
                image = image.scaledToWidth(round(room_px * ratio), Qt.TransformationMode.SmoothTransformation)
                image.setDevicePixelRatio(ratio)
            url = document.baseUrl().resolved(QUrl(f"images/{picture.name}"))
            document.addResource(QTextDocument.ResourceType.ImageResource.value, url, image)
        document.markContentsDirty(0, document.characterCount())


def anchor_of(heading: str) -> str:
    """The anchor of a heading as on GitHub: lower case, hyphens for spaces, no punctuation."""
    hyphened = heading.lower().replace(" ", "-")
    return "".join(letter for letter in hyphened if letter.isalnum() or letter in "-_")


_ALWAYS: Final = (
    ("Esc", marked("Close or cancel; never sends anything")),
    ("Tab", marked("Next control")),
    ("Alt", marked("Menu")),
)


def keys_of(window: QMainWindow) -> list[tuple[str, str, str]]:
    """Where each shortcut works (a page, or ""), the shortcut, and what it does, in the language in use."""
    keys = {("", key, tr(does)): None for key, does in _ALWAYS}
    for action in window.findChildren(QAction):
        does = action.text().replace("&&", "\0").replace("&", "").replace("\0", "&").rstrip(" …")
        keys[_page_of(action), _told(action.shortcuts()), does] = None
    for shortcut in window.findChildren(Shortcut):
        keys[_page_of(shortcut), _told(shortcut.keys()), name_of(shortcut.control)] = None
    return sorted((key for key in keys if key[1] and key[2]), key=lambda key: key[0])


def _told(keys: Sequence[QKeySequence]) -> str:
    return ", ".join(key.toString(QKeySequence.SequenceFormat.NativeText) for key in keys)


def _page_of(shortcut: QObject) -> str:
    """The title of the page that it is of; "" for one that works everywhere."""
    around = shortcut.parent()
    while around is not None and not isinstance(around, Page):
        around = around.parent()
    return "" if around is None else around.accessibleName()


class ShortcutsView(DocumentWindow):
    """One table, first what works everywhere."""

    def __init__(self, window: QMainWindow) -> None:
        super().__init__("keys_view", tr("Keyboard shortcuts"), window)
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
    box.setModal(False)
    box.setWindowTitle(tr("About"))
    box.setIconPixmap(app_icon().pixmap(QSize(64, 64)))
    box.setText(f"{tr('DPS-S Configurator')} {version()}")
    lines = [tr("MIT licence. Made with:"), f"Python {platform.python_version()} (PSF-2.0)"]
    for name, licence in _PARTS.items():
        with suppress(PackageNotFoundError):  # some bundles leave the metadata out
            lines.append(f"{name} {version_of(name)} ({licence})")
    box.setInformativeText("\n".join(lines))
    show_over_page(box)
    return box


class HelpActions(QObject):
    """Imports the windows of the help when they are first used."""

    def __init__(self, window: MainWindow, services: Services, entries: tuple[PageEntry, ...]) -> None:
        super().__init__(window)
        self._window, self._services, self._entries = window, services, entries
        self._guide: GuideViewer | None = None
        self._keys: ShortcutsView | None = None
        window.menus.add(
            "help",
            MenuEntry("guide", marked("User guide"), self.show_guide, "F1"),
            MenuEntry("keys", marked("Keyboard shortcuts"), self.show_keys, "Ctrl+F1"),
            None,
            MenuEntry("about", marked("About"), self.show_about),
        )

    # Documents

    def show_guide(self) -> None:

        if guide_page() is None:
            self._window.show_message(tr("The user guide is not installed."))
            return
        if self._guide is None:
            self._guide = GuideViewer(self._window)
        self._guide.bring_up()
        chosen = "" if self._window.panel.isVisible() else self._window.navigation.chosen
        chapter = next((entry.chapter for entry in self._entries if entry.key == chosen), "Connect")
        self._guide.go_to_chapter(chapter)

    def show_keys(self) -> None:

        if self._keys is None:
            self._keys = ShortcutsView(self._window)
        self._keys.bring_up()

    def show_about(self) -> None:

        show_about(self._window)
