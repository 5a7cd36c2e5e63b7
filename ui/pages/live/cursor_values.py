"""Values of a recording at the cursor, in the panel of the Live page."""

from types import MappingProxyType
from typing import Final

from app.engine.device import DeviceView, How, Known
from app.limits.out_of_limits import LimitsInUse
from app.recordings.markers import charging_at
from app.recordings.recording import Recording
from app.safety.last_known import Activation, SeenActivation
from app.samples.ring_buffers import Readable
from app.samples.step_function import StepFunction
from app.text.i18n import tr
from protocol.fields import Value
from ui.pages.live.data import SLOW_GAP_S
from ui.pages.live.panel import LivePanel, PanelLimits
from ui.plots.axis import clock_text
from ui.style.icons import Icon
from ui.style.theme import Meaning
from ui.widgets.state_chips import show_activation, show_known_trigger

# As wide as a gap in the plots; samples further away do not count.
_NEAR_S: Final = 1.0


def device_at(recording: Recording, time_s: float) -> DeviceView:
    """What a recording knows of the module at a time in its monotonic seconds."""
    tilt = recording.tilt.around(time_s, within_s=_NEAR_S)
    # One report contains both the tilt and the flags.
    flags = None if tilt is None else recording.excerpt(tilt.time_s, tilt.time_s)
    has_flags = flags is not None and len(flags.time_s) > 0
    values: dict[str, Value | None] = {
        "tilt_deg": None if tilt is None else tilt.high,
        "acceleration_g": _value(recording.acceleration, time_s, _NEAR_S),
        "light_v": _value(recording.light, time_s, SLOW_GAP_S),
        "light_threshold_v": _limit(recording.lights, time_s),
        "cell_voltage_v": _value(recording.cell, time_s, SLOW_GAP_S),
        "charging": charging_at(recording.markers, time_s),
        "active": bool(flags.is_active[-1]) if flags is not None and has_flags else None,
        "triggered": bool(flags.is_triggered[-1]) if flags is not None and has_flags else None,
    }
    known = {key: Known(value, How.READ, time_s) for key, value in values.items() if value is not None}
    return DeviceView(MappingProxyType(known))


def show_moment(panel: LivePanel, recording: Recording, time_s: float | None, in_use: LimitsInUse) -> None:
    """Shows the values of `recording` at a time in the panel; None: there is no cursor."""
    text, device, limits, now_s = tr("point at the plots"), DeviceView(), PanelLimits(None, None, None), 0.0
    if time_s is not None:
        text, device, now_s = clock_text(time_s + recording.wall_offset_s, 1), device_at(recording, time_s), time_s
        limits = PanelLimits(*(_limit(one, time_s) for one in (recording.fires, recording.falls, recording.lights)))
    panel.moment.show_state(text, Icon.HISTORY, Meaning.INFORMATION)
    panel.show_device(device, now_s, limits=limits, in_use=in_use, reports_per_s=0.0)
    is_active = device.fresh("active", now_s)
    reported = Activation.UNKNOWN if is_active is None else Activation.ACTIVE if is_active else Activation.LOCKED
    show_activation(panel.activation, SeenActivation(reported), now_s)
    show_known_trigger(panel.trigger, device.known("triggered", now_s), now_s)


def _limit(steps: StepFunction, time_s: float) -> float | None:
    changes = steps.between(time_s, time_s)
    return changes[-1].value if changes else None


def _value(series: Readable, time_s: float, within_s: float) -> float | None:
    found = series.around(time_s, within_s=within_s)
    return None if found is None else found.high
