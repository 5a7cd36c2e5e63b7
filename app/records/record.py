"""Record of one check: evidence, judgement, people, times and raw frames, as one signed JSON document.

    canonical JSON   sorted keys, no spaces, UTF-8, no NaN: equal content has equal bytes
    "hash"           SHA-256 of everything but hash and signature; "previous" in it makes a chain for each module
    "station"        public key of the computer that wrote it, null where it could not sign
    "signature"      that station's signature of the hash (Ed25519)

The hash has no key: anyone can seal an altered record again. The signature tells who sealed it.
"""

import hashlib
import json
from collections.abc import Mapping
from datetime import datetime

import msgspec

from app import version
from app.engine.device import STATUS_KEYS
from app.engine.target import is_simulated
from app.guided.results import GuidedKind
from app.preflight.evidence import FlagState
from app.preflight.findings import Case, CheckResult
from app.preflight.reading_object import reading_object
from app.preflight.verdict import Assessment, Judged, Verdict, unsigned, verdict_named
from app.settings.profiles import ActivatedBy
from app.stations.station import Station, encoded
from app.text.messages import UserMessage, clean, joined, message
from protocol.fields import Value
from protocol.translatable import marked

FORMAT = "dps-s pre-flight record"
VERSION = 4
"""2 added READY and who activates the module (in 1 a locked module could be GO). 3 added the last guided tests. 4 is
hashed as a whole."""
VERSIONS_IN_PARTS = (1, 2, 3)
"""Hashed part by part."""
READABLE_VERSIONS = (*VERSIONS_IN_PARTS, VERSION)
_IN_PARTS = ("checks", "manual")
_SEALS = ("digests", "hash", "signature")
NOT_STORED = 0
"""Number of a record that is in no store."""

Record = dict[str, object]


def make_record(
    assessment: Assessment, station: Station | None = None, *, at: datetime, adapter: str = "",
    number: int = 1, previous: str | None = None,
) -> Record:  # fmt: skip
    """The record of a check as plain JSON values, sealed and signed. `at` is aware. `previous`: hash of the previous
    record of the chain. `adapter`: USB identity or port, which tells modules without a name apart."""
    if at.tzinfo is None:
        raise ValueError("the time of a record needs its zone")
    case, evidence, person = assessment.case, assessment.case.evidence, assessment.case.person
    began_at = evidence.began_at or 0.0
    record: Record = {
        "format": FORMAT,
        "version": VERSION,
        "verdict": assessment.verdict.value,
        "void": None if evidence.disturbance is None else evidence.disturbance.name.lower(),
        "at": at.isoformat(timespec="seconds"),
        "zone": clean(at.tzname() or ""),
        "program": {"name": "DPS-S Configurator", "version": version()},
        "who": clean(person.who.strip()),
        "module": None if person.module is None else clean(person.module),
        "adapter": clean(adapter),
        "aircraft": clean(person.aircraft.strip()),
        "remarks": "",
        "is_simulated": is_simulated(evidence.port),
        "activated_by": case.profile.activated_by.value,
        "softer_limits": list(assessment.softened),
        "profile": clean(case.profile.name) or None,
        "fingerprint": case.settings_code,
        "are_triggers_set_by_this_check": evidence.is_enabling,
        "checks": [_check(check) for check in assessment.checks],
        "manual": [
            {"text": clean(item.text), "is_done": item.is_done, "is_required": item.is_required}
            for item in assessment.manual
        ],
        "tests": [case.past.tests[kind].stored.plain() for kind in GuidedKind if kind in case.past.tests],
        "read": readings_of(case),
        "trigger_records": [] if evidence.history is None else [kept.raw.hex() for kept in evidence.history.records],
        "frames": [
            [round(frame.at - began_at, 4), frame.way, frame.raw.hex(" ").upper()] for frame in evidence.log.frames
        ],
        "frames_left_out": evidence.log.left_out,
        "number": number,
        "previous": previous,
        "station": None,
    }
    return seal(record, station)


