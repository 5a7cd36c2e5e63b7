"""The text of a profile: a new one, or a person's file with the changes in it, its comments and its order kept."""

from collections.abc import Mapping
from typing import Any

import tomlkit
from tomlkit.container import Container
from tomlkit.items import AoT, Item, Table

from app.settings.profiles import FORMAT, LIMITS, OWN_KEYS, SETTINGS_BY_KEY, TABLES, ActivatedBy, Profile


def toml_of(profile: Profile, source: str = "") -> str:
    """`source`: the text of a valid profile, in which only what differs is changed."""
    document = tomlkit.parse(source)
    tables = _tables_of(profile)
    settings = tables["settings"]
    # A person may have written settings outside of their table.
    outside = {key: settings.pop(key) for key in SETTINGS_BY_KEY if key in document and key in settings}
    own = {key: tables[key] for key in OWN_KEYS if key in tables}
    if not source:
        document["format"], document["settings"] = FORMAT, tomlkit.table()  # by which others know a profile
    _change(document, own | outside, (*OWN_KEYS, *SETTINGS_BY_KEY))
    for name in TABLES:
        if name not in document and tables[name]:
            document[name] = tomlkit.table()
        table = document.get(name)
        if isinstance(table, Table):
            _change(table, tables[name], tuple(table))
        elif table is not None and table.unwrap() != tables[name]:  # in one line
            document[name] = tables[name]
    _change_manual(document, profile)
    return tomlkit.dumps(document)


def _tables_of(profile: Profile) -> dict[str, Any]:
    """Without what needs not be said."""
    own = {
        "airframe": profile.airframe, "notes": profile.notes, "approved_fingerprint": profile.approved_fingerprint,
        "light_inverted": profile.is_light_inverted, "service_required": profile.is_service_required,
    }  # fmt: skip
    is_person = profile.activated_by is ActivatedBy.PERSON
    return {
        "name": profile.name,
        **{key: value for key, value in own.items() if value},
        "settings": {key: profile.settings[key] for key in SETTINGS_BY_KEY if key in profile.settings},
        "expectations": {} if is_person else {"activated_by": profile.activated_by.value},
        "limits": {name: profile.limits[name] for name in LIMITS if name in profile.limits},
        "tests": {kind.value: days for kind, days in profile.tests_within_days.items()},
    }


def _change(table: Container | Table, values: Mapping[str, object], known: tuple[str, ...]) -> None:
    """Of the `known` keys those in `values` remain; what is the same stays as it is written."""
    for key in known:
        if key in table and key not in values:
            del table[key]
    for key, value in values.items():
        if key not in table:
            _append(table, key, value)
        elif _plain(table[key]) != value:
            table[key] = value


def _append(table: Container | Table, key: str, value: object) -> None:
    """Before the comments at the end of a table: those are about the next one."""
    body = table.value.body if isinstance(table, Table) else []
    tail = []
    while body and body[-1][0] is None:
        tail.append(body.pop())
    table[key] = value
    body.extend(reversed(tail))


def _change_manual(document: Container, profile: Profile) -> None:
    lines = [(line.text, line.is_required) for line in profile.manual]
    rows = document.get("manual", [])
    if [(_plain(row["text"]), bool(_plain(row.get("required", False)))) for row in rows] == lines:
        return
    known = {str(_plain(row["text"])): row for row in rows} if isinstance(rows, AoT) else {}
    changed = tomlkit.aot()
    for text, is_required in lines:
        row = known.pop(text, None) or tomlkit.table()
        _change(row, {"text": text, "required": is_required}, ())
        changed.append(row)
    document.pop("manual", None)
    if lines:
        document["manual"] = changed


def _plain(value: object) -> object:
    return value.unwrap() if isinstance(value, Item) else value
