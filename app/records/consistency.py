"""Checks that a record is consistent: recomputes its verdict from its checks.

The hash of an altered record that was sealed again is valid; its verdict must still follow from its checks.
"""

from collections import Counter
from collections.abc import Iterator, Mapping

from app.preflight.findings import CheckResult
from app.preflight.verdict import Verdict, verdict_of
from app.text.messages import UserMessage, clean, message
from protocol.translatable import marked

REQUIRED = frozenset({
    "undisturbed", "link_loss", "round_trip", "status", "triggered", "activation", "tilt", "tilt_spread",
    "acceleration", "acceleration_spread", "cell_voltage", "charging", "light", "attitude_threshold",
    "freefall_acceleration", "freefall_time", "light_threshold", "attitude_trigger", "freefall_trigger",
    "trigger_records", "boot_count", "fingerprint",
})  # fmt: skip
"""Checks that every version of a record contains."""
_READ_AS = {
    "activation": ("status", "active"),
    "boot_count": ("boot_count",),
    "attitude_threshold": ("settings", "attitude_threshold_deg"),
    "freefall_acceleration": ("settings", "freefall_acceleration_g"),
    "freefall_time": ("settings", "freefall_time_s"),
    "light_threshold": ("settings", "light_threshold_v"),
}
"""Checks whose measured value is also among the readings, and where."""


def contradictions(record: Mapping[str, object]) -> tuple[UserMessage, ...]:
    """The parts of a record that contradict each other; never raises, whatever the record contains."""
    return tuple(_contradictions(record))


def _contradictions(record: Mapping[str, object]) -> Iterator[UserMessage]:
    checks = [one for one in list_in(record, "checks") if isinstance(one, Mapping)]
    found = Counter(str(one.get("id")) for one in checks)
    missing = sorted(REQUIRED - found.keys())
    if missing:
        yield message(marked("missing checks: {checks}"), checks=", ".join(missing))
    doubled = [clean(name, longest=40) for name, count in found.items() if count > 1]
    if doubled:
        yield message(marked("duplicate checks: {checks}"), checks=", ".join(doubled[:5]))
    stated, follows = record.get("verdict"), verdict_from(record)
    if stated != follows.value:
        yield message(marked("stated {stated}, but the checks give {follows}"), stated=clean(str(stated), longest=20),
                   follows=follows.value)  # fmt: skip
    for one in checks:
        where = _READ_AS.get(str(one.get("id")))
        read = _at(record.get("read"), where) if where is not None else None
        measured = one.get("measured")
        if (
            read is not None
            and measured is not None
            and read != measured
            and one.get("result") == CheckResult.PASS.value
        ):
            title = UserMessage(clean(str(one.get("title"))))
            yield message(marked("{check}: judged {measured}, read {read}"), check=title,
                       measured=clean(str(measured), longest=20), read=clean(str(read), longest=20))  # fmt: skip


def verdict_from(record: Mapping[str, object]) -> Verdict:
    """The verdict that follows from the checks, the manual items and the state that the module reported."""
    checks = list_in(record, "checks")
    is_fine = record.get("void") is None and bool(checks) and all(_is_fine(one) for one in checks)
    is_fine = is_fine and all(_is_manual_fine(one) for one in list_in(record, "manual"))
    if record.get("version") == 1:  # a locked module could be GO
        return Verdict.GO if is_fine else Verdict.NO_GO
    active = _at(record.get("read"), ("status", "active"))
    return verdict_of(is_fine=is_fine, is_active=active if isinstance(active, bool) else None)


def _is_fine(check: object) -> bool:
    return isinstance(check, Mapping) and check.get("result") in (CheckResult.PASS.value, CheckResult.WARN.value)


def _is_manual_fine(item: object) -> bool:
    if not isinstance(item, Mapping):
        return False
    return item.get("is_done") is True or (item.get("is_done") is None and item.get("is_required") is False)


def list_in(record: Mapping[str, object], key: str) -> list[object]:
    """The list of this name; empty where the record has none."""
    value = record.get(key)
    return value if isinstance(value, list) else []


def _at(value: object, path: tuple[str, ...]) -> object:
    for name in path:
        value = value.get(name) if isinstance(value, Mapping) else None
    return value
