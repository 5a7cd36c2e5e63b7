"""The room of the pages: one is in sight, and it scrolls where the window is smaller than the page can be.

When a notice above it comes or goes, the page moves. A click that was meant for what was there a moment before does
nothing then, unless it is LOCK or a step, which tells such a click by itself.
"""

from PySide6.QtCore import QPoint, QRect, QSize, Qt, QTimer
from PySide6.QtGui import QMoveEvent, QRegion, QResizeEvent
from PySide6.QtWidgets import QAbstractButton, QFrame, QScrollArea, QStackedWidget, QWidget

from ui.widgets.controls import IS_LOCK
from ui.widgets.naming import named
from ui.widgets.step_button import DEAD_FOR_S, StepButton


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


class _Shield(QWidget):
    """Takes the clicks on what it covers, for half a second. It covers neither LOCK nor steps."""

    def __init__(self, area: QWidget) -> None:
        super().__init__(area)
        self.setObjectName("page_shield")
        self._area = area
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(round(DEAD_FOR_S * 1000))
        self._timer.timeout.connect(self.hide)
        self.hide()

    def cover(self) -> None:
        self.fit()
        self.raise_()
        self.show()
        self._timer.start()

    def fit(self) -> None:
        """To what it covers as that lies now."""
        self.setGeometry(self._area.rect())
        covered = QRegion(self.rect())
        for button in self._area.findChildren(QAbstractButton):
            if button.isVisible() and (isinstance(button, StepButton) or button.property(IS_LOCK)):
                covered -= QRegion(QRect(button.mapTo(self._area, QPoint()), button.size()))
        self.setMask(covered)


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
        self.shield = _Shield(self)

    def moveEvent(self, event: QMoveEvent) -> None:
        super().moveEvent(event)
        if self.isVisible() and event.pos().y() != event.oldPos().y():
            self.shield.cover()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self.shield.isVisible():
            self.shield.fit()

    @property
    def holders(self) -> tuple[QWidget, ...]:
        """What has nothing to show of its own; the last one holds the pages."""
        return (self, self.viewport(), self.holder, self.stack)
