"""Values of a recording at the cursor, in the panel of the Live page."""

from dataclasses import dataclass
from typing import Final

from app.limits.out_of_limits import LimitsInUse, outside_of
from app.recordings.markers import charging_at
from app.recordings.recording import Recording
from app.safety.last_known import Activation, SeenActivation
from app.samples.ring_buffers import Readable
from app.samples.step_function import StepFunction
from app.text.i18n import tr
from ui.pages.live.data import SLOW_GAP_S
from ui.pages.live.panel import CELL, CHARGER, FALLING, OVER, LivePanel, PanelLimits, bay_note, charge_note
from ui.plots.axis import clock_text
from ui.style.icons import Icon
from ui.style.theme import Meaning
from ui.widgets.readout import Readout
from ui.widgets.state_chips import show_activation, show_trigger

# As wide as a gap in the plots; samples further away do not count.
_NEAR_S: Final = 1.0


@dataclass(frozen=True, slots=True)
class CursorValues:
    """Values measured around a time, None where there are none; `time_text` is that time in words."""

    time_text: str
    limits: PanelLimits
    tilt_deg: float | None = None
    acceleration_g: float | None = None
    light_v: float | None = None
    cell_voltage_v: float | None = None
    is_active: bool | None = None
    is_triggered: bool | None = None
    is_charging: bool | None = None


def moment_of(recording: Recording, time_s: float) -> CursorValues:
    """The values of a recording at a time in its monotonic seconds."""
    tilt = recording.tilt.around(time_s, within_s=_NEAR_S)
    # One report contains both the tilt and the flags.
    flags = None if tilt is None else recording.excerpt(tilt.time_s, tilt.time_s)
    has_flags = flags is not None and len(flags.time_s) > 0
    return CursorValues(
        time_text=clock_text(time_s + recording.wall_offset_s, 1),
        limits=PanelLimits(
            _standing(recording.fires, time_s), _standing(recording.falls, time_s), _standing(recording.lights, time_s)
        ),
        tilt_deg=None if tilt is None else tilt.high,
        acceleration_g=_value(recording.acceleration, time_s, _NEAR_S),
        light_v=_value(recording.light, time_s, SLOW_GAP_S),
        cell_voltage_v=_value(recording.cell, time_s, SLOW_GAP_S),
        is_active=bool(flags.is_active[-1]) if flags is not None and has_flags else None,
        is_triggered=bool(flags.is_triggered[-1]) if flags is not None and has_flags else None,
        is_charging=charging_at(recording.markers, time_s),
    )


def show_moment(panel: LivePanel, moment: CursorValues | None, in_use: LimitsInUse) -> None:
    """Shows the values at the cursor in the panel; None: there is no cursor."""
    if moment is None:
        moment = CursorValues(tr("point at the plots"), PanelLimits(None, None, None))
    fires_deg, falls_g = moment.limits.fires_deg, moment.limits.falls_g
    panel.moment.show_state(moment.time_text, Icon.HISTORY, Meaning.INFORMATION)
    panel.name_cell(CHARGER if moment.is_charging else CELL)
    panel.show_tilt_limit(moment.limits)
    if moment.tilt_deg is None:
        panel.gauge.show_unknown()
    else:
        panel.gauge.show_tilt(moment.tilt_deg)
    is_over = moment.tilt_deg is not None and fires_deg is not None and moment.tilt_deg >= fires_deg
    over = (Meaning.DANGER, tr(OVER, value=f"{fires_deg:g}")) if is_over else (None, "")
    _show(panel.tilt, moment.tilt_deg, 0, *over)
    is_falling = moment.acceleration_g is not None and falls_g is not None and moment.acceleration_g < falls_g
    _show(panel.acceleration, moment.acceleration_g, 1, *((Meaning.DANGER, tr(FALLING)) if is_falling else (None, "")))
    measured = {"light_v": moment.light_v, "cell_voltage_v": moment.cell_voltage_v, "charging": moment.is_charging,
                "light_threshold_v": moment.limits.light_v}  # fmt: skip
    said = {key: value for key, value in measured.items() if value is not None}
    light, cell = outside_of("light_v", said, in_use), outside_of("cell_voltage_v", said, in_use)
    panel.show_light_limit(moment.light_v, moment.limits)
    _show(panel.light, moment.light_v, 1, *bay_note(light, moment.limits.light_v))
    panel.cell.set_limit("" if cell is None else cell.limit)
    charge = "" if moment.is_charging is None else charge_note(moment.is_charging)
    low = (None, charge) if cell is None else (Meaning.ATTENTION, tr(cell.fault.value))
    _show(panel.cell, moment.cell_voltage_v, 2, *low)
    reported = {None: Activation.UNKNOWN, True: Activation.ACTIVE, False: Activation.LOCKED}[moment.is_active]
    show_activation(panel.activation, SeenActivation(reported), now=0.0)
    show_trigger(panel.trigger, is_triggered=moment.is_triggered)


def _standing(steps: StepFunction, time_s: float) -> float | None:
    """The value at a time."""
    changes = steps.between(time_s, time_s)
    return changes[-1].value if changes else None


def _value(series: Readable, time_s: float, within_s: float) -> float | None:
    found = series.around(time_s, within_s=within_s)
    return None if found is None else found.high


def _show(readout: Readout, value: float | None, decimals: int, meaning: Meaning | None, note: str) -> None:
    if value is None:
        readout.show_unknown()
    else:
        readout.show_value(f"{value:.{decimals}f}", meaning=meaning, note=note)