def _check(judged: Judged) -> dict[str, object]:
    finding = judged.finding
    return {
        "id": judged.check.id,
        "title": judged.check.title,
        "result": finding.result.value,
        "measured": finding.measured,
        "shown": finding.shown.to_json(),
        "limit": finding.limit.to_json(),
        "why": judged.check.why,
        "do": judged.do.to_json(),
    }


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
        checks.append({
            "id": f"manual_{number}", "result": result.value,
            "measured": {True: "done", False: "not in order", None: "skipped"}[item.is_done],
            "limit": "done", "why": clean(item.text), "do": "Look at it and tick it.",
        })  # fmt: skip
    return {
        "verdict": assessment.verdict.value, "checks": checks, "read": readings_of(assessment.case),
        "simulated": is_simulated(assessment.case.evidence.port), "softer_limits": list(assessment.softened),
    }  # fmt: skip


def _why(why: str, result: CheckResult, shown: str) -> str:
    return why if result is CheckResult.PASS else f"{why} Found: {shown}."


def caveats(record: Mapping[str, object]) -> list[UserMessage]:
    """Restrictions that are shown beside the verdict."""
    restrictions = [message(marked("SIMULATED MODULE: no evidence."))] if record.get("is_simulated") is True else []
    nobody = unsigned(*(record.get(key) for key in ("who", "module", "aircraft")))
    if nobody is not None and recorded_verdict(record) is not Verdict.NO_GO:
        restrictions.append(nobody)
    softer, checks = record.get("softer_limits"), record.get("checks")
    if isinstance(softer, list) and isinstance(checks, list):
        titles = [
            UserMessage(str(check.get("title")))
            for check in checks
            if isinstance(check, Mapping) and check.get("id") in softer
        ]
        if titles:
            restrictions.append(message(marked("Looser than advised: {checks}."), checks=joined(titles)))
    return restrictions


def list_in(record: Mapping[str, object], key: str) -> list[object]:
    """The list of this name; empty where the record has none."""
    value = record.get(key)
    return value if isinstance(value, list) else []


# The seal


def canonical(value: object) -> bytes:
    """The bytes that are hashed. Raises `ValueError` for values that are not JSON, such as NaN."""
    text = json.dumps(value, ensure_ascii=False, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return text.encode("utf-8", "surrogatepass")


def digest(value: object) -> str:
    return hashlib.sha256(canonical(value)).hexdigest()


def hash_of(record: Mapping[str, object]) -> str:
    """SHA-256 of the content of a record, as its version takes it."""
    content = {key: value for key, value in record.items() if key not in _SEALS}
    return digest(_parts_of(content) if content.get("version") in VERSIONS_IN_PARTS else content)


def _parts_of(content: Mapping[str, object]) -> dict[str, str]:
    """What older versions hashed: SHA-256 by part ("verdict", "checks.tilt" …) and of the order of the lists."""
    digests: dict[str, str] = {}
    for key, value in content.items():
        if key in _IN_PARTS and isinstance(value, list):
            names = [_name(entry, place) for place, entry in enumerate(value, 1)]
            digests[f"{key}: order"] = digest(names)
            digests |= {f"{key}.{name}": digest(entry) for name, entry in zip(names, value, strict=True)}
        else:
            digests[key] = digest(value)
    return digests


def _name(entry: object, place: int) -> str:
    named = entry.get("id") if isinstance(entry, Mapping) else None
    return named if isinstance(named, str) else str(place)


def seal(record: Mapping[str, object], station: Station | None = None) -> Record:
    """`record` with its hash and, where there is a station, its signature."""
    content = {key: value for key, value in record.items() if key not in _SEALS}
    if station is not None:
        content["station"] = encoded(station.public)
    sealed: Record = {**content, "hash": hash_of(content)}
    if station is not None:
        sealed["signature"] = encoded(station.sign(signed_bytes(sealed["hash"])))
    return sealed


def signed_bytes(hash_: object) -> bytes:
    return f"{FORMAT}\n{hash_}\n".encode("utf-8", "surrogatepass")


def as_text(record: Mapping[str, object]) -> str:
    """The content of a record file, indented."""
    return json.dumps(record, ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def recorded_verdict(record: Mapping[str, object]) -> Verdict:
    return verdict_named(record.get("verdict"))


def activated_by(record: Mapping[str, object]) -> ActivatedBy:
    return next((way for way in ActivatedBy if way.value == record.get("activated_by")), ActivatedBy.PERSON)
