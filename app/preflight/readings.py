"""The readings of a check, for `dps-s preflight --json` and for its record."""

from statistics import median_high

from app.engine.conversation import STATUS_KEYS
from app.preflight.checks import Case
from app.preflight.reading_object import ReadJson, reading_object
from app.text.messages import clean
from protocol.fields import Value


def readings_of(case: Case) -> ReadJson:
    """The last readings in the form of `dps-s read --json`; null where nothing is known."""
    evidence = case.evidence
    values: dict[str, Value | None] = {key: readings[-1] for key, readings in evidence.series.items() if readings}
    values |= evidence.values | {"baud_rate": evidence.baud_rate or None}
    if evidence.status is not None:
        values |= {key: getattr(evidence.status, key) for key in STATUS_KEYS}
    values |= {key: flag.is_enabled for key, flag in evidence.flags.items()}
    return reading_object(
        port=clean(evidence.port),
        baud_rate=evidence.baud_rate,
        round_trip_s=median_high(evidence.round_trips_s) if evidence.round_trips_s else None,
        values=values,
        errors={key: why.in_english() for key, why in sorted(evidence.faults.items())},
    )
