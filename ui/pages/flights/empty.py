"""The Flight logs page before the first file."""

from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.widgets.empty_state import EmptyState


class NoFlights(EmptyState):
    def __init__(self, texts: Texts) -> None:
        super().__init__("flights_empty", Icon.MAP)
        texts.bind(self.title.setText, "No flight logs yet")
        texts.bind(self.text.setText, "Open logs of PX4, ArduPilot, CSV or recordings, or drop them here.")
