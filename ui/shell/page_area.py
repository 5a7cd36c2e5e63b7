"""The room of the pages: one is in sight, and it scrolls where the window is smaller than the page can be."""

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QScrollArea, QStackedWidget, QWidget

from ui.widgets.naming import named


class _Holder(QWidget):
    """Gives the stack its room. It has no layout: that of a stack would ask for the room of all pages at once."""

    def __init__(self, stack: QStackedWidget) -> None:
        super().__init__()
        self._stack = stack
        stack.setParent(self)
        stack.currentChanged.connect(self.updateGeometry)

    def minimumSizeHint(self) -> QSize:
        page = self._stack.currentWidget()
        return QSize() if page is None else page.minimumSizeHint().expandedTo(page.minimumSize())

    def sizeHint(self) -> QSize:
        return self.minimumSizeHint()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._stack.setGeometry(self.rect())


class PageArea(QScrollArea):
    """`stack` holds the pages."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("page_area")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.stack = named(QStackedWidget(), "pages")
        self.holder = named(_Holder(self.stack), "page_holder")
        self.setWidget(self.holder)
        self.viewport().setAutoFillBackground(False)
        self.holder.setAutoFillBackground(False)

    @property
    def holders(self) -> tuple[QWidget, ...]:
        """What has nothing to show of its own; the last one holds the pages."""
        return (self, self.viewport(), self.holder, self.stack)
