"""Offers the tour once, before anything was ever connected."""

from collections.abc import Callable

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton, QVBoxLayout

from ui.services.context import Services
from ui.style.icons import Icon, icon
from ui.style.theme import Space
from ui.widgets.naming import named
from ui.widgets.text_labels import text_label


class TourOffer(QFrame):
    """`begin` is called at a click; declined, it is not made again. The Help menu keeps the tour."""

    def __init__(self, services: Services, begin: Callable[[], None]) -> None:
        super().__init__()
        self.setObjectName("live_tour_offer")
        self.setProperty("role", "card")
        self._remembered = services.preferences
        self._begin = begin
        texts = services.texts
        self.text = text_label("live_tour_text", "")
        self.take = named(QPushButton(), "live_tour")
        self.take.setIcon(icon(Icon.LIVE))
        self.take.setIconSize(QSize(16, 16))
        self.decline = named(QPushButton(), "live_tour_decline")
        self.decline.setProperty("role", "quiet")
        texts.bind(
            self.text.setText,
            "New here? The tour goes from the first connection to GO in a few minutes, on a simulated module.",
        )
        texts.bind(self.take.setText, "Take the tour")
        texts.bind(self.take.setAccessibleName, "Take the tour")
        texts.bind(self.take.setToolTip, "Eight steps through the real window, on a simulated module")
        texts.bind(self.decline.setText, "Not now")
        texts.bind(self.decline.setAccessibleName, "Do not take the tour now")
        texts.bind(self.decline.setToolTip, "The tour stays in the Help menu")
        self.take.clicked.connect(self._take)
        self.decline.clicked.connect(self._decline)
        buttons = QHBoxLayout()
        buttons.setSpacing(Space.S)
        buttons.addStretch(1)
        buttons.addWidget(self.decline)
        buttons.addWidget(self.take)
        column = QVBoxLayout(self)
        column.setContentsMargins(Space.M, Space.S, Space.M, Space.S)
        column.setSpacing(Space.S)
        column.addWidget(self.text)
        column.addLayout(buttons)

    def _take(self) -> None:
        self.hide()
        self._begin()

    def _decline(self) -> None:
        self._remembered.has_seen_tour = True
        self.hide()
