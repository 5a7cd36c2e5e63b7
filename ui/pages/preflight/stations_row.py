"""Row with this station's fingerprint and the known stations."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QWidget

from app.stations.known import KnownStation, Stations
from app.text.i18n import tr
from app.text.sentences import error_text
from app.text.user_error import UserError
from ui.core.texts import Texts
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.layouts import in_row
from ui.widgets.naming import named
from ui.widgets.sliders import WheelGuard


class StationsRow(QWidget):
    """`refresh` reads the key and the list."""

    def __init__(self, folder: Callable[[], Path], texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        self.setObjectName("stations_row")
        self._folder = folder
        self.own = named(QLabel(), "station_own", "muted")
        self.own.setTextFormat(Qt.TextFormat.PlainText)
        self.own.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.known = control(QComboBox(), texts, "stations_known", says="Known stations")
        self.known.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        guard.guard(self.known)
        self.forget = control(QPushButton(), texts, "stations_forget", "Forget", slot=self._remove)
        in_row((self.own, 1), self.known, self.forget, of=self, spacing=Space.S, margins=0)

    def refresh(self) -> None:
        stations = Stations(self._folder())
        try:
            stations.make_own()
        except UserError as trouble:
            self.own.setText(trouble.sentence)
        self.known.clear()
        for one in stations.known():
            if one.is_own:
                self.own.setText(tr("This station: {fingerprint}", fingerprint=one.fingerprint))
            else:
                revoked = f" · {tr('revoked')}" if one.is_revoked else ""
                self.known.addItem(f"{one.name} · {one.fingerprint}{revoked}", one)
        self.forget.setEnabled(self.known.count() > 0)
        if not self.known.count():
            self.known.addItem(tr("none"), None)
        self.known.setEnabled(self.forget.isEnabled())

    def _remove(self) -> None:
        chosen = self.known.currentData()
        if isinstance(chosen, KnownStation):
            try:
                Stations(self._folder()).remove(chosen.fingerprint)
            except OSError as error:
                self.own.setText(error_text(error))
                return
            self.refresh()
