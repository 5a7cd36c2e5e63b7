"""JSON Schemas of what the commands print with --json, and of the record of a pre-flight check."""

from collections.abc import Mapping

from app.engine.device import STATUS_KEYS
from app.preflight.reading_object import LIVE_KEYS, SETTING_KEYS
from protocol.catalogue import BY_NAME, SETTINGS
from protocol.fields import Choice, Field, Flag

Schema = dict[str, object]

DIALECT = "https://json-schema.org/draft/2020-12/schema"
TEXT: Schema = {"type": "string"}
YES_NO: Schema = {"type": "boolean"}
COUNT: Schema = {"type": "integer", "minimum": 0}
NUMBER: Schema = {"type": "number"}
HEX: Schema = {"type": "string", "pattern": "^([0-9A-F]{2}( [0-9A-F]{2})*)?$"}
SHA_256: Schema = {"type": "string", "pattern": "^[0-9a-f]{64}$"}
RESULT: Schema = {"enum": ["pass", "fail", "warn", "unknown"]}
VERDICT: Schema = {"enum": ["GO", "READY", "NO-GO"]}
SINGLE: Schema = {"type": ["boolean", "number", "string", "null"]}


def _object(properties: Mapping[str, Schema], *, optional: tuple[str, ...] = ()) -> Schema:
    """With these properties and no others."""
    required = [name for name in properties if name not in optional]
    return {
        "type": "object", "properties": dict(properties), "required": required, "additionalProperties": False,
    }  # fmt: skip


def _map(values: Schema) -> Schema:
    return {"type": "object", "additionalProperties": values}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


def _values_of(shown_by: Field | None) -> Schema:
    match shown_by:
        case Flag():
            return YES_NO
        case Choice(values=values):
            return {"enum": sorted(values.values())}
    return NUMBER


_STATUS_VALUES: dict[str, Schema] = {key: YES_NO if key in ("triggered", "active") else NUMBER for key in STATUS_KEYS}
_LIVE: dict[str, Schema] = {
    "boot_count": {"type": "integer", "minimum": 0, "maximum": 255},
    "cell_voltage_v": NUMBER,
    "charging": YES_NO,
    "light_v": NUMBER,
}
_WRITES = {command.key: _values_of(command.write) for command in SETTINGS}
_SETTINGS = {key: _WRITES[key] for key in SETTING_KEYS}


def _read() -> Schema:
    link = _object({"port": TEXT, "baud_rate": COUNT, "round_trip_ms": _or_null(NUMBER)})
    return _object(
        {
            "link": link,
            "status": _object({key: _or_null(value) for key, value in _STATUS_VALUES.items()}),
            **{key: _or_null(_LIVE[key]) for key in LIVE_KEYS},
            "settings": _object({key: _or_null(value) for key, value in _SETTINGS.items()}),
            "errors": _map(TEXT),
        }
    )


def _set() -> Schema:
    result = _object(
        {
            "wanted": SINGLE,
            "acknowledged": _or_null(YES_NO),
            "read_back": SINGLE,
            "verified": _or_null(YES_NO),
            "verified_age_s": _or_null(NUMBER),
            "error": _or_null(TEXT),
        }
    )
    names: Schema = {"enum": list(SETTING_KEYS)}
    change = _object({"before": SINGLE, "after": SINGLE})
    return _object(
        {
            "results": {**_map(result), "propertyNames": names},
            "changed": {**_map(change), "propertyNames": names},
            "unread": _list(names),
        }
    )


def _history() -> Schema:
    record = _object(
        {
            "boot_count": _LIVE["boot_count"],
            "uptime_s": COUNT,
            "sources": _list({"type": "string", "pattern": "^(serial|attitude|pwm|freefall|bit[0-7])$"}),
            "attitude_threshold_deg": NUMBER,
            "freefall_acceleration_g": NUMBER,
            "freefall_time_s": NUMBER,
            "serial_connected": YES_NO,
            "charging": YES_NO,
            "light_v": NUMBER,
            "cell_voltage_v": NUMBER,
            "implausible": _list(TEXT),
            "raw": HEX,
            "confirmed": YES_NO,
        }
    )
    return _object({"records": _list(record), "empty_slots": COUNT, "answered": YES_NO, "complete": YES_NO})


