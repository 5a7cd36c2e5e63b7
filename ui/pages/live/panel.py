"""Tiles of the Live page: tilt with its gauge, acceleration, light, cell, reports, boot count, in one row.

Each number is fresh, stale with its age, or unknown.
"""

from typing import Final

from PySide6.QtWidgets import QFrame

from app.engine.conversation import ConversationView, Known
from app.limits.limits import LimitsInUse, OutOfLimit, bay_outside, value_outside
from app.procedures.light import LightDirection
from app.recordings.markers import NO_LIMITS, ModuleLimits
from app.safety.last_known import TRIGGER_NOT_KNOWN, TRIGGER_OFF, trigger_flags
from app.text.i18n import tr
from protocol.catalogue import BY_NAME, RESET_BELOW_THRESHOLD_DEG
from protocol.translatable import marked
from ui.plots.gauge import TiltGauge
from ui.style.theme import Meaning, Size, Space, scaled
from ui.widgets.controls import in_column, in_row, named
from ui.widgets.readout import Freshness, Readout, age_of
from ui.widgets.visibility_timer import VisibilityTimer

_COUNT_EVERY_S: Final = 0.5
"""Slow, since the rate of reports often varies by one."""
_GAUGE_PX: Final = 76
_CHARGING: Final = marked("charging")
_NOT_CHARGING: Final = marked("not charging")
_CHARGER_UNKNOWN: Final = marked("charger unknown")
_BAY_CLOSED: Final = marked("bay closed")
_ASSUMED: Final = marked("{state} (assumed)")
_OVER: Final = marked("over {value}°")
_FALLING: Final = marked("free fall")
_POLLED: Final = marked("polled")
_STREAMED: Final = marked("streamed")
_NO_STREAM: Final = marked("no stream")


