"""Modeless window that shows a document; Esc closes it."""

from PySide6.QtCore import QSize, Qt, QUrl
from PySide6.QtGui import QTextBlockFormat, QTextCursor
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QTextBrowser, QWidget

from ui.core.texts import Texts
from ui.style.theme import Space
from ui.widgets.controls import control, named
from ui.widgets.layouts import in_column

_SIZE = QSize(760, 520)


class DocumentWindow(QDialog):
    """`title` is English, marked. Shown again it is where the reader left it."""

    def __init__(self, name: str, title: str, texts: Texts, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.resize(_SIZE)
        self.text = control(QTextBrowser(), texts, f"{name}_text", says=title)
        self.text.setOpenExternalLinks(False)
        self.buttons = named(QDialogButtonBox(QDialogButtonBox.StandardButton.Close), f"{name}_buttons")
        self.buttons.rejected.connect(self.reject)
        texts.bind(self.setWindowTitle, title)
        texts.bind(self.setAccessibleName, title)
        close = self.buttons.button(QDialogButtonBox.StandardButton.Close)
        control(close, texts, f"{name}_close", "Close", key="Esc")
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
        bring_to_front(self)


def bring_to_front(window: QWidget) -> None:
    """Shows `window` above all others, also where it was minimised."""
    window.show()
    window.setWindowState(window.windowState() & ~Qt.WindowState.WindowMinimized)
    window.raise_()
    window.activateWindow()
