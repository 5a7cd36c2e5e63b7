"""Shows a recording on the Live page in place of the module: a notice, plots, and the values at the cursor."""

from collections.abc import Callable, Sequence
from types import MappingProxyType
from typing import Final

from app.engine.device import DeviceView, How, Known
from app.limits.out_of_limits import LimitsInUse
from app.recordings.entry_texts import remarks
from app.recordings.markers import NO_LIMITS, charging_at
from app.recordings.recording import Recording
from app.safety.last_known import Activation, SeenActivation
from app.samples.ring_buffers import Readable
from app.system.wall_clock import clock_text
from app.text.durations import duration
from app.text.i18n import tr
from protocol.fields import Value
from ui.core.texts import Texts
from ui.files.save_bar import Origin
from ui.pages.live.data import SLOW_GAP_S, mark_of
from ui.pages.live.panel import LivePanel
from ui.plots.lanes import Lane, Span
from ui.plots.time_plot import TimePlot
from ui.style.icons import Icon
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice
from ui.widgets.readout import show_activation, show_known_trigger

# As wide as a gap in the plots; samples further away do not count.
_NEAR_S: Final = 1.0


def recorded_notice(recording: Recording, leave: Callable[[], None]) -> Notice:
    """Where it is from, that it is not live, and the way back."""
    entry, damage = recording.entry, recording.damage
    parts = (
        "" if damage is None else damage.translated(),
        tr("Recording of {time}", time=f"{entry.started_at.astimezone():%Y-%m-%d %H:%M}"),
        tr("not live"),
        duration(entry.duration_s),
        entry.module,
        entry.port,
        remarks(entry),
    )
    meaning = Meaning.INFORMATION if damage is None else Meaning.ATTENTION
    back = Choice("recorded_back", tr("Back to live"), leave)
    return Notice(meaning, " · ".join(filter(None, parts)), (back,))


def recorded_plot(recording: Recording, lanes: Sequence[Lane], texts: Texts) -> TimePlot:
    """Plots with all of `recording` in sight, and the cursor at its last report."""
    bounds = Span(recording.start_s, recording.end_s)
    plot = TimePlot(lanes, texts, wall_offset_s=recording.wall_offset_s, bounds=bounds)
    plot.add_marks([mark_of(marker) for marker in recording.markers])
    last = recording.tilt.last
    if last is not None:
        plot.time_range.point_at(last.time_s)
    return plot


def origin_of(recording: Recording) -> Origin:
    entry = recording.entry
    return Origin(entry.port, entry.baud_rate, recording.wall_offset_s, entry.started_at, entry.module)


def device_at(recording: Recording, time_s: float) -> DeviceView:
    """What a recording knows of the module at a time in its monotonic seconds."""
    tilt = recording.tilt.around(time_s, within_s=_NEAR_S)
    # One report contains both the tilt and the flags.
    flags = None if tilt is None else recording.excerpt(tilt.time_s, tilt.time_s)
    has_flags = flags is not None and len(flags.flags) > 0
    values: dict[str, Value | None] = {
        "tilt_deg": None if tilt is None else tilt.high,
        "acceleration_g": _value(recording.acceleration, time_s, _NEAR_S),
        "light_v": _value(recording.light, time_s, SLOW_GAP_S),
        "light_threshold_v": recording.at(time_s).light_v,
        "cell_voltage_v": _value(recording.cell, time_s, SLOW_GAP_S),
        "charging": charging_at(recording.markers, time_s),
        "active": bool(flags.is_active[-1]) if flags is not None and has_flags else None,
        "triggered": bool(flags.is_triggered[-1]) if flags is not None and has_flags else None,
    }
    known = {key: Known(value, How.READ, time_s) for key, value in values.items() if value is not None}
    return DeviceView(MappingProxyType(known))


def show_moment(panel: LivePanel, recording: Recording, time_s: float | None, in_use: LimitsInUse) -> None:
    """Shows the values of `recording` at a time in the panel; None: there is no cursor."""
    text, device, limits, now_s = tr("point at the plots"), DeviceView(), NO_LIMITS, 0.0
    if time_s is not None:
        text, device, now_s = clock_text(time_s + recording.wall_offset_s, 1), device_at(recording, time_s), time_s
        limits = recording.at(time_s)
    panel.moment.show_state(text, Icon.HISTORY, Meaning.INFORMATION)
    panel.show_device(device, now_s, limits=limits, in_use=in_use)
    is_active = device.fresh("active", now_s)
    reported = Activation.UNKNOWN if is_active is None else Activation.ACTIVE if is_active else Activation.LOCKED
    show_activation(panel.activation, SeenActivation(reported), now_s)
    show_known_trigger(panel.trigger, device.known("triggered", now_s), now_s)


def _value(series: Readable, time_s: float, within_s: float) -> float | None:
    near = series.around(time_s, within_s=within_s)
    return None if near is None else near.high
