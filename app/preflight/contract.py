"""What a check found, as plain JSON: the object of `dps-s preflight --json`, and the readings in it and in a record."""

from statistics import median_high

import msgspec

from app.engine.conversation import STATUS_KEYS
from app.engine.target import is_simulated
from app.preflight.checks import Case, CheckResult
from app.preflight.reading_object import reading_object
from app.preflight.verdict import Assessment, blocks_go
from app.text.messages import clean
from protocol.fields import Value


def readings_of(case: Case) -> dict[str, object]:
    """The last readings in the form of `dps-s read --json`; null where nothing is known."""
    evidence = case.evidence
    values: dict[str, Value | None] = {key: readings[-1] for key, readings in evidence.series.items() if readings}
    values |= evidence.values | {"baud_rate": evidence.baud_rate or None}
    if evidence.status is not None:
        values |= {key: getattr(evidence.status, key) for key in STATUS_KEYS}
    values |= {key: flag.is_enabled for key, flag in evidence.flags.items()}
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
    checks: list[dict[str, object]] = []
    for judged in assessment.checks:
        check, finding = judged.check, judged.finding
        found = finding.shown.in_english().removesuffix(".")
        checks.append(
            {
                "id": check.id,
                "result": finding.result.value,
                "measured": None if finding.result is CheckResult.UNKNOWN else finding.measured,
                "limit": finding.limit.in_english(),
                "why": check.why if finding.result is CheckResult.PASS else f"{check.why} Found: {found}.",
                "do": judged.do.in_english(),
            }
        )
    for number, item in enumerate(assessment.manual, 1):
        result, measured = CheckResult.UNKNOWN if blocks_go(item) else CheckResult.WARN, "skipped"
        if item.is_done is not None:
            result, measured = (CheckResult.PASS, "done") if item.is_done else (CheckResult.FAIL, "not in order")
        checks.append(
            {
                "id": f"manual_{number}",
                "result": result.value,
                "measured": measured,
                "limit": "done",
                "why": clean(item.text),
                "do": "Look at it and tick it.",
            }
        )
    return {
        "verdict": assessment.verdict.value,
        "checks": checks,
        "read": readings_of(assessment.case),
        "simulated": is_simulated(assessment.case.evidence.port),
        "softer_limits": list(assessment.softened),
    }