def _decode() -> Schema:
    """Values are named by the catalogue, units in the names."""
    place: dict[str, Schema] = {"t_s": NUMBER, "offset": COUNT, "hex": HEX}
    direction: Schema = {"enum": ["host_to_module", "module_to_host"]}
    commands: Schema = {"enum": [*BY_NAME, None]}
    frame: Schema = {
        "type": "object",
        "properties": {**place, "valid": {"const": True}, "direction": direction, "command": commands},
        "required": ["offset", "hex", "valid", "direction", "command"],
        "additionalProperties": {"anyOf": [SINGLE, _list(TEXT)]},
    }
    noise = _object(
        {**place, "valid": {"const": False}, "direction": direction, "reason": TEXT}, optional=("t_s", "direction")
    )
    return {"oneOf": [frame, noise]}


def _ports() -> Schema:
    usb: Schema = {"type": ["integer", "null"], "minimum": 0, "maximum": 0xFFFF}
    texts = dict.fromkeys(("device", "description", "maker", "serial_number"), TEXT)
    return _object({"ports": _list(_object({**texts, "vid": usb, "pid": usb, "location": TEXT}))})


def _recordings() -> Schema:
    flags = ("kept", "running", "cut_off", "simulated", "readable", "trashed")
    entry = _object(
        {
            "name": TEXT,
            "started_at": {"type": "string", "format": "date-time"},
            "duration_s": NUMBER,
            "port": TEXT,
            "baud_rate": COUNT,
            "module": _or_null(TEXT),
            "samples": COUNT,
            "size_bytes": COUNT,
            "part": COUNT,
            **dict.fromkeys(flags, YES_NO),
        }
    )
    return _object({"folder": TEXT, "recordings": _list(entry)})


def _fired() -> Schema:
    fire = _object({"t_s": NUMBER, "source": {"enum": ["attitude", "freefall"]}, "tilt_deg": _or_null(COUNT)})
    numbers = dict.fromkeys(("tilt_max_deg", "longest_fall_s", "not_judged_s"), _or_null(NUMBER))
    return _object({"log": TEXT, "fires": _list(fire), **numbers, "problems": _list(TEXT)})


_TIME: Schema = {"type": "string", "format": "date-time"}
_MEMBER = _object({"station": TEXT, "name": TEXT})


def _archive_status() -> Schema:
    chain = _object(
        {
            "station": TEXT, "module": _or_null(TEXT), "audit": YES_NO, "count": COUNT, "missing": COUNT,
            "faults": _list(TEXT),
        }
    )  # fmt: skip
    return _object(
        {
            "station": TEXT, "facts": COUNT, "own": COUNT, "stations": _map(COUNT), "server": _or_null(TEXT),
            "not_shared": COUNT, "last_sync_at": _or_null(_TIME), "conflicts": COUNT, "chains": _list(chain),
        }
    )  # fmt: skip


def _archive_exchange() -> Schema:
    refused = _list(_object(dict.fromkeys(("id", "kind", "made_at", "why"), TEXT)))
    return _object(
        {
            "server": TEXT, "file": TEXT, "sent": COUNT, "received": COUNT, "refused": refused,
            "refused_count": COUNT, "damaged": refused,
        },
        optional=("server", "file"),
    )  # fmt: skip


def _archive_conflicts() -> Schema:
    kind: Schema = {"enum": ["same_name", "same_records", "contradiction"]}
    return _object({"conflicts": _list(_object({"kind": kind, "modules": _list(_MEMBER)}))})


def _archive_report() -> Schema:
    """Of all modules, or with --module the life of those by this name."""
    check = _object(
        {
            "at": _TIME, "station": TEXT, "number": COUNT, "verdict": TEXT, "void": YES_NO, "simulated": YES_NO,
            "altered": YES_NO, "who": TEXT, "aircraft": TEXT, "fingerprint": _or_null(TEXT), "hash": TEXT,
        }
    )  # fmt: skip
    kinds: Schema = {
        "enum": ["no_check", "no_go", "old_check", "trigger_records", "test", "old_test", "conflict"],
    }
    state = _object(
        {
            "module": TEXT, "members": _list(_MEMBER), "last_at": _or_null(_TIME), "last_check": _or_null(check),
            "checks": COUNT, "trigger_records": COUNT, "not_judged": COUNT,
            "tests": _list(_object({"test": TEXT, "verdict": TEXT, "at": _TIME})),
            "due": _list(_object({"kind": kinds, "text": TEXT})),
        }
    )  # fmt: skip
    event = _object(
        {"at": _TIME, "station": TEXT, "kind": TEXT, "id": SHA_256, "told": TEXT, "content": {"type": "object"}}
    )
    point = _object({"at": _TIME, "station": TEXT, "value": NUMBER})
    life = _object(
        {"module": TEXT, "members": _list(_MEMBER), "events": _list(event), "values": _map(_list(point))}
    )  # fmt: skip
    return {"oneOf": [_object({"at": _TIME, "modules": _list(state)}), _object({"lives": _list(life)})]}


