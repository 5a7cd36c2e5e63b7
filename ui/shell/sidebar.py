"""Sidebar with the pages: icons with words."""

from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem, QWidget

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.services.context import PageEntry
from ui.style.icons import icon

WIDTH_PX = 160
NARROW_PX = 60
ROW_PX = 40


class Sidebar(QListWidget):
    """One row a page; Ctrl+1 … Ctrl+9 reach them from anywhere."""

    page_wanted = Signal(str)

    def __init__(self, entries: tuple[PageEntry, ...], texts: Texts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("navigation")
        self.setProperty("role", "navigation")
        self.setFixedWidth(WIDTH_PX)
        self.setIconSize(QSize(18, 18))
        self.setViewMode(QListView.ViewMode.ListMode)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        texts.bind(self.setAccessibleName, "Pages")
        self._entries = entries
        self._is_narrow = False
        for entry in entries:
            item = QListWidgetItem(icon(entry.icon), "")
            item.setData(Qt.ItemDataRole.UserRole, entry.key)
            item.setSizeHint(QSize(0, ROW_PX))
            self.addItem(item)
        self._name_rows()
        self.currentItemChanged.connect(self._tell)

    def choose(self, key: str) -> bool:
        """Go to a page; whether there is one of that key."""
        for row in range(self.count()):
            if self.item(row).data(Qt.ItemDataRole.UserRole) == key:
                self.setCurrentRow(row)
                return True
        return False

    def be_narrow(self, is_narrow: bool) -> None:
        """Only the icons, where a panel beside the page leaves it little room; the words are in the tooltips."""
        if is_narrow != self._is_narrow:
            self._is_narrow = is_narrow
            self.setFixedWidth(NARROW_PX if is_narrow else WIDTH_PX)
            self._name_rows()

    @property
    def chosen(self) -> str:
        return str(self.currentIndex().data(Qt.ItemDataRole.UserRole) or "")

    def _tell(self, current: QListWidgetItem | None) -> None:
        if current is not None:
            self.page_wanted.emit(current.data(Qt.ItemDataRole.UserRole))

    def _name_rows(self) -> None:
        for row, entry in enumerate(self._entries):
            key = QKeySequence(f"Ctrl+{row + 1}").toString(QKeySequence.SequenceFormat.NativeText)
            title = tr(entry.title)
            self.item(row).setText("" if self._is_narrow else title)
            self.item(row).setData(Qt.ItemDataRole.AccessibleTextRole, title)
            self.item(row).setToolTip(tr("{page} ({key})", page=title, key=key))

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange:
            self._name_rows()
