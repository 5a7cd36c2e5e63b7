"""Checks of the link, the module's state and its sensors."""

from functools import partial
from typing import Final

from app.guided.results import GuidedKind, GuidedVerdict
from app.limits.limits import OutOfLimit, bay_outside, cell_outside, least_cell_text
from app.preflight.evidence import HEARTBEATS, STILL_S, UNFINISHED
from app.preflight.findings import CHECK_LINK, YES, Case, Check, CheckResult, Finding, judged, unknown
from app.procedures.read import ANSWERED_TWICE
from app.settings.profiles import LIMITS
from app.text.messages import UserMessage, message
from protocol.fields import Value
from protocol.translatable import marked

CHECK_LINE = message(marked("Make sure that one module only is on this line; else do not fly."))
# About forty come in two seconds.
REPORTS_NEEDED = 15
# So many of three answers make cell voltage, charging and light known.
_RAW_NEEDED = 2


def connection(case: Case) -> Finding:
    limit = message(marked("no interruption"))
    void = case.evidence.void
    if void is not None:
        return Finding(CheckResult.FAIL, False, void.message, limit)
    if case.evidence.ended_at is None:
        return unknown(UNFINISHED.message, limit)
    return judged(True, YES, limit, is_fine=True)


def read_twice(case: Case) -> Finding:
    """Two readings that differ have ended the conversation."""
    limit = message(marked("same"))
    first, last = case.evidence.first, case.evidence.last
    if case.evidence.is_answered_twice:
        return Finding(CheckResult.FAIL, False, ANSWERED_TWICE, limit, CHECK_LINE)
    if first is None or last is None:
        return case.unread("status", limit)
    if not (first.is_complete and last.is_complete):
        return unknown(message(marked("not read again")), limit, do=CHECK_LINK)
    return judged(True, YES, limit, is_fine=True)


def link_loss(case: Case) -> Finding:
    evidence, most = case.evidence, case.profile.limit("heartbeats_lost_max")
    text = marked("{lost} of {sent} lost, invalid bytes: {bytes}")
    limit = message(text, lost=f"≤ {most:g}" if most else 0, sent=HEARTBEATS, bytes=0)
    if evidence.heartbeats_sent == 0:
        return case.unread("heartbeat", limit)
    shown = message(text, lost=evidence.heartbeats_lost, sent=evidence.heartbeats_sent, bytes=evidence.rejected_bytes)
    is_fine = evidence.heartbeats_sent >= HEARTBEATS and evidence.heartbeats_lost <= most
    return judged(evidence.heartbeats_lost, shown, limit, is_fine=is_fine and not evidence.rejected_bytes)