class LivePanel(QFrame):
    def __init__(self) -> None:
        super().__init__()
        named(self, "live_panel", "card")
        self.gauge = named(TiltGauge(), "live_gauge")
        self.tilt = named(Readout("", unit="°", template="00"), "live_tilt")
        self.acceleration = named(Readout("", unit="g", template="0.0"), "live_acceleration")
        self.light = named(Readout("", unit="V", template="0.0"), "live_light")
        self.cell = named(Readout("", unit="V", template="0.00"), "live_cell")
        self.stream = named(Readout("", unit="/s", template="00", size=Size.TITLE), "live_stream")
        self.boot_count = named(Readout("", size=Size.TITLE), "live_boot_count")
        self.gauge.use_card_background()
        self._stream_kind: tuple[bool, bool, str] | None = None
        self._counted_at = 0.0
        self._name()
        self._lay_out()
        self._reserve()
        VisibilityTimer(self, restyle=self._reserve)

    def show_device(
        self,
        device: ConversationView,
        now_s: float,
        *,
        in_use: LimitsInUse,
        limits: ModuleLimits = NO_LIMITS,
        unproven: ModuleLimits = NO_LIMITS,
        reports_per_s: float = 0.0,
        direction: LightDirection | None = None,
    ) -> None:
        """Shows all values as known at a monotonic time. Those of the limits that are `unproven` are not drawn as what
        the module acts on; whether a value is beyond a limit is said all the same."""
        tilt, flags = device.known("tilt_deg", now_s), trigger_flags(device, now_s)
        self._show_tilt(tilt, now_s, limits, unproven, flags.tilt)
        acceleration = device.known("acceleration_g", now_s)
        falls_g = limits.free_fall_g
        is_falling = acceleration is not None and falls_g is not None and float(acceleration.value) < falls_g
        falling = (Meaning.DANGER, tr(_FALLING)) if is_falling else self._trigger_note(flags.fall)
        _show(self.acceleration, acceleration, now_s, 1, *falling)
        cell = value_outside("cell_voltage_v", device, now_s, in_use)
        known_light = device.known("light_v", now_s)
        threshold_v = unproven.light_v if limits.light_v is None else limits.light_v
        self.light.set_limit("" if threshold_v is None else f"{threshold_v:.1f} V")
        _show(self.light, known_light, now_s, 1, *_bay_note(known_light, limits.light_v, in_use, direction))
        charging = device.known("charging", now_s)
        self.cell.set_limit("" if cell is None else cell.limit)
        charge = _charge_note(None if charging is None or charging.is_stale else charging.value is True)
        note, meaning = (charge, None) if cell is None else (tr(cell.fault.value), Meaning.ATTENTION)
        _show(self.cell, device.known("cell_voltage_v", now_s), now_s, 2, meaning, note)
        _show(self.boot_count, device.known("boot_count", now_s), now_s, 0)
        self._show_stream(device, now_s, reports_per_s, tilt)

    def _show_tilt_limit(self, limits: ModuleLimits, unproven: ModuleLimits) -> None:
        fires_deg = unproven.fires_deg if limits.fires_deg is None else limits.fires_deg
        reset_deg = None if fires_deg is None else fires_deg - RESET_BELOW_THRESHOLD_DEG
        self.gauge.set_threshold(fires_deg, reset_deg=reset_deg, is_stale=unproven.fires_deg is not None)
        self.tilt.set_limit("" if fires_deg is None else f"{fires_deg:g}°")

    def _show_tilt(
        self, known: Known | None, now_s: float, limits: ModuleLimits, unproven: ModuleLimits, is_on: bool | None
    ) -> None:
        self._show_tilt_limit(limits, unproven)
        if known is None:
            self.gauge.show_tilt(None)
            self.tilt.show_unknown()
            return
        tilt_deg, fires_deg = float(known.value), limits.fires_deg
        self.gauge.show_tilt(tilt_deg, stale_age=age_of(known, now_s))
        is_over = fires_deg is not None and tilt_deg >= fires_deg
        over = (Meaning.DANGER, tr(_OVER, value=f"{fires_deg:g}")) if is_over else self._trigger_note(is_on)
        _show(self.tilt, known, now_s, 0, *over)

    def _trigger_note(self, is_on: bool | None) -> tuple[Meaning | None, str]:
        """Whether the trigger of a value is on."""
        if is_on is False:
            return Meaning.ATTENTION, tr(TRIGGER_OFF)
        return None, "" if is_on else tr(TRIGGER_NOT_KNOWN)

    def _show_stream(self, device: ConversationView, now_s: float, reports_per_s: float, tilt: Known | None) -> None:
        age = "" if tilt is None else age_of(tilt, now_s)
        kind = device.is_streaming, device.is_going, age
        if kind == self._stream_kind and now_s - self._counted_at < _COUNT_EVERY_S:
            return
        self._stream_kind, self._counted_at = kind, now_s
        if device.is_streaming:
            self.stream.show_value(f"{device.stream_hz:.0f}", note=age or tr(_STREAMED))
        elif device.is_going and reports_per_s > 0:
            self.stream.show_value(f"{reports_per_s:.0f}", note=age or tr(_POLLED))
        else:
            self.stream.show_value("0", note=tr(_NO_STREAM))

    # Construction

    def _name(self) -> None:
        self.setAccessibleName(tr("Measured values"))
        for widget, caption in (
            (self.tilt, "Tilt"),
            (self.acceleration, "Acceleration"),
            (self.light, "Light"),
            (self.cell, "Cell voltage"),
            (self.boot_count, "Boot count"),
            (self.stream, "Reports"),
        ):
            widget.set_caption(tr(caption))
        for readout, command in ((self.light, "light"), (self.cell, "cell_voltage"), (self.boot_count, "boot_count")):
            readout.setToolTip(tr(BY_NAME[command].explanation))

    def _lay_out(self) -> None:
        height_px = scaled(_GAUGE_PX)
        self.gauge.setFixedSize(self.gauge.width_for(height_px), height_px)
        rest = in_row(self.stream, self.boot_count, spacing=Space.M)
        values = (self.tilt, self.acceleration, self.light, self.cell)
        in_column(self.gauge, *values, rest, 1, of=self, spacing=Space.S, margins=(Space.M, Space.S))

    def _reserve(self) -> None:
        """Reserves room for all possible notes, so that nothing moves."""
        age = tr("{time} ago", time=tr("{value:.0f} min", value=10))
        sign = "    "
        triggers = tr(TRIGGER_OFF) + sign, tr(TRIGGER_NOT_KNOWN)
        self.tilt.reserve((tr(_OVER, value=180) + sign, *triggers, age), limit="180°")
        self.acceleration.reserve((tr(_FALLING) + sign, *triggers, age))
        bay = tr(OutOfLimit.BAY_OPEN.value), tr(_BAY_CLOSED)
        self.light.reserve((*(tr(_ASSUMED, state=state) + sign for state in bay), age), limit="00.0 V")
        low = (tr(OutOfLimit.CELL_LOW.value), tr(OutOfLimit.CELL_HIGH.value))
        words = (_CHARGING, _NOT_CHARGING, _CHARGER_UNKNOWN)
        self.cell.reserve((*low, *(tr(word) for word in words), age), limit="0.00 V")
        self.stream.reserve((tr(_STREAMED), tr(_POLLED), tr(_NO_STREAM), age))
        self.boot_count.reserve((age,))


def _bay_note(
    light: Known | None, threshold_v: float | None, in_use: LimitsInUse, direction: LightDirection | None
) -> tuple[Meaning | None, str]:
    """Meaning and note of the light: bay open or closed; none without a threshold. Which side is dark is an assumption
    until it was measured with the bay closed and open, and is called one (E11)."""
    if light is None or threshold_v is None:
        return None, ""
    is_inverted = in_use.profile.is_light_inverted if direction is None else direction is LightDirection.FALLS
    is_open = bay_outside(round(float(light.value), 3), threshold_v, is_inverted=is_inverted) is not None
    text = tr(OutOfLimit.BAY_OPEN.value if is_open else _BAY_CLOSED)
    if direction is None and not is_inverted:
        text = tr(_ASSUMED, state=text)
    return (Meaning.ATTENTION if is_open else None), text


def _charge_note(is_charging: bool | None) -> str:
    if is_charging is None:
        return tr(_CHARGER_UNKNOWN)
    return tr(_CHARGING) if is_charging else tr(_NOT_CHARGING)


def _show(
    readout: Readout, known: Known | None, now_s: float, decimals: int, meaning: Meaning | None = None, note: str = ""
) -> None:
    if known is None:
        readout.show_unknown()
        return
    text = f"{float(known.value):.{decimals}f}"
    if known.is_stale:
        readout.show_value(text, freshness=Freshness.STALE, note=age_of(known, now_s))
    else:
        readout.show_value(text, meaning=meaning, note=note)
