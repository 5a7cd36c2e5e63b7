"""Shows the user guide `ui/help/guide/<language>.md`, which is installed with the program."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSize, Qt, QUrl
from PySide6.QtGui import QDesktopServices, QImage, QTextBlock, QTextCursor, QTextDocument
from PySide6.QtWidgets import QWidget

from app.text.i18n import ENGLISH, language
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.style.theme import Space, current, scaled
from ui.widgets.document_window import DocumentWindow
from ui.widgets.visibility_timer import VisibilityTimer

GUIDE: Final = Path(__file__).parent / "guide"
_WIDEST_PX: Final = 660
_INDENT_PX: Final = 40
"""Drawings stand in lists."""
_CHAPTER_LEVEL: Final = 2
_INK: Final = "#1a1c1e"
_PAPER: Final = "#ffffff"
"""Colours in the drawings, replaced by those of the theme."""


def guide_page(folder: Path = GUIDE) -> Path | None:
    """The guide in the language in use, else in English; None if neither is installed."""
    pages = (folder / f"{language()}.md", folder / f"{ENGLISH}.md")
    return next((page for page in pages if page.is_file()), None)


class GuideViewer(DocumentWindow):
    def __init__(self, texts: Texts, parent: QWidget, folder: Path = GUIDE) -> None:
        super().__init__("guide_viewer", marked("User guide"), texts, parent)
        self._folder = folder
        self._shown: Path | None = None
        self.text.setOpenLinks(False)
        self.text.anchorClicked.connect(self.open_link)
        self.refresh()
        VisibilityTimer(self, self.refresh, restyle=self._restyle)

    def refresh(self) -> None:
        """Loads the guide in the language in use, unless it is shown already."""
        page = guide_page(self._folder)
        if page is None or page == self._shown:
            return
        self._shown = page
        self.show_markdown(page.read_text(encoding="utf-8"), QUrl.fromLocalFile(f"{self._folder.as_posix()}/"))
        self._show_pictures()
        self.text.moveCursor(QTextCursor.MoveOperation.Start)

    def _restyle(self) -> None:
        """Loads the guide again in the colours and the size of text in use; the reader stays where they are."""
        bar = self.text.verticalScrollBar()
        place = bar.value() / max(1, bar.maximum())
        self._shown = None
        self.refresh()
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

    def _show_pictures(self) -> None:
        """Scales screenshots down to the width of the text, and recolours the drawings for the theme."""
        document, theme, ratio = self.text.document(), current(), self.devicePixelRatioF()
        for picture in sorted((self._folder / "images").glob("*")):
            if picture.suffix == ".svg":
                svg = picture.read_text(encoding="utf-8").replace(_INK, theme.text).replace(_PAPER, theme.surface)
                image, room_px = QImage.fromData(svg.encode()), self._room_px(_INDENT_PX)
            else:
                image, room_px = QImage(str(picture)), self._room_px()
            if image.width() > room_px:
                image = image.scaledToWidth(round(room_px * ratio), Qt.TransformationMode.SmoothTransformation)
                image.setDevicePixelRatio(ratio)
            url = document.baseUrl().resolved(QUrl(f"images/{picture.name}"))
            document.addResource(QTextDocument.ResourceType.ImageResource.value, url, image)
        document.markContentsDirty(0, document.characterCount())

    def _room_px(self, indent_px: int = 0) -> int:
        """The width of the widest picture that needs no scrolling sideways."""
        beside_px = self.text.verticalScrollBar().sizeHint().width() + 2 * round(self.text.document().documentMargin())
        return min(_WIDEST_PX, self.text.width() - beside_px - indent_px - Space.XL) if self.isVisible() else _WIDEST_PX

    def sizeHint(self) -> QSize:
        return QSize(_WIDEST_PX + scaled(96), 560)


def anchor_of(heading: str) -> str:
    """The anchor of a heading as on GitHub: lower case, hyphens for spaces, no punctuation."""
    hyphened = heading.lower().replace(" ", "-")
    return "".join(letter for letter in hyphened if letter.isalnum() or letter in "-_")
