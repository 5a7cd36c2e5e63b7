"""What a check found, as plain JSON: the object of `dps-s preflight --json`, and the readings in it and in a record."""

from statistics import median_high

import msgspec

from app.engine.conversation import STATUS_KEYS
from app.engine.target import is_simulated
from app.preflight.findings import Case, CheckResult
from app.preflight.reading_object import reading_object
from app.preflight.verdict import Assessment, Judged
from app.settings.profiles import ManualLine
from app.text.messages import clean
from protocol.fields import Value


def readings_of(case: Case) -> dict[str, object]:
    """The last readings in the form of `dps-s read --json`; null where nothing is known."""
    evidence = case.evidence
    values: dict[str, Value | None] = {key: readings[-1] for key, readings in evidence.series.items() if readings}
    values |= evidence.values | {"baud_rate": evidence.baud_rate or None}
    if evidence.status is not None:
        values |= {key: getattr(evidence.status, key) for key in STATUS_KEYS}
    for key, flag in evidence.flags.items():
        values[key] = flag.is_enabled
    reading = reading_object(
        port=clean(evidence.port),
        baud_rate=evidence.baud_rate,
        round_trip_s=median_high(evidence.round_trips_s) if evidence.round_trips_s else None,
        values=values,
        errors={key: why.in_english() for key, why in sorted(evidence.faults.items())},
    )
    found: dict[str, object] = msgspec.to_builtins(reading)
    return found


def contract_of(assessment: Assessment) -> dict[str, object]:
    """The object of `dps-s preflight --json`, in English, with the manual items last, as "manual_1" …"""
    manual = [_manual_object(number, item) for number, item in enumerate(assessment.manual, 1)]
    return {
        "verdict": assessment.verdict.value,
        "checks": [*map(_check_object, assessment.checks), *manual],
        "read": readings_of(assessment.case),
        "simulated": is_simulated(assessment.case.evidence.port),
        "softer_limits": list(assessment.softened),
    }


def _check_object(judged: Judged) -> dict[str, object]:
    check, finding = judged.check, judged.finding
    why = check.why
    if finding.result is not CheckResult.PASS:
        why = f"{why} Found: {finding.shown.in_english().removesuffix('.')}."
    return {
        "id": check.id,
        "result": finding.result.value,
        "measured": None if finding.result is CheckResult.UNKNOWN else finding.measured,
        "limit": finding.limit.in_english(),
        "why": why,
        "do": judged.do.in_english(),
    }


def _manual_object(number: int, item: ManualLine) -> dict[str, object]:
    if item.is_done is None:
        result, measured = CheckResult.UNKNOWN if item.is_required else CheckResult.WARN, "skipped"
    elif item.is_done:
        result, measured = CheckResult.PASS, "done"
    else:
        result, measured = CheckResult.FAIL, "not in order"
    return {
        "id": f"manual_{number}",
        "result": result.value,
        "measured": measured,
        "limit": "done",
        "why": clean(item.text),
        "do": "Look at it and tick it.",
    }