def round_trip(case: Case) -> Finding:
    most_ms = case.profile.limit("round_trip_max_ms")
    limit = message(f"≤ {most_ms:g} ms")
    trips = sorted(case.evidence.round_trips_s)
    if not trips:
        return case.unread("heartbeat", limit)
    slowest_ms, median_ms = 1000 * trips[-1], 1000 * trips[len(trips) // 2]
    shown = message(marked("{slowest:.1f} ms, median {median:.1f} ms"), slowest=slowest_ms, median=median_ms)
    return judged(round(slowest_ms, 1), shown, limit, is_fine=slowest_ms <= most_ms)


def not_triggered(case: Case) -> Finding:
    limit = message(marked("not triggered"))
    statuses = case.evidence.statuses
    if not statuses:
        return case.unread("status", limit)
    has_fired = any(status.triggered for status in statuses)
    otherwise = case.evidence.contradiction_of("triggered")
    if otherwise is not None:
        return unknown(otherwise, limit, do=CHECK_LINE)
    shown = message(marked("TRIGGERED")) if has_fired else message(marked("not triggered"))
    return judged(has_fired, shown, limit, is_fine=not has_fired)


def activation(case: Case) -> Finding:
    """Passes locked and active; which of them decides between READY and GO."""
    limit = message(marked("the same throughout; GO: active"))
    statuses = case.evidence.statuses
    if not statuses:
        return case.unread("status", limit)
    states = {status.active for status in statuses}
    otherwise = case.evidence.contradiction_of("active")
    if otherwise is not None:
        return unknown(otherwise, limit, do=CHECK_LINE)
    if len(states) > 1:
        return Finding(CheckResult.FAIL, None, message(marked("changed")), limit)
    is_active = bool(case.evidence.is_active)
    shown = message(marked("ACTIVE") if is_active else marked("locked"))
    return judged(is_active, shown, limit, is_fine=True)


def _two_seconds(case: Case, limit: UserMessage) -> Finding | None:
    """Why nothing is known of the two seconds: the reports are too few, or do not cover them."""
    reports = case.evidence.reports
    if not reports:
        return case.unread("status", limit)
    if len(reports) < REPORTS_NEEDED or reports[-1].at - reports[0].at < STILL_S * 0.75:
        why = message(marked("reports in 2 s: only {count}"), count=str(len(reports)))
        return unknown(why, limit, do=CHECK_LINK)
    return None


def tilt_level(case: Case) -> Finding:
    most = case.profile.limit("tilt_max_deg")
    limit = message(f"≤ {most:g}°")
    highest = max((report.tilt_deg for report in case.evidence.reports), default=0.0)
    return _two_seconds(case, limit) or judged(highest, f"{highest:.0f}°", limit, is_fine=highest <= most)


def acceleration_one_g(case: Case) -> Finding:
    least, most = case.profile.limit("acceleration_min_g"), case.profile.limit("acceleration_max_g")
    limit = message(f"{least:g}–{most:g} g")
    values = [report.acceleration_g for report in case.evidence.reports]
    worst = max(values, key=lambda value: abs(value - 1.0), default=0.0)
    is_fine = all(least <= value <= most for value in values)
    return _two_seconds(case, limit) or judged(worst, f"{worst:.1f} g", limit, is_fine=is_fine)


def steady(case: Case, key: str, limit_name: str, shown: str) -> Finding:
    """`shown`: how a width is written."""
    most = case.profile.limit(limit_name)
    limit = message(LIMITS[limit_name].shown.format(most).join(("≤ ", " / 2 s")))
    values = [getattr(report, key) for report in case.evidence.reports] or [0.0]
    width = round(max(values) - min(values), 1)
    return _two_seconds(case, limit) or judged(width, shown.format(width), limit, is_fine=width <= most)


def _answers(case: Case, key: str) -> list[Value]:
    """All answers of three; none where too few came."""
    values = case.evidence.series.get(key, [])
    return values if len(values) >= _RAW_NEEDED else []


def cell_voltage(case: Case) -> Finding:
    limit = message(f"≥ {least_cell_text(case.profile)}")
    volts = [float(value) for value in _answers(case, "cell_voltage_v")]
    if not volts:
        return case.unread("cell_voltage_v", limit)
    lowest, shown = min(volts), f"{min(volts):.2f} V"
    if cell_outside(lowest, case.profile, is_charging=None) is not None:
        return judged(lowest, shown, limit, is_fine=False)
    # With external power the charging voltage is read, which is above the cell's: it only proves that a cell is low.
    charging = _answers(case, "charging")
    if not charging or any(charging):
        why = message(marked("{voltage} may be the charger's"), voltage=shown)
        return unknown(why, limit, do=message(marked("Unplug the external power.")))
    if cell_outside(max(volts), case.profile, is_charging=False) is not None:
        why = message(OutOfLimit.CELL_HIGH.value)
        shown_why = message(marked("{value}: {why}"), value=f"{max(volts):.2f} V", why=why)
        return judged(max(volts), shown_why, limit, is_fine=False)
    return judged(lowest, shown, limit, is_fine=True)


def not_charging(case: Case) -> Finding:
    limit = message(marked("no external power"))
    states = _answers(case, "charging")
    if not states:
        return case.unread("charging", limit)
    is_charging = any(states)
    shown = message(marked("charging") if is_charging else marked("confirmed"))
    return judged(is_charging, shown, limit, is_fine=not is_charging)


def bay_closed(case: Case) -> Finding:
    threshold = case.evidence.values.get("light_threshold_v")
    if threshold is None:
        return case.unread("light_threshold_v", message(marked("Light threshold")))
    is_inverted = case.profile.is_light_inverted
    limit = message(f"{'>' if is_inverted else '<'} {threshold:.1f} V")
    tested = case.past.tests.get(GuidedKind.BAY)
    is_measured = is_inverted or (tested is not None and tested.stored.verdict is GuidedVerdict.PASSED)
    if not is_measured:  # which side of the threshold is dark (E11)
        limit = message(marked("{limit} (assumed)"), limit=limit)
    lights = [float(value) for value in _answers(case, "light_v")]
    if not lights:
        return case.unread("light_v", limit)
    worst = min(lights) if is_inverted else max(lights)
    is_dark = bay_outside(worst, float(threshold), is_inverted=is_inverted) is None
    return judged(worst, f"{worst:.1f} V", limit, is_fine=is_dark)


LINE_CHECKS: Final = (
    Check("connection", marked("No interruption"), connection,
          marked("Earlier values no longer count."),
          marked("Check cable and power.")),
    Check("read_twice", marked("Same when read twice"), read_twice,
          marked("What is read twice and agrees is one module's."),
          marked("Check cable and power.")),
    Check("link_loss", marked("Link: loss"), link_loss,
          marked("A bad line loses or falsifies values."),
          marked("Check plugs, ground and cable length.")),
    Check("round_trip", marked("Link: response time"), round_trip,
          marked("Slow replies point to a bad adapter or a busy computer."),
          marked("Use another adapter or USB socket.")),
    Check("triggered", marked("Not triggered"), not_triggered,
          marked("The parachute is spent."),
          marked("Find out why (Triggers), repack, lock and restart.")),
    Check("activation", marked("Activation"), activation,
          marked("An active module fires when it tips over or falls."),
          marked("Send no commands during the check.")),
    Check("tilt", marked("Tilt: level"), tilt_level,
          marked("A wrong zero fires too early or too late."),
          marked("Set the aircraft level, or zero the sensor.")),
    Check("tilt_spread", marked("Tilt: steady"),
          partial(steady, key="tilt_deg", limit_name="tilt_spread_max_deg", shown="{:.0f}°"),
          marked("A drifting sensor is loose or failing."),
          marked("Do not touch the aircraft; check the mounting.")),
    Check("acceleration", marked("Acceleration: 1 g"), acceleration_one_g,
          marked("If it is not 1 g at rest, free fall is misjudged."),
          marked("Set the aircraft down; if the value stays, do not fly.")),
    Check("acceleration_spread", marked("Acceleration: steady"),
          partial(steady, key="acceleration_g", limit_name="acceleration_spread_max_g", shown="{:.1f} g"),
          marked("Noise can end or fake a free fall."),
          marked("Stop motors and fans.")),
    Check("cell_voltage", marked("Cell voltage"), cell_voltage,
          marked("A weak cell may not deploy the parachute."),
          marked("Charge it, unplug it, wait a minute.")),
    Check("charging", marked("Charger disconnected"), not_charging,
          marked("The charger hides the cell's voltage."),
          marked("Unplug the external power.")),
    Check("light", marked("Bay closed"), bay_closed,
          marked("More light reading higher is assumed until it was measured with the bay closed and open."),
          marked("Close the bay, or measure the light threshold.")),
)  # fmt: skip
