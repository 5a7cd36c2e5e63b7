"""Offers the tour once, before anything was ever connected."""

from collections.abc import Callable

from PySide6.QtWidgets import QFrame, QPushButton

from ui.services.context import Services
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row


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
        self.take = control(QPushButton(), texts, "live_tour", "Take the tour",
                            tip="Eight steps on a simulated module", picture=Icon.LIVE,
                            slot=self._take)  # fmt: skip
        self.decline = control(QPushButton(), texts, "live_tour_decline", "Not now", says="Do not take the tour now",
                               tip="It stays in the Help menu", role="quiet", slot=self._decline)  # fmt: skip
        texts.bind(
            self.text.setText,
            "New here? Take a tour on a simulated module.",
        )
        buttons = in_row(1, self.decline, self.take, spacing=Space.S)
        in_column(self.text, buttons, of=self, spacing=Space.S, margins=(Space.M, Space.S))

    def _take(self) -> None:
        self.hide()
        self._begin()

    def _decline(self) -> None:
        self._remembered.has_seen_tour = True
        self.hide()