def _preflight() -> Schema:
    check = _object({"id": TEXT, "result": RESULT, "measured": SINGLE, "limit": TEXT, "why": TEXT, "do": TEXT})
    return _object(
        {
            "verdict": VERDICT,
            "checks": _list(check),
            "read": _read(),
            "simulated": YES_NO,
            "softer_limits": _list(TEXT),
        }
    )


def _record() -> Schema:
    message: Schema = {
        "type": "object",
        "properties": {"text": TEXT, "values": _map({"anyOf": [TEXT, {"$ref": "#/$defs/message"}]})},
        "required": ["text"],
        "additionalProperties": False,
    }
    said: Schema = {"$ref": "#/$defs/message"}
    check = _object(
        {
            "id": TEXT, "title": TEXT, "result": RESULT, "measured": SINGLE,
            "shown": said, "limit": said, "why": TEXT, "do": said,
        }
    )  # fmt: skip
    frame: Schema = {
        "type": "array", "prefixItems": [NUMBER, {"enum": ["out", "in", "noise"]}, HEX], "minItems": 3, "maxItems": 3,
    }  # fmt: skip
    test = _object(
        {
            "test": TEXT, "verdict": TEXT, "at": TEXT, "who": TEXT, "is_simulated": YES_NO,
            "measured": _list({"type": "object"}),
        }
    )  # fmt: skip
    manual = _object({"text": TEXT, "is_done": _or_null(YES_NO), "is_required": YES_NO})
    record = _object(
        {
            "format": {"const": "dps-s pre-flight record"},
            "version": {"const": 3},
            "verdict": VERDICT,
            "void": _or_null(TEXT),
            "at": {"type": "string", "format": "date-time"},
            "zone": TEXT,
            "program": _object({"name": TEXT, "version": TEXT}),
            "who": TEXT,
            "module": _or_null(TEXT),
            "adapter": TEXT,
            "aircraft": TEXT,
            "remarks": TEXT,
            "is_simulated": YES_NO,
            "activated_by": TEXT,
            "softer_limits": _list(TEXT),
            "profile": _or_null(TEXT),
            "fingerprint": _or_null(TEXT),
            "are_triggers_set_by_this_check": YES_NO,
            "checks": _list(check),
            "manual": _list(manual),
            "tests": _list(test),
            "read": _read(),
            "trigger_records": _list({"type": "string", "pattern": "^[0-9a-f]{32}$"}),
            "frames": _list(frame),
            "frames_left_out": COUNT,
            "number": COUNT,
            "previous": _or_null(SHA_256),
            "station": _or_null(TEXT),
            "digests": _map(SHA_256),
            "hash": SHA_256,
            "signature": TEXT,
        },
        optional=("signature",),
    )
    return {**record, "$defs": {"message": message}}


_TITLES = {
    "ports": "dps-s ports --json",
    "read": "dps-s read --json",
    "set": "dps-s set --json",
    "history": "dps-s history --json",
    "monitor": "dps-s monitor --json, one line",
    "find": "dps-s find --json",
    "preflight": "dps-s preflight --json, for one port",
    "record": "The record of a pre-flight check",
    "decode": "dps-s decode --json, one line",
    "recordings": "dps-s recordings list --json",
    "fired": "dps-s fired --json, one line",
    "archive_status": "dps-s archive status --json",
    "archive_exchange": "dps-s archive sync, export or import --json",
    "archive_conflicts": "dps-s archive conflicts --json",
    "archive_report": "dps-s archive report --json",
}
NAMES = tuple(_TITLES)


def schema_of(name: str) -> Schema:
    """The schema of one of `NAMES`."""
    made = {
        "ports": _ports,
        "read": _read,
        "set": _set,
        "history": _history,
        "monitor": lambda: _object({"t_s": NUMBER, **_STATUS_VALUES}),
        "find": lambda: _object({"baud_rate": _or_null(COUNT), "tried": _list(COUNT)}),
        "preflight": _preflight,
        "record": _record,
        "decode": _decode,
        "recordings": _recordings,
        "fired": _fired,
        "archive_status": _archive_status,
        "archive_exchange": _archive_exchange,
        "archive_conflicts": _archive_conflicts,
        "archive_report": _archive_report,
    }[name]()
    return {"$schema": DIALECT, "title": _TITLES[name], **made}
