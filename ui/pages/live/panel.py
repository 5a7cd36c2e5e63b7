"""Tiles of the Live page: tilt with its gauge, acceleration, light, cell, boot count, in one column.

Each number is fresh, stale with its age, or unknown.
"""

from PySide6.QtWidgets import QFrame

from app.engine.conversation import ConversationView, Known
from app.limits.limits import LimitsInUse, is_bay_open, last_cell_outside
from app.procedures.light import LightDirection
from app.recordings.markers import acting_limits, last_limits, limits_of
from app.safety.last_known import TRIGGER_NOT_KNOWN, TRIGGER_OFF, trigger_flags
from app.text.i18n import tr
from protocol.catalogue import BY_NAME
from ui.plots.gauge import TiltGauge
from ui.style.theme import Meaning, Size, Space, scaled
from ui.widgets.controls import in_column, named
from ui.widgets.readout import Freshness, Readout, age_of

Note = tuple[Meaning | None, str]


class LivePanel(QFrame):
    def __init__(self) -> None:
        super().__init__()
        named(self, "live_panel", "card")
        self.setAccessibleName(tr("Measured values"))
        self.gauge = named(TiltGauge(), "live_gauge")
        self.gauge.setFixedSize(scaled(self.gauge.usual.width()), scaled(self.gauge.usual.height()))
        self.tilt = named(Readout(tr("Tilt"), unit="°", template="00"), "live_tilt")
        self.acceleration = named(Readout(tr("Acceleration"), unit="g", template="0.0"), "live_acceleration")
        self.light = named(Readout(tr("Light"), unit="V", template="0.0"), "live_light")
        self.cell = named(Readout(tr("Cell voltage"), unit="V", template="0.00"), "live_cell")
        self.boot_count = named(Readout(tr("Boot count"), size=Size.TITLE), "live_boot_count")
        for readout, command in ((self.light, "light"), (self.cell, "cell_voltage"), (self.boot_count, "boot_count")):
            readout.setToolTip(tr(BY_NAME[command].explanation))
        values = (self.tilt, self.acceleration, self.light, self.cell, self.boot_count)
        in_column(self.gauge, *values, 1, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        # Room for all that may be said, so that the plots beside it never move.
        age = tr("{time} ago", time=tr("{value:.0f} min", value=10))
        bays = [tr("{state} (assumed)", state=state) for state in (tr("bay open"), tr("bay closed"))]
        words = (tr(TRIGGER_OFF), tr(TRIGGER_NOT_KNOWN), tr("free fall"), tr("not charging"), tr("charger unknown"))
        self.light.reserve([f"{note}    " for note in (*bays, *words, tr("over {value}°", value=180))], limit="00.0 V")
        self.boot_count.reserve((age,))

    def show_device(
        self,
        view: ConversationView,
        now_s: float,
        *,
        in_use: LimitsInUse,
        direction: LightDirection | None,
    ) -> None:
        """Shows all values as known at a monotonic time. `direction`: which way the light was measured to read."""
        last, fresh, acting = last_limits(view), limits_of(view, now_s), acting_limits(view, now_s)
        flags = trigger_flags(view, now_s)
        tilt = view.known("tilt_deg", now_s)
        # A limit of a trigger that is not known to be on is not drawn as what the module acts on; whether a value is
        # beyond it is said all the same.
        self.gauge.show_tilt(
            None if tilt is None else float(tilt.value),
            stale_age="" if tilt is None else age_of(tilt, now_s),
            fires_deg=last.fires_deg,
            rearms_deg=last.rearms_deg,
            is_unproven=acting.fires_deg is None,
        )
        self.tilt.set_limit("" if last.fires_deg is None else f"{last.fires_deg:g}°")
        note = _trigger_note(flags.tilt)
        if tilt is not None and fresh.fires_deg is not None and float(tilt.value) >= fresh.fires_deg:
            note = Meaning.DANGER, tr("over {value}°", value=f"{fresh.fires_deg:g}")
        _show(self.tilt, tilt, now_s, 0, note)

        acceleration = view.known("acceleration_g", now_s)
        note = _trigger_note(flags.fall)
        if acceleration is not None and fresh.free_fall_g is not None and float(acceleration.value) < fresh.free_fall_g:
            note = Meaning.DANGER, tr("free fall")
        _show(self.acceleration, acceleration, now_s, 1, note)

        light = view.known("light_v", now_s)
        self.light.set_limit("" if last.light_v is None else f"{last.light_v:.1f} V")
        note = None, ""
        if light is not None and fresh.light_v is not None:
            # Which side is dark is an assumption until it was measured with the bay closed and open, and is called one
            # (E11).
            is_inverted = in_use.profile.is_light_inverted if direction is None else direction is LightDirection.FALLS
            is_open = is_bay_open(float(light.value), fresh.light_v, is_inverted=is_inverted)
            state = tr("bay open") if is_open else tr("bay closed")
            if direction is None and not is_inverted:
                state = tr("{state} (assumed)", state=state)
            note = Meaning.ATTENTION if is_open else None, state
        _show(self.light, light, now_s, 1, note)

        charging = view.fresh("charging", now_s)
        charge = tr("charging") if charging else tr("not charging")
        charge = tr("charger unknown") if charging is None else charge
        cell = last_cell_outside(view, now_s, in_use.profile)
        self.cell.set_limit("" if cell is None else cell.limit)
        note = (None, charge) if cell is None else (Meaning.ATTENTION, tr(cell.fault.value))
        _show(self.cell, view.known("cell_voltage_v", now_s), now_s, 2, note)
        _show(self.boot_count, view.known("boot_count", now_s), now_s, 0)


def _trigger_note(is_on: bool | None) -> Note:
    if is_on is False:
        return Meaning.ATTENTION, tr(TRIGGER_OFF)
    return None, "" if is_on else tr(TRIGGER_NOT_KNOWN)


def _show(readout: Readout, known: Known | None, now_s: float, decimals: int, note: Note = (None, "")) -> None:
    if known is None:
        readout.show_unknown()
    elif known.is_stale:
        text = f"{float(known.value):.{decimals}f}"
        readout.show_value(text, freshness=Freshness.STALE, note=age_of(known, now_s))
    else:
        readout.show_value(f"{float(known.value):.{decimals}f}", meaning=note[0], note=note[1])
