"""Windows of the help: the user guide and the about box. Both are modeless: LOCK stays within reach."""

import platform
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSize, Qt, QUrl, qVersion
from PySide6.QtGui import (
    QDesktopServices,
    QImage,
    QTextBlock,
    QTextBlockFormat,
    QTextCursor,
    QTextDocument,
    QTextOption,
)
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QMessageBox, QTextBrowser, QVBoxLayout, QWidget

from app import version
from app.text.i18n import ENGLISH, language, tr
from ui.files.file_dialogs import show_over_page
from ui.style.icons import app_icon
from ui.style.theme import Space, current
from ui.widgets.controls import named

GUIDE: Final = Path(__file__).parent / "guide"
_CHAPTER_LEVEL: Final = 2
# Colours in the drawings, replaced by those of the theme.
_INK: Final = "#1a1c1e"
_PAPER: Final = "#ffffff"


class GuideViewer(QDialog):
    """The guide in the language in use, else in English."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("guide_viewer")
        self.setWindowTitle(tr("User guide"))
        self.setAccessibleName(tr("User guide"))
        self.text = named(QTextBrowser(), "guide_viewer_text", says=tr("User guide"))
        self.text.setOpenLinks(False)
        self.text.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        self.text.setWordWrapMode(QTextOption.WrapMode.WrapAtWordBoundaryOrAnywhere)
        self.text.anchorClicked.connect(self._open_link)
        buttons = named(QDialogButtonBox(QDialogButtonBox.StandardButton.Close), "guide_viewer_buttons")
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.addWidget(self.text, 1)
        column.addWidget(buttons)

    def open_at(self, english: str) -> bool:
        """Shows it at the chapter with this title in the English guide, else at its start; whether it is installed."""
        pages = [page for name in (language(), ENGLISH) if (page := GUIDE / f"{name}.md").is_file()]
        if not pages:
            return False
        show_over_page(self, is_large=True)
        # Anew each time: the pictures are as wide as the window is, and in the colours of the theme.
        self._load(pages[0])
        lines = pages[-1].read_text(encoding="utf-8").splitlines()
        titles = [line[3:].strip() for line in lines if line.startswith("## ")]
        chapters = [block for block in self._headings() if block.blockFormat().headingLevel() == _CHAPTER_LEVEL]
        if english in titles:  # chapters have the same order in all languages
            self._show_block(chapters[titles.index(english)])
        return True

    def _load(self, page: Path) -> None:
        document = self.text.document()
        document.setBaseUrl(QUrl.fromLocalFile(f"{GUIDE.as_posix()}/"))
        document.setMarkdown(page.read_text(encoding="utf-8"))
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
        theme, ratio = current(), self.devicePixelRatioF()
        # Also where one stands in a list.
        room_px = self.text.viewport().width() - 2 * round(document.documentMargin()) - round(document.indentWidth())
        for picture in sorted((GUIDE / "images").glob(f"*-{page.stem}.*")):
            if picture.suffix == ".svg":
                svg = picture.read_text(encoding="utf-8").replace(_INK, theme.text).replace(_PAPER, theme.surface)
                image = QImage.fromData(svg.encode())
            else:
                image = QImage(str(picture))
            if image.width() > room_px:
                image = image.scaledToWidth(round(room_px * ratio), Qt.TransformationMode.SmoothTransformation)
                image.setDevicePixelRatio(ratio)
            url = document.baseUrl().resolved(QUrl(f"images/{picture.name}"))
            document.addResource(QTextDocument.ResourceType.ImageResource.value, url, image)
        document.markContentsDirty(0, document.characterCount())
        self.text.moveCursor(QTextCursor.MoveOperation.Start)

    def _open_link(self, link: QUrl) -> None:
        """Follows a link within the guide, or opens it in the system's browser."""
        if link.scheme() in ("http", "https"):
            QDesktopServices.openUrl(link)
        elif link.hasFragment():  # headings have no anchors in Qt's Markdown
            found = (block for block in self._headings() if anchor_of(block.text()) == link.fragment().lower())
            if (block := next(found, None)) is not None:
                self._show_block(block)

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
        self.text.verticalScrollBar().setValue(round(layout.blockBoundingRect(block).top()))


def anchor_of(heading: str) -> str:
    """The anchor of a heading as on GitHub: lower case, hyphens for spaces, no punctuation."""
    hyphened = heading.lower().replace(" ", "-")
    return "".join(letter for letter in hyphened if letter.isalnum() or letter in "-_")


def show_guide(window: QWidget, chapter: str) -> bool:
    """Show the guide, in one viewer a window. Returns whether it is installed."""
    return (window.findChild(GuideViewer) or GuideViewer(window)).open_at(chapter)


def show_about(window: QWidget) -> None:
    box = named(QMessageBox(window), "about_box")
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setModal(False)
    box.setWindowTitle(tr("About"))
    box.setIconPixmap(app_icon().pixmap(QSize(64, 64)))
    box.setText(f"{tr('DPS-S Configurator')} {version()}")
    parts = f"Python {platform.python_version()} (PSF-2.0)\nQt {qVersion()}, PySide6 (LGPL-3.0-only)"
    box.setInformativeText(f"{tr('MIT licence. Made with:')}\n{parts}")
    show_over_page(box)
