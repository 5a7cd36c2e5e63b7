""" "Would it have fired?" on the Live page: a button in its header, and a panel beside the plots."""

from collections.abc import Mapping
from math import inf

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QToolButton, QWidget

from app.firing.what_if_drafts import ATTITUDE_THRESHOLD, FREEFALL_ACCELERATION, FREEFALL_TIME, TRIED, SettingSource
from app.recordings.recording import Recording
from app.samples.step_function import StepFunction
from ui.pages.live.data import LiveData
from ui.pages.live.what_if_panel import WIDTH_PX, WhatIfPanel
from ui.services.context import Services
from ui.style.icons import Icon
from ui.widgets.controls import control


class WhatIfOnLive(QObject):
    """The page adds `panel` and `button` to its layout."""

    def __init__(self, services: Services, page: QWidget) -> None:
        super().__init__(page)
        self._connector = services.connector
        self._recording: Recording | None = None
        self.panel = WhatIfPanel(services)
        self.panel.hide()
        self.panel.setFixedWidth(WIDTH_PX)
        self.button = control(QToolButton(), services.texts, "live_would_fire", "Would it have fired?", key="Ctrl+T",
                              picture=Icon.PARACHUTE, is_checkable=True)  # fmt: skip
        self.button.toggled.connect(self._show)
        self.panel.closed.connect(lambda: self.button.setChecked(False))
        services.exchange.tried.connect(self._try)

    def bind_module(self, data: LiveData, *, wall_offset_s: float) -> None:
        """Judges the values of the module."""
        self._recording = None
        self.panel.bind(data, wall_offset_s=wall_offset_s)

    def bind_recording(self, recording: Recording) -> None:
        """Judges the values of `recording`."""
        self._recording = recording
        self.panel.bind(recording, wall_offset_s=recording.wall_offset_s)

    def refresh(self) -> None:
        """Called a few times a second while the page is visible."""
        if self.button.isChecked():
            self.panel.refresh(self._standing())

    def _show(self, is_open: bool) -> None:
        self.panel.setVisible(is_open)
        self.refresh()
        if is_open:
            self.panel.fields.editors[ATTITUDE_THRESHOLD.key].setFocus()
        else:
            self.button.setFocus()
            if self.panel.lines.show(None, None):
                self.panel.lines_changed.emit()

    def _try(self, values: object) -> None:
        """Takes drafts from Settings."""
        if isinstance(values, Mapping):
            self.panel.open_with(values)
            self.button.setChecked(True)

    def _standing(self) -> Mapping[str, SettingSource]:
        if self._recording is not None:
            return _recorded(self._recording)
        device, now_s = self._connector.device, self._connector.clock()
        known = {command.key: device.known(command.key, now_s) for command in TRIED}
        return {key: SettingSource(one.value, one.is_stale) for key, one in known.items() if one is not None}


def _recorded(recording: Recording) -> Mapping[str, SettingSource]:
    """The module's last thresholds in a recording."""
    last = {
        ATTITUDE_THRESHOLD.key: _last_value(recording.fires),
        FREEFALL_ACCELERATION.key: _last_value(recording.falls),
        FREEFALL_TIME.key: _last_value(recording.fall_times),
    }
    return {key: SettingSource(value) for key, value in last.items() if value is not None}


def _last_value(steps: StepFunction) -> float | None:
    values = [change.value for change in steps.between(-inf, inf) if change.value is not None]
    return values[-1] if values else None
