"""Header of a page: its title at the left, its actions at the right, what is rare in a menu."""

from typing import Final

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QSizePolicy, QToolButton, QWidget

from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Space, scaled
from ui.widgets.controls import control
from ui.widgets.layouts import in_row
from ui.widgets.naming import named
from ui.widgets.visibility_timer import VisibilityTimer

HEIGHT_PX: Final = 40


class PageHeader(QWidget):
    """`name` is the page's key, `title` its English title, marked. The same height on every page."""

    def __init__(self, name: str, texts: Texts, title: str, *actions: QWidget) -> None:
        super().__init__()
        self.setObjectName(f"{name}_header")
        self._name, self._texts = name, texts
        self.title = control(QLabel(), texts, f"{name}_title", title, role="title")
        self._menu: QMenu | None = None
        self.more = control(QToolButton(), texts, f"{name}_more", says="More", picture=Icon.MORE,
                            role="quiet")  # fmt: skip
        self.more.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.more.hide()
        self.row: QHBoxLayout = in_row((self.title, 1), self.more, of=self, spacing=Space.S, margins=0)
        VisibilityTimer(self, self._fit, restyle=self._fit)
        self._fit()
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        for action in actions:
            self.add(action)

    def _fit(self) -> None:
        self.setMinimumHeight(scaled(HEIGHT_PX))

    def add(self, action: QWidget) -> None:
        """One more action, at the right of those that are there."""
        self.row.removeWidget(self.more)
        self.more.setParent(None)  # added again it is the last for Tab, too
        self.row.addWidget(action)
        self.row.addWidget(self.more)
        self.more.setVisible(self._menu is not None)

    def add_rare(self, name: str, text: str, slot: object) -> QAction:
        """An entry of the menu behind "⋯"; `text` is English, marked."""
        if self._menu is None:
            self._menu = named(QMenu(self), f"{self._name}_more_menu")
            self.more.setMenu(self._menu)
            self.more.show()
        action = named(QAction(self), name)
        self._texts.bind(action.setText, text)
        action.triggered.connect(slot)
        self._menu.addAction(action)
        return action
