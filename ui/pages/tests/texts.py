"""Texts of the Tests page: instruction, live value, result."""

from datetime import datetime

from app.guided.kept_test import StoredTest
from app.guided.results import VERDICT_WORDS, BrokenOff, GuidedKind, GuidedResult, GuidedVerdict
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import capitalised, join_names
from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from ui.pages.tests.controller import GuidedController, Stage
from ui.pages.tests.widgets import LiveMark, LiveReading
from ui.services.port import Ports
from ui.style.theme import Meaning

VERDICT_MEANINGS = {
    GuidedVerdict.PASSED: Meaning.GOOD,
    GuidedVerdict.FAILED: Meaning.DANGER,
    GuidedVerdict.UNCLEAR: Meaning.ATTENTION,
}
_UNKNOWN = "–"


def instruction(work: GuidedController) -> str:
    """What to do now."""
    if work.stage in (Stage.PREPARING, Stage.MEASURING):
        report = work.report
        return _formatted(report.doing, report.values) if report is not None else tr("Asking the module…")
    return work.test.steps[work.step].translated() if work.stage is Stage.CONFIRMING else ""


def _formatted(text: str, values: tuple[tuple[str, object], ...]) -> str:
    words = {name: value.translated() if isinstance(value, UserMessage) else value for name, value in values}
    return tr(text, **words) if "{" in text else tr(text)


def outcome_text(outcome: GuidedResult | BrokenOff | None) -> tuple[Meaning, str]:
    """The verdict in a line."""
    if isinstance(outcome, GuidedResult):
        return VERDICT_MEANINGS[outcome.verdict], capitalised(tr(VERDICT_WORDS[outcome.verdict]))
    if isinstance(outcome, BrokenOff):
        return Meaning.ATTENTION, outcome.reason.translated()
    return Meaning.UNKNOWN, ""


def last_text(last: StoredTest | None) -> str:
    """Result, date and person of the last test."""
    if last is None:
        return tr("never tested")
    try:
        when = f"{datetime.fromisoformat(last.at).astimezone():%Y-%m-%d}"
    except ValueError:
        when = last.at
    verdict = tr(VERDICT_WORDS[last.verdict])
    return f"{verdict} {when}, {last.who or '—'}"


def live_reading(work: GuidedController, connector: Ports) -> LiveReading:
    """The current value against the limits of the test."""
    match work.kind:
        case GuidedKind.TILT:
            return _tilt(connector, _value(connector, "attitude_threshold_deg"))
        case GuidedKind.FREE_FALL:
            return _acceleration(connector, _value(connector, "freefall_acceleration_g"))
        case GuidedKind.BAY:
            return _light(connector, _value(connector, "light_threshold_v"))
        case _:
            return _losses(work)


def _value(connector: Ports, key: str) -> float | None:
    value = connector.current.device.fresh(key, connector.clock())
    return None if value is None else float(value)


def _tilt(connector: Ports, threshold: float | None) -> LiveReading:
    value = _value(connector, "tilt_deg")
    shown = _UNKNOWN if value is None else f"{value:.0f}°"
    if threshold is None:
        return LiveReading(tr("Tilt"), shown, value, 180.0)
    reset = threshold - RESET_BELOW_THRESHOLD_DEG
    marks = (
        LiveMark(reset, tr("rearms at {angle:.0f}°", angle=reset), Meaning.INFORMATION),
        LiveMark(threshold, tr("fires at {angle:.0f}°", angle=threshold), Meaning.DANGER),
    )
    has_fired = connector.current.device.fresh("triggered", connector.clock())
    caption = join_names((tr("Tilt"), tr("TRIGGERED") if has_fired else tr("not triggered")))
    return LiveReading(caption, shown, value, 120.0, marks)


def _acceleration(connector: Ports, threshold: float | None) -> LiveReading:
    value = _value(connector, "acceleration_g")
    shown = _UNKNOWN if value is None else f"{value:.1f} g"
    marks: tuple[LiveMark, ...] = ()
    if threshold is not None:
        marks = (LiveMark(threshold, tr("falls below {value:.1f} g", value=threshold), Meaning.INFORMATION),)
    return LiveReading(tr("Acceleration"), shown, value, 2.0, marks)


def _light(connector: Ports, threshold: float | None) -> LiveReading:
    value = _value(connector, "light_v")
    shown = _UNKNOWN if value is None else f"{value:.1f} V"
    marks: tuple[LiveMark, ...] = ()
    if threshold is not None:
        marks = (LiveMark(threshold, tr("threshold {value:.1f} V", value=threshold), Meaning.INFORMATION),)
    highest = max(3.0, 1.5 * (threshold or 0.0), value or 0.0)
    return LiveReading(tr("Light"), shown, value, highest, marks)


def _losses(work: GuidedController) -> LiveReading:
    values = dict(work.report.values) if work.report is not None else {}
    asked, lost = values.get("asked"), values.get("lost")
    if isinstance(asked, int) and isinstance(lost, int):
        return LiveReading(tr("lost"), f"{lost} / {asked}", float(lost))
    return LiveReading(tr("lost"), _UNKNOWN)
