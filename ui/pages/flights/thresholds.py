"""Sliders for the thresholds, and the reading of the vendor's rule."""

from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QComboBox, QGridLayout, QLabel, QSizePolicy, QWidget

from app.firing.judge import TriggerLimits
from app.flight_logs.module_view import RuleReading
from app.text.i18n import tr
from protocol.catalogue import BY_NAME
from protocol.fields import Value
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.pages.flights.texts import READING_WORDS, THRESHOLD_KEYS
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.sliders import Dial, WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_TILTS_DEG: Final = (0, 180)
_ACCELERATIONS_G: Final = (0.0, 1.5)
_TIMES_S: Final = (0.0, 2.55)
"""What a module can have; above 1.5 g all would be a fall."""


class ThresholdPanel(QWidget):
    chosen = Signal(object)
    """`TriggerLimits`."""
    reading_chosen = Signal(object)
    """`RuleReading`."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("flights_thresholds")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._limits = TriggerLimits()
        self.tilt = Dial("flights_tilt", minimum=_TILTS_DEG[0], maximum=_TILTS_DEG[1], step=1, unit="°")
        self.acceleration = Dial("flights_acceleration", minimum=_ACCELERATIONS_G[0], maximum=_ACCELERATIONS_G[1],
                                 step=0.1, unit=" g", decimals=1)  # fmt: skip
        self.time = Dial("flights_time", minimum=_TIMES_S[0], maximum=_TIMES_S[1], step=0.01, unit=" s")
        self.reading = control(QComboBox(), texts, "flights_reading", says="Interpretation")
        for reading in RuleReading:
            self.reading.addItem("", reading)
        WheelGuard(self.reading)
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(Space.S)
        grid.setVerticalSpacing(Space.XS)
        rows = (
            ("attitude_threshold", marked("Attitude"), self.tilt),
            ("freefall_acceleration", marked("Free fall below"), self.acceleration),
            ("freefall_time", marked("Free-fall time"), self.time),
        )
        for row, (name, title, dial) in enumerate(rows):
            label = control(QLabel(), texts, f"{dial.objectName()}_label", title)
            label.setBuddy(dial)
            dial.describe(texts, BY_NAME[name].title, BY_NAME[name].explanation)
            grid.addWidget(label, row, 0)
            grid.addWidget(dial, row, 1)
        grid.setColumnStretch(1, 1)
        self.tilt.turned.connect(lambda value: self._choose(self._limits._replace(attitude_threshold_deg=value)))
        self.acceleration.turned.connect(
            lambda value: self._choose(self._limits._replace(freefall_acceleration_g=round(value, 1)))
        )
        self.time.turned.connect(lambda value: self._choose(self._limits._replace(freefall_time_s=round(value, 2))))
        self.reading.currentTextChanged.connect(self.reading.setToolTip)  # the header may elide the text
        self.reading.activated.connect(lambda _row: self.reading_chosen.emit(self.reading.currentData()))
        VisibilityTimer(self, retranslate=self._name_readings)
        self._name_readings()

    def show_limits(self, limits: TriggerLimits, reading: RuleReading) -> None:
        self._limits = limits
        self.tilt.set_value(limits.attitude_threshold_deg)
        self.acceleration.set_value(limits.freefall_acceleration_g)
        self.time.set_value(limits.freefall_time_s)
        with QSignalBlocker(self.reading):
            self.reading.setCurrentIndex(self.reading.findData(reading, Qt.ItemDataRole.UserRole))

    def nearest(self, values: Mapping[str, Value]) -> TriggerLimits:
        """The vendor's defaults replaced by these, by the setting's key, as the sliders can show them."""
        dials = self.tilt, self.acceleration, self.time
        for dial, key, usual in zip(dials, THRESHOLD_KEYS, TriggerLimits(), strict=False):
            dial.set_value(float(values.get(key, usual)))
        return TriggerLimits(self.tilt.value, self.acceleration.value, self.time.value)

    def _choose(self, limits: TriggerLimits) -> None:
        self._limits = limits
        self.chosen.emit(limits)

    def _name_readings(self) -> None:
        for row, reading in enumerate(RuleReading):
            self.reading.setItemText(row, tr(READING_WORDS[reading]))
            self.reading.setItemData(row, tr(reading.value), Qt.ItemDataRole.ToolTipRole)
