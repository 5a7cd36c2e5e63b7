"""The area that shows one page, and scrolls where the window is smaller than the page's minimum size."""

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QScrollArea, QStackedWidget, QWidget

from ui.widgets.naming import named


class _Holder(QWidget):
    """Holds the stack without a layout, which would ask for the minimum size of all pages."""

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
        """The widgets around the pages, from the outside in."""
        return (self, self.viewport(), self.holder, self.stack)
