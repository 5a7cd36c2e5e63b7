"""Checks of the link, the module's state and its sensors: how each judges, then its entry with its texts."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from app.limits.out_of_limits import bay_outside, cell_outside
from app.preflight.evidence import HEARTBEATS, STILL_S, Trial
from app.preflight.findings import NO, YES, Case, Check, CheckResult, Finding, judged, unknown
from app.text.messages import UserMessage, listed, said
from protocol.fields import Value
from protocol.translatable import marked

STATUS_FRESH_S = 1.0
TRIALS_NEEDED = 15
"""Of the forty or so that two seconds hold."""
_RAW_NEEDED = 2
"""Answers, of three, without which cell, charge and light are not known."""


def undisturbed(case: Case) -> Finding:
    limit = said(marked("nothing happens to the module or the link meanwhile"))
    disturbance = case.evidence.disturbance
    if disturbance is not None:
        return Finding(CheckResult.FAIL, False, said(disturbance.value), limit)
    if case.evidence.ended_at is None:
        return unknown(said(marked("it did not come to its end")), limit)
    return judged(True, YES, limit, is_fine=True)


def read_twice(case: Case) -> Finding:
    limit = said(marked("before and after the measuring the same"))
    first, last = case.evidence.first, case.evidence.last
    changes = case.evidence.changes
    if changes:
        keys = ", ".join(change.key for change in changes)
        return Finding(CheckResult.FAIL, keys, listed([change.shown for change in changes]), limit)
    if first is None or last is None:
        return unknown(case.fault("status"), limit)
    if not (first.is_complete and last.is_complete):
        return unknown(said(marked("not everything was answered both times")), limit)
    return judged(True, said(marked("the same")), limit, is_fine=True)


def link_loss(case: Case) -> Finding:
    evidence, most = case.evidence, case.expectations.limits.heartbeats_lost_max
    limit = said(
        marked("at most {lost} of {sent} heartbeats lost, no damaged bytes"), lost=str(most), sent=str(HEARTBEATS)
    )
    if evidence.heartbeats_sent == 0:
        return unknown(case.fault("heartbeat"), limit)
    shown = said(
        marked("{lost} of {sent} lost, {bytes} damaged bytes"),
        lost=str(evidence.heartbeats_lost), sent=str(evidence.heartbeats_sent), bytes=str(evidence.rejected_bytes),
    )  # fmt: skip
    is_fine = evidence.heartbeats_sent >= HEARTBEATS and evidence.heartbeats_lost <= most
    return judged(evidence.heartbeats_lost, shown, limit, is_fine=is_fine and not evidence.rejected_bytes)


def round_trip(case: Case) -> Finding:
    most_ms = case.expectations.limits.round_trip_max_ms
    limit = said(marked("at most {milliseconds} ms"), milliseconds=f"{most_ms:g}")
    trips = sorted(case.evidence.round_trips_s)
    if not trips:
        return unknown(case.fault("heartbeat"), limit)
    slowest_ms, median_ms = 1000 * trips[-1], 1000 * trips[len(trips) // 2]
    shown = said(
        marked("{slowest} ms at most, {median} ms usually"), slowest=f"{slowest_ms:.1f}", median=f"{median_ms:.1f}"
    )
    return judged(round(slowest_ms, 1), shown, limit, is_fine=slowest_ms <= most_ms)


def status_fresh(case: Case) -> Finding:
    limit = said(marked("at most {seconds} s old at the end"), seconds=f"{STATUS_FRESH_S:.1f}")
    age_s = case.evidence.status_age_s
    if age_s is None:
        return unknown(case.fault("status"), limit)
    return judged(round(age_s, 2), f"{age_s:.2f} s", limit, is_fine=age_s <= STATUS_FRESH_S)


def not_triggered(case: Case) -> Finding:
    limit = said(marked("not triggered"))
    statuses = case.evidence.statuses
    if not statuses:
        return unknown(case.fault("status"), limit)
    has_fired = any(status.triggered for status in statuses)
    shown = said(marked("TRIGGERED")) if has_fired else said(marked("not triggered"))
    return judged(has_fired, shown, limit, is_fine=not has_fired)


def activation(case: Case) -> Finding:
    """Locked or active alike hold; which of them decides between READY and GO."""
    limit = said(marked("the same throughout; GO needs it active"))
    statuses = case.evidence.statuses
    if not statuses:
        return unknown(case.fault("status"), limit)
    states = {status.active for status in statuses}
    if len(states) > 1:
        return Finding(CheckResult.FAIL, None, said(marked("changed while it was watched")), limit)
    is_active = bool(case.evidence.is_active)
    shown = said(marked("ACTIVE") if is_active else marked("locked"))
    return judged(is_active, shown, limit, is_fine=True)


class _Spread(NamedTuple):
    lowest: float
    highest: float


def _spread(case: Case, values: Sequence[float]) -> _Spread | None:
    """None where too few came, or where they do not cover the two seconds."""
    trials = case.evidence.trials
    if len(trials) < TRIALS_NEEDED or trials[-1].at - trials[0].at < STILL_S * 0.75:
        return None
    return _Spread(min(values), max(values))


def _too_few(case: Case, limit: UserMessage) -> Finding:
    count = len(case.evidence.trials)
    if not count:
        return unknown(case.fault("status"), limit)
    return unknown(said(marked("only {count} reports came in two seconds"), count=str(count)), limit)


def _tilts(trials: Sequence[Trial]) -> list[float]:
    return [trial.status.tilt_deg for trial in trials]


def _accelerations(trials: Sequence[Trial]) -> list[float]:
    return [trial.status.acceleration_g for trial in trials]


def tilt_level(case: Case) -> Finding:
    most = case.expectations.limits.tilt_max_deg
    limit = said(marked("at most {limit}"), limit=f"{most:g}°")
    spread = _spread(case, _tilts(case.evidence.trials))
    if spread is None:
        return _too_few(case, limit)
    return judged(spread.highest, f"{spread.highest:.0f}°", limit, is_fine=spread.highest <= most)


def tilt_still(case: Case) -> Finding:
    most = case.expectations.limits.tilt_spread_max_deg
    limit = said(marked("within {limit} over two seconds"), limit=f"{most:g}°")
    spread = _spread(case, _tilts(case.evidence.trials))
    if spread is None:
        return _too_few(case, limit)
    shown = said(marked("{low} to {high}"), low=f"{spread.lowest:.0f}°", high=f"{spread.highest:.0f}°")
    return judged(spread.highest - spread.lowest, shown, limit, is_fine=spread.highest - spread.lowest <= most)


def acceleration_one_g(case: Case) -> Finding:
    limits = case.expectations.limits
    limit = said(
        marked("{low} to {high}"), low=f"{limits.acceleration_min_g:.1f} g", high=f"{limits.acceleration_max_g:.1f} g"
    )
    spread = _spread(case, _accelerations(case.evidence.trials))
    if spread is None:
        return _too_few(case, limit)
    worst = max(spread, key=lambda value: abs(value - 1.0))
    is_fine = limits.acceleration_min_g <= spread.lowest and spread.highest <= limits.acceleration_max_g
    return judged(worst, f"{worst:.1f} g", limit, is_fine=is_fine)


def acceleration_still(case: Case) -> Finding:
    most = case.expectations.limits.acceleration_spread_max_g
    limit = said(marked("within {limit} over two seconds"), limit=f"{most:.1f} g")
    spread = _spread(case, _accelerations(case.evidence.trials))
    if spread is None:
        return _too_few(case, limit)
    width = round(spread.highest - spread.lowest, 1)
    shown = said(marked("{low} to {high}"), low=f"{spread.lowest:.1f} g", high=f"{spread.highest:.1f} g")
    return judged(width, shown, limit, is_fine=width <= most)


def _answers(case: Case, key: str) -> list[Value]:
    """All answers to a question that was asked three times; none where too few came."""
    values = case.evidence.series.get(key, [])
    return values if len(values) >= _RAW_NEEDED else []


def cell_voltage(case: Case) -> Finding:
    least = case.expectations.limits.cell_voltage_min_v
    limit = said(marked("at least {limit}"), limit=f"{least:.2f} V")
    volts = [float(value) for value in _answers(case, "cell_voltage_v")]
    if not volts:
        return unknown(case.fault("cell_voltage_v"), limit)
    lowest, shown = min(volts), f"{min(volts):.2f} V"
    if cell_outside(lowest, case.expectations.limits, is_charging=None) is not None:
        return judged(lowest, shown, limit, is_fine=False)
    # With external power it is the charging voltage, which lies above the cell's: it proves only that a cell is low.
    charging = _answers(case, "charging")
    if not charging or any(charging):
        reason = marked("{voltage} is the charging voltage") if any(charging) else marked("{voltage}, or the charger's")
        why = said(reason, voltage=shown)
        return unknown(why, limit, do=said(marked("Unplug the external power and check again.")))
    if cell_outside(max(volts), case.expectations.limits, is_charging=False) is not None:
        why = said(marked("{voltage} is more than any lithium cell has"), voltage=f"{max(volts):.2f} V")
        return Finding(CheckResult.FAIL, max(volts), why, limit)
    return judged(lowest, shown, limit, is_fine=True)


def not_charging(case: Case) -> Finding:
    limit = said(marked("no external power"))
    states = _answers(case, "charging")
    if not states:
        return unknown(case.fault("charging"), limit)
    is_charging = any(states)
    return judged(is_charging, YES if is_charging else NO, limit, is_fine=not is_charging)


def bay_closed(case: Case) -> Finding:
    threshold = case.evidence.values.get("light_threshold_v")
    if threshold is None:
        return unknown(case.fault("light_threshold_v"), said(marked("darker than the light threshold")))
    is_inverted = case.expectations.is_light_inverted
    text = marked("above the threshold, {limit}") if is_inverted else marked("below the threshold, {limit}")
    limit = said(text, limit=f"{threshold:.1f} V")
    lights = [float(value) for value in _answers(case, "light_v")]
    if not lights:
        return unknown(case.fault("light_v"), limit)
    worst = min(lights) if is_inverted else max(lights)
    is_dark = bay_outside(worst, float(threshold), is_inverted=is_inverted) is None
    return judged(worst, f"{worst:.1f} V", limit, is_fine=is_dark)


LINE_CHECKS: Final = (
    Check("undisturbed", marked("Check ran undisturbed"), undisturbed,
          marked("What was seen before a restart or a break says nothing about the module now."),
          marked("Check cable and power, and check again.")),
    Check("read_twice", marked("Read twice: the same"), read_twice,
          marked("What changes by itself, or when something else is set, cannot be relied on."),
          marked("Read the settings, write what is wrong, and check again. If it changes again, do not fly.")),
    Check("link_loss", marked("Link: loss"), link_loss,
          marked("Over a bad line a value may be missing or wrong."),
          marked("Check plugs, ground and cable length, and check again.")),
    Check("round_trip", marked("Link: answer time"), round_trip,
          marked("A slow answer points to a bad adapter or a busy computer."),
          marked("Use another adapter or USB socket; close other programs.")),
    Check("status", marked("Status is current"), status_fresh,
          marked("An old status says nothing about the module now."),
          marked("Check power and cable, and check again.")),
    Check("triggered", marked("Not triggered"), not_triggered,
          marked("A module that has fired has no parachute left."),
          marked("Find out why it fired (Triggers), repack the parachute, lock and restart the module.")),
    Check("activation", marked("Activation"), activation,
          marked("An active module fires by itself when it tips over or falls; a locked one must be activated."),
          marked("Send no commands meanwhile, and check again.")),
    Check("tilt", marked("Tilt: level"), tilt_level,
          marked("The attitude trigger counts from level; a wrong zero fires early on one side and late on the other."),
          marked("Set the aircraft level. If it is level, correct the mounting and zero the sensor.")),
    Check("tilt_spread", marked("Tilt: steady"), tilt_still,
          marked("A reading that wanders while the aircraft stands still comes from a loose or failing sensor."),
          marked("Do not touch the aircraft meanwhile; check how the module is fixed.")),
    Check("acceleration", marked("Acceleration: 1 g"), acceleration_one_g,
          marked("At rest the sensor must read 1 g, else free fall is judged wrongly."),
          marked("Set the aircraft down and check again; if it stays, the sensor is faulty: do not fly.")),
    Check("acceleration_spread", marked("Acceleration: steady"), acceleration_still,
          marked("Noise at rest can end or fake a free fall."),
          marked("Stop motors and fans, do not touch the aircraft, and check again.")),
    Check("cell_voltage", marked("Cell voltage"), cell_voltage,
          marked("A weak cell may not deploy the parachute, and falls further in the cold."),
          marked("Charge the module, unplug it, wait a minute and check again.")),
    Check("charging", marked("Not charging"), not_charging,
          marked("With external power the voltage that is read is not the cell's."),
          marked("Unplug the external power and check again.")),
    Check("light", marked("Parachute bay closed"), bay_closed,
          marked("Light in the bay means that it is open; without a calibration, that more light reads higher "
                 "is an assumption."),
          marked("Close the bay; if it is closed, calibrate the light threshold.")),
)  # fmt: skip
