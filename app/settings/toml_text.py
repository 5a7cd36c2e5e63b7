"""Writes the subset of TOML that profiles need; `tomllib` round-trips it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

_SHORT = {'"': '\\"', "\\": "\\\\", "\b": "\\b", "\t": "\\t", "\n": "\\n", "\f": "\\f", "\r": "\\r"}


def toml_text(tables: Mapping[str, Any]) -> str:
    """Formats str, bool, int, finite float, tables of these and lists of such tables. Keys must be bare (letters,
    digits, - and _). Raises TypeError or ValueError for anything else."""
    plain = [key for key, value in tables.items() if not isinstance(value, Mapping | list)]
    lines = [f"{_key(key)} = {_value(tables[key])}" for key in plain]
    for key, value in tables.items():
        if isinstance(value, Mapping):
            lines += _table(f"[{_key(key)}]", value)
        elif isinstance(value, Sequence) and not isinstance(value, str):
            for item in value:
                lines += _table(f"[[{_key(key)}]]", item)
    return "".join(f"{line}\n" for line in lines)


def _table(head: str, values: Mapping[str, Any]) -> list[str]:
    return ["", head, *(f"{_key(key)} = {_value(value)}" for key, value in values.items())]


def _key(key: str) -> str:
    if not key.isascii() or not key.replace("_", "a").replace("-", "a").isalnum():
        raise ValueError(f"{key!r} is not a bare key")
    return key


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} cannot be written to a file")
        return repr(value)
    if isinstance(value, str):
        return '"' + "".join(_character(one) for one in value) + '"'
    raise TypeError(f"{type(value).__name__} cannot be written to a profile")


def _character(one: str) -> str:
    if one in _SHORT:
        return _SHORT[one]
    if ord(one) < 0x20 or ord(one) == 0x7F:
        return f"\\u{ord(one):04X}"
    return one
