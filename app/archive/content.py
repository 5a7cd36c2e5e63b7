"""What a fact may contain: the one place where size, depth, numbers, texts and names of anybody's facts are bounded.

A fact of a kind that this version does not know is bounded too; its meaning is its own.
"""

import json
from collections.abc import Callable, Mapping
from types import NoneType
from typing import Final, NoReturn

from app.stations.station import KEY_BYTES, decoded
from app.store.facts import FORMER_ENTRY, FactKind, utc_time
from app.text.messages import MAX_TEXT_LENGTH, clean

MAX_LENGTH: Final = 1_000_000
"""Characters of a payload. A record with all the frames that a check keeps has 150,000."""
MAX_DEPTH: Final = 20
"""Lists and objects in each other; a record has 12."""
MAX_NUMBER: Final = 2**63
MAX_RAW_LENGTH: Final = 200
"""Hexadecimal digits of a trigger record; 32 are used."""
EARLIEST: Final = "1970-01-02"
LATEST: Final = "3000"
"""Every computer can show the times between these two in its own zone."""
DETAIL: Final = FORMER_ENTRY.index("detail")


def content_of(kind: str, payload: str) -> Mapping[str, object]:
    """The content of a fact. Raises `ValueError` for what no station records."""
    if len(payload) > MAX_LENGTH or not payload.isascii():
        raise ValueError("payload")
    content = object_of(payload)
    for name, is_valid in {"previous": _is_text_or_none, **_SHAPES.get(kind, {})}.items():
        if not is_valid(content.get(name)):
            raise ValueError(name)
    return content


def object_of(text: str) -> Mapping[str, object]:
    """A bounded JSON object. Raises `ValueError`."""
    try:
        value = json.loads(text, parse_constant=_refuse)
    except RecursionError:
        raise ValueError("depth") from None
    if not isinstance(value, dict):
        raise ValueError("object")
    _bound(value)
    return value


def is_time(text: str) -> bool:
    """Whether `utc_time` made it, of a time that every computer can show."""
    try:
        return EARLIEST <= text < LATEST and utc_time(text) == text
    except (ValueError, OverflowError):
        return False


def _bound(value: object) -> None:
    """Without recursion, which is what deep nesting attacks. Raises `ValueError`."""
    level: list[object] = [value]
    for _ in range(MAX_DEPTH):
        below: list[object] = []
        for part in level:
            if isinstance(part, dict):
                below += part.keys()
                below += part.values()
            elif isinstance(part, list):
                below += part
            elif isinstance(part, str):
                part.encode()  # UnicodeEncodeError, a ValueError, for an unpaired surrogate
            elif isinstance(part, int | float) and not -MAX_NUMBER <= part < MAX_NUMBER:
                raise ValueError("number")  # also an infinite one
        level = below
        if not level:
            return
    raise ValueError("depth")


def _refuse(name: str) -> NoReturn:
    raise ValueError(name)


def _is_name(value: object) -> bool:
    """A name that looks like what it is: no control characters or direction marks, and not too long."""
    return isinstance(value, str) and value.strip() != "" and clean(value, longest=MAX_TEXT_LENGTH) == value


def _is_name_or_none(value: object) -> bool:
    return value is None or value == "" or _is_name(value)


def _is_a(*types: type) -> Callable[[object], bool]:
    return lambda value: isinstance(value, types)


_is_text, _is_text_or_none = _is_a(str), _is_a(str, NoneType)


def _is_raw(value: object) -> bool:
    if not isinstance(value, str) or len(value) > MAX_RAW_LENGTH:
        return False
    try:
        return bytes.fromhex(value).hex() == value
    except ValueError:
        return False


def _is_measured(value: object) -> bool:
    return isinstance(value, dict) and all(isinstance(one, int | float) for one in value.values())


def _is_entry(value: object) -> bool:
    """A row of the audit log. Its detail is JSON within JSON."""
    if not isinstance(value, list) or len(value) != len(FORMER_ENTRY):
        return False
    if not all(part is None or (isinstance(part, str | int) and not isinstance(part, bool)) for part in value):
        return False
    detail = value[DETAIL]
    return isinstance(detail, str) and _is_name_or_none(object_of(detail).get("module"))


def _is_pair(value: object) -> bool:
    if not isinstance(value, list) or len(value) != 2 or value[0] == value[1]:
        return False
    return all(
        isinstance(module, list) and len(module) == 2 and decoded(module[0], KEY_BYTES) and _is_name(module[1])
        for module in value
    )


_OF_MODULE: Final = {"module": _is_name_or_none}
_SHAPES: Final[Mapping[str, Mapping[str, Callable[[object], bool]]]] = {
    FactKind.MODULE.value: {"module": _is_name},
    FactKind.TRIGGER_RECORD.value: {"module": _is_name, "raw": _is_raw},
    FactKind.JUDGEMENT.value: {"module": _is_name, "raw": _is_raw, "judgement": _is_text_or_none},
    FactKind.SNAPSHOT.value: {**_OF_MODULE, "settings": _is_a(dict)},
    FactKind.STATION.value: {"public_key": _is_text, "name": _is_name},
    FactKind.CHECK.value: {
        **_OF_MODULE, "verdict": _is_text, "is_void": _is_a(bool), "is_simulated": _is_a(bool), "who": _is_text,
        "aircraft": _is_text, "code": _is_text_or_none, "measured": _is_measured, "document": _is_text,
    },
    FactKind.GUIDED_TEST.value: {**_OF_MODULE, "test": _is_text, "verdict": _is_text},
    FactKind.SERVICE.value: {
        "module": _is_name, "service": _is_text, "on": _is_text, "due": _is_text_or_none, "who": _is_text,
        "note": _is_text,
    },
    FactKind.PROVISIONED.value: {**_OF_MODULE, "name": _is_name},
    FactKind.AUDIT.value: {**_OF_MODULE, "entry": _is_entry, "previous": _is_text, "hash": _is_text},
    FactKind.ACT.value: {**_OF_MODULE, "act": _is_text, "frame": _is_text},
    FactKind.FIRED.value: {"module": _is_name, "port": _is_text},
    FactKind.OUTCOME.value: {**_OF_MODULE, "of": _is_text, "outcome": _is_text},
    FactKind.SETTLEMENT.value: {
        "modules": _is_pair, "is_same": _is_a(bool), "name": _is_name_or_none,
        "who": _is_name_or_none, "revision": lambda value: type(value) is int and value >= 1,
    },
}  # fmt: skip
"""By kind: what this version uses of its content, and what that must be."""
