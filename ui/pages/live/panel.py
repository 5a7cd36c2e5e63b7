"""Value panel of the Live page: gauge, tilt and everything else that is measured.

Each number is fresh, stale with its age, or unknown.  For a recording they are those of the instant under the
read-off cursor, below its time, and what belongs to the present is put away.  The column is as wide as the widest text
that can come up in the language in use, so that nothing moves while it is looked at.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QFrame, QGridLayout, QScrollArea, QSizePolicy, QVBoxLayout, QWidget

from app.diagnosis.link_state import duration
from app.engine.device import DeviceView, Known
from app.limits.out_of_limits import LimitsInUse, OutOfLimit, Outside, value_outside
from app.text.i18n import tr
from protocol.catalogue import BY_NAME, RESET_BELOW_THRESHOLD_DEG
from protocol.link_states import Presence
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.plots.gauge import TiltGauge
from ui.style.theme import Meaning, Size, Space, font
from ui.widgets.layouts import in_column, in_row
from ui.widgets.readout import Readout, StateChip

_SCROLL_BAR_PX: Final = 12
_GAUGE_PX: Final = 280
_COUNT_EVERY_S: Final = 0.5
"""A rate of reports that trembles by one is nothing to follow."""
# A column grows up to this for the ages beside the captions; beyond it, only captions and values count.
_NOTED_PX: Final = 168
_TOP_LEFT: Final = Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft
CELL: Final = marked("Cell voltage")
CHARGER: Final = marked("Charging voltage")
_CHARGING: Final = marked("charging")
_NOT_CHARGING: Final = marked("not charging")
OVER: Final = marked("over {value}°")
FALLING: Final = marked("free fall")
_POLLED: Final = marked("polled")
_STREAMED: Final = marked("streamed")
_NO_STREAM: Final = marked("no stream")


@dataclass(frozen=True, slots=True)
class PanelLimits:
    """What the module fires at, as it said itself; None while that is not known or switched off."""

    fires_deg: float | None
    falls_g: float | None
    light_v: float | None


class LivePanel(QFrame):
    """Shows; decides nothing but what is stale."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("live_panel")
        self.setProperty("role", "card")
        self.gauge = TiltGauge()
        self.gauge.setObjectName("live_gauge")
        self.tilt = _readout("live_tilt", "°", "000", Size.HERO)
        self.acceleration = _readout("live_acceleration", "g", "00.0")
        self.light = _readout("live_light", "V", "0.0")
        self.cell = _readout("live_cell", "V", "0.00")
        self.charge = _readout("live_charge", "", "", Size.TITLE)
        self.boot_count = _readout("live_boot_count", "", "000")
        self.stream = _readout("live_stream", "/s", "0000")
        self.moment = StateChip("")
        self.moment.setObjectName("live_moment")
        self.activation = StateChip("", size=Size.SMALL)
        self.activation.setObjectName("live_activation")
        self.trigger = StateChip("", size=Size.SMALL)
        self.trigger.setObjectName("live_trigger")
        for widget in (self.gauge, self.tilt, *self._cells):
            widget.lie_on_surface()
        self._stream_kind: tuple[bool, Presence] | None = None
        self._counted_at = 0.0
        self._is_recorded = False
        self._cell_caption = CELL
        self._texts = texts
        self._name(texts)
        self._lay_out()
        self._show_kind()
        self._reserve()

    def be_recorded(self, *, is_recorded: bool) -> None:
        """Show moments of a recording from now on, or the module as it is."""
        if is_recorded != self._is_recorded:
            self._is_recorded = is_recorded
            self._show_kind()
            self._name(self._texts)

    def _show_kind(self) -> None:
        for one in (self.moment, self.activation, self.trigger):
            one.setVisible(self._is_recorded)
        for readout in (self.charge, self.boot_count, self.stream):
            readout.setVisible(not self._is_recorded)
        # One row more has to find room.
        self._column.setSpacing(Space.XS if self._is_recorded else Space.S)
        # Out of sight nobody else tells the layouts: they would be shown in the height that they had before.
        self._grid.invalidate()
        self._column.invalidate()
        self.body.updateGeometry()

    def show_device(
        self, device: DeviceView, now_s: float, *, limits: PanelLimits, in_use: LimitsInUse, reports_per_s: float
    ) -> None:
        """Everything as it is known at a monotonic time."""
        self._show_tilt(device.known("tilt_deg", now_s), now_s, limits.fires_deg)
        acceleration = device.known("acceleration_g", now_s)
        is_falling = (
            acceleration is not None and limits.falls_g is not None and float(acceleration.value) < limits.falls_g
        )
        _show(self.acceleration, acceleration, now_s, 1, Meaning.DANGER if is_falling else None, FALLING)
        light, cell = (value_outside(key, device, now_s, in_use) for key in ("light_v", "cell_voltage_v"))
        self.light.set_limit("" if limits.light_v is None else f"{limits.light_v:.1f} V")
        _show_outside(self.light, device.known("light_v", now_s), now_s, 1, light)
        charging = device.known("charging", now_s)
        self.name_cell(CHARGER if charging is not None and charging.value is True else CELL)
        self.cell.set_limit("" if cell is None else cell.limit)
        _show_outside(self.cell, device.known("cell_voltage_v", now_s), now_s, 2, cell)
        self._show_charge(charging, now_s)
        _show(self.boot_count, device.known("boot_count", now_s), now_s, 0)
        self._show_stream(device, now_s, reports_per_s)

    def _show_tilt(self, known: Known | None, now_s: float, fires_deg: float | None) -> None:
        self.gauge.set_threshold(
            fires_deg, reset_deg=None if fires_deg is None else fires_deg - RESET_BELOW_THRESHOLD_DEG
        )
        if known is None:
            self.gauge.show_unknown()
            self.tilt.show_unknown()
            return
        tilt_deg = float(known.value)
        if known.is_stale:
            self.gauge.show_stale(tilt_deg, _age(known, now_s))
            self.tilt.show_stale(f"{tilt_deg:.0f}", _age(known, now_s))
            return
        self.gauge.show_tilt(tilt_deg)
        if fires_deg is not None and tilt_deg >= fires_deg:
            note = tr(OVER, value=f"{fires_deg:g}")
            self.tilt.show_value(f"{tilt_deg:.0f}", meaning=Meaning.DANGER, note=note)
        else:
            self.tilt.show_value(f"{tilt_deg:.0f}")

    def _show_charge(self, known: Known | None, now_s: float) -> None:
        if known is None:
            self.charge.show_unknown()
            return
        word = tr(_CHARGING if known.value is True else _NOT_CHARGING)
        if known.is_stale:
            self.charge.show_stale(word, _age(known, now_s))
        else:
            self.charge.show_value(word)

    def _show_stream(self, device: DeviceView, now_s: float, reports_per_s: float) -> None:
        kind = device.is_streaming, device.presence
        if kind == self._stream_kind and now_s - self._counted_at < _COUNT_EVERY_S:
            return
        self._stream_kind, self._counted_at = kind, now_s
        if device.is_streaming:
            self.stream.show_value(f"{device.stream_hz:.0f}", note=tr(_STREAMED))
        elif device.presence is Presence.ONLINE and reports_per_s > 0:
            self.stream.show_value(f"{reports_per_s:.0f}", note=tr(_POLLED))
        else:
            self.stream.show_value("0", note=tr(_NO_STREAM))

    def name_cell(self, caption: str) -> None:
        """``CELL`` or ``CHARGER``: what the voltage is of."""
        if caption != self._cell_caption:
            self._cell_caption = caption
            self._texts.bind(self.cell.set_caption, caption)

    # Making

    def _name(self, texts: Texts) -> None:
        texts.bind(self.setAccessibleName, "Recorded values" if self._is_recorded else "Measured values")
        texts.bind(self.moment.set_caption, "Time under the cursor")
        texts.bind(self.activation.set_caption, "Activation")
        texts.bind(self.trigger.set_caption, "Trigger")
        texts.bind(self.tilt.set_caption, "Tilt")
        texts.bind(self.acceleration.set_caption, "Acceleration")
        texts.bind(self.light.set_caption, "Light")
        texts.bind(self.cell.set_caption, self._cell_caption)
        texts.bind(self.charge.set_caption, "Charger")
        texts.bind(self.boot_count.set_caption, "Boot count")
        texts.bind(self.stream.set_caption, "Reports")
        texts.bind(self.tilt.setToolTip, "Angle between aircraft and horizontal plane")
        texts.bind(self.acceleration.setToolTip, "1 g at rest, near 0 g in free fall")
        texts.bind(self.stream.setToolTip, "Status reports a second: streamed by the module, or polled")
        for readout, command in (
            (self.light, "light"),
            (self.cell, "cell_voltage"),
            (self.charge, "charging"),
            (self.boot_count, "boot_count"),
        ):
            texts.bind(readout.setToolTip, BY_NAME[command].explanation)
        for readout, command in (
            (self.tilt, "attitude_threshold"),
            (self.acceleration, "freefall_acceleration"),
            (self.light, "light_threshold"),
            (self.cell, "cell_voltage"),
            (self.charge, "charging"),
            (self.boot_count, "boot_count"),
            (self.stream, "serial_output"),
        ):
            entry = BY_NAME[command]
            term = "{title} ({term}): {explanation}"
            readout.setWhatsThis(
                term.format(title=tr(entry.title), term=entry.vendor_term, explanation=tr(entry.explanation))
            )

    def _lay_out(self) -> None:
        self.body = QWidget()
        self.body.setObjectName("live_numbers")
        column = self._column = QVBoxLayout(self.body)
        column.setContentsMargins(Space.S, Space.S, 0, Space.S)
        column.setSpacing(Space.S)
        # It takes the height that the numbers leave, and gives it back first.
        self.gauge.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        column.addWidget(self.moment)
        column.addWidget(self.gauge, 1)
        column.addWidget(self.tilt)
        self._grid = QGridLayout()
        self._grid.setHorizontalSpacing(Space.S)
        self._grid.setVerticalSpacing(Space.S)
        for number, readout in enumerate(self._cells):
            self._grid.addWidget(readout, number // 2, number % 2, _TOP_LEFT)
        column.addLayout(self._grid)
        chips = in_row(self.activation, self.trigger, 1, spacing=Space.S)
        column.addLayout(chips)
        column.addStretch(0)
        area = QScrollArea()
        area.setObjectName("live_scroll")
        area.setWidgetResizable(True)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setWidget(self.body)
        area.viewport().setAutoFillBackground(False)
        self.body.setAutoFillBackground(False)
        in_column(area, of=self, margins=1)

    @property
    def _cells(self) -> tuple[Readout, ...]:
        return (self.acceleration, self.light, self.cell, self.charge, self.boot_count, self.stream)

    def _reserve(self) -> None:
        """Make the columns as wide as anything that may stand in them."""
        small, body = QFontMetricsF(font(Size.SMALL)), QFontMetricsF(font(Size.BODY))
        title, number = QFontMetricsF(font(Size.TITLE, is_bold=True)), QFontMetricsF(font(Size.NUMBER, is_bold=True))
        age = tr("{time} ago", time=tr("{value:.0f} min", value=10))
        left_heads = (
            (tr("Acceleration"), (tr(FALLING), age)),
            (tr("Boot count"), (age,)),
            (tr(CELL), (age,)),
            # With an age of seconds: for longer ones it would set the width of everything.
            (tr(CHARGER), (tr("{time} ago", time=tr("{value:.0f} s", value=9)),)),
        )
        right_heads = (
            (tr("Light"), (age, f"{tr(OutOfLimit.BAY_OPEN.value)}    ")),
            (tr("Charger"), (age,)),
            (tr("Reports"), (tr(_STREAMED), tr(_POLLED), tr(_NO_STREAM))),
        )
        light_px = number.horizontalAdvance("0.0") + Space.XS + Space.S + body.horizontalAdvance("V/ 0.0 V")
        cell_px = number.horizontalAdvance("0.00") + Space.XS + Space.S + body.horizontalAdvance("V/ 0.00 V")
        values_px = (
            max(cell_px, number.horizontalAdvance("00.0") + Space.XS + body.horizontalAdvance("V")),
            max(light_px, *(title.horizontalAdvance(tr(word)) for word in (_CHARGING, _NOT_CHARGING))),
        )
        body_px = int(Space.S)
        for column, heads in enumerate((left_heads, right_heads)):
            captions_px = max(small.horizontalAdvance(caption) for caption, _ in heads)
            noted_px = min(_NOTED_PX, _widest(small, heads))
            width_px = round(max(captions_px, values_px[column], noted_px)) + 4
            for one in self._cells[column::2]:
                one.setFixedWidth(width_px)
            body_px += width_px
        self.gauge.setMinimumHeight(self.gauge.minimumSizeHint().height())
        self.gauge.setMaximumHeight(self.gauge.heightForWidth(min(body_px, _GAUGE_PX)))
        self.setFixedWidth(body_px + Space.S + _SCROLL_BAR_PX + 4)

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() in (QEvent.Type.FontChange, QEvent.Type.StyleChange, QEvent.Type.LanguageChange):
            if hasattr(self, "_grid"):
                self._reserve()
            if event.type() is QEvent.Type.LanguageChange:
                self._stream_kind = None
                self._name(self._texts)


def _readout(name: str, unit: str, template: str, size: Size = Size.NUMBER) -> Readout:
    one = Readout("", unit=unit, template=template, size=size)
    one.setObjectName(name)
    return one


def _show(
    readout: Readout, known: Known | None, now_s: float, decimals: int, meaning: Meaning | None = None, note: str = ""
) -> None:
    if known is None:
        readout.show_unknown()
        return
    text = f"{float(known.value):.{decimals}f}"
    if known.is_stale:
        readout.show_stale(text, _age(known, now_s))
    else:
        readout.show_value(text, meaning=meaning, note=tr(note) if meaning is not None else "")


def _show_outside(readout: Readout, known: Known | None, now_s: float, decimals: int, outside: Outside | None) -> None:
    """The limit itself stands beside the number."""
    if outside is None:
        _show(readout, known, now_s, decimals)
    else:
        _show(readout, known, now_s, decimals, Meaning.ATTENTION, outside.fault.value)


def _age(known: Known, now_s: float) -> str:
    return tr("{time} ago", time=duration(now_s - known.at))


def _widest(metrics: QFontMetricsF, heads: Iterable[tuple[str, Iterable[str]]]) -> float:
    """Of captions with any of their notes beside them."""
    return max(metrics.horizontalAdvance(caption + note) for caption, notes in heads for note in notes) + Space.S
