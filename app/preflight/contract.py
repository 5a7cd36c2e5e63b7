"""What a check found, as plain JSON: the object of `dps-s preflight --json`, and the readings in it and in a record."""

import msgspec

from app.engine.device import STATUS_KEYS
from app.engine.target import is_simulated
from app.preflight.evidence import FlagState
from app.preflight.findings import Case, CheckResult
from app.preflight.reading_object import reading_object
from app.preflight.verdict import Assessment
from app.text.messages import clean
from protocol.fields import Value


def readings_of(case: Case) -> dict[str, object]:
    """The last readings in the form of `dps-s read --json`; null where nothing is known."""
    evidence = case.evidence
    trips = sorted(evidence.round_trips_s)
    values: dict[str, Value | None] = {key: readings[-1] for key, readings in evidence.series.items() if readings}
    values |= evidence.values | {"baud_rate": evidence.baud_rate or None}
    if evidence.status is not None:
        values |= {key: getattr(evidence.status, key) for key in STATUS_KEYS}
    for key, flag in evidence.flags.items():
        values[key] = {FlagState.ENABLED: True, FlagState.DISABLED: False}.get(flag.state)
    reading = reading_object(
        port=clean(evidence.port),
        baud_rate=evidence.baud_rate,
        round_trip_s=trips[len(trips) // 2] if trips else None,
        values=values,
        errors={key: why.in_english() for key, why in sorted(evidence.faults.items())},
    )
    found: dict[str, object] = msgspec.to_builtins(reading)
    return found


def contract_of(assessment: Assessment) -> dict[str, object]:
    """The object of `dps-s preflight --json`, in English, with the manual items last, as "manual_1" …"""
    checks: list[dict[str, object]] = [
        {
            "id": check.check.id,
            "result": check.finding.result.value,
            "measured": check.finding.measured if check.finding.result is not CheckResult.UNKNOWN else None,
            "limit": check.finding.limit.in_english(),
            "why": _why(check.check.why, check.finding.result, check.finding.shown.in_english()),
            "do": check.do.in_english(),
        }
        for check in assessment.checks
    ]
    for number, item in enumerate(assessment.manual, 1):
        if item.is_done is None:
            result = CheckResult.UNKNOWN if item.is_required else CheckResult.WARN
        else:
            result = CheckResult.PASS if item.is_done else CheckResult.FAIL
        measured = {True: "done", False: "not in order", None: "skipped"}[item.is_done]
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


def _why(why: str, result: CheckResult, shown: str) -> str:
    return why if result is CheckResult.PASS else f"{why} Found: {shown}."
