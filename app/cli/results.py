"""What the commands print with --json, as structures: `dps-s schema NAME` prints the schema made of each.

A value that is not known is null. Names have the unit in them. A field that is only there sometimes is left out where
it has nothing to say (`UNSET`).
"""

from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec
from msgspec import UNSET, Meta, Struct, UnsetType

from app.archive.due import DueKind
from app.preflight.reading_object import ReadJson
from app.text.user_error import ErrorCode
from protocol.catalogue import BY_NAME, COMMANDS, RECORD_PART, SETTINGS, STATUS_PARTS
from protocol.frame import Direction

Value = bool | int | float | str | None
Byte = Annotated[int, Meta(ge=0, le=255)]
Count = Annotated[int, Meta(ge=0)]
Hex = Annotated[str, Meta(pattern=r"^([0-9A-F]{2}( [0-9A-F]{2})*)?$")]
Time = Annotated[str, Meta(extra_json_schema={"format": "date-time"})]
"""ISO 8601 with an offset."""
if TYPE_CHECKING:
    SettingName = str
    CommandName = str
else:
    SettingName = Literal[tuple(command.key for command in SETTINGS)]
    CommandName = Literal[tuple(BY_NAME)]


class ResultJson(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What every result has in common: nothing but the rule that it has no other fields."""


class FailureJson(ResultJson, frozen=True, kw_only=True):
    """Why a command has no result. `hint` is what to do next, or empty."""

    code: ErrorCode
    message: str
    hint: str


class ErrorJson(ResultJson, frozen=True, kw_only=True):
    """Printed in the place of a result."""

    error: FailureJson


# Ports and the line


class PortJson(ResultJson, frozen=True, kw_only=True):
    device: str
    description: str
    maker: str
    serial_number: str
    vid: Annotated[int, Meta(ge=0, le=65535)] | None
    pid: Annotated[int, Meta(ge=0, le=65535)] | None
    location: str


class PortsJson(ResultJson, frozen=True, kw_only=True):
    ports: list[PortJson]


class FindJson(ResultJson, frozen=True, kw_only=True):
    """`baud_rate` is null where nothing answers at any of the rates that were tried."""

    baud_rate: Count | None
    tried: list[Count]


class MonitorJson(ResultJson, frozen=True, kw_only=True):
    """One status report. `t_s`: seconds since the first one."""

    t_s: float
    tilt_deg: float
    acceleration_g: float
    triggered: bool
    active: bool


# Settings


class SetResultJson(ResultJson, frozen=True, kw_only=True):
    """`read_back` and `verified` are null for what cannot be read back: acknowledged is all there is to know."""

    wanted: Value
    before: Value
    acknowledged: bool | None
    read_back: Value
    verified: bool | None
    verified_age_s: float | None
    error: str | None


class ChangedJson(ResultJson, frozen=True, kw_only=True):
    before: Value
    after: Value


class SetJson(ResultJson, frozen=True, kw_only=True):
    """`changed`: settings that changed without being written; `unread`: those that were not read again."""

    results: dict[SettingName, SetResultJson]
    changed: dict[SettingName, ChangedJson]
    unread: list[SettingName]


class SaveJson(ResultJson, frozen=True, kw_only=True):
    """`written`: whether the file could be written; `errors`: why a setting is not in it."""

    file: str
    written: bool
    settings: dict[SettingName, Value]
    errors: dict[str, str]


class DiffJson(ResultJson, frozen=True, kw_only=True):
    """Settings that differ, each with both values; null where one of them has none."""

    differences: dict[SettingName, Annotated[list[Value], Meta(min_length=2, max_length=2)]]


# Acts


class ActJson(ResultJson, frozen=True, kw_only=True):
    """`outcome`: what the module reported afterwards; "not sent" where a condition was not met."""

    act: str
    outcome: Literal["confirmed", "refused", "unknown", "not sent"]
    sentence: str


# Trigger records


class TriggerRecordJson(ResultJson, frozen=True, kw_only=True):
    """`implausible` names the fields that cannot be right; `confirmed`: read twice."""

    boot_count: Byte
    uptime_s: Count
    sources: list[Annotated[str, Meta(pattern="^(serial|attitude|pwm|freefall|bit[0-7])$")]]
    attitude_threshold_deg: float
    freefall_acceleration_g: float
    freefall_time_s: float
    serial_connected: bool
    charging: bool
    light_v: float
    cell_voltage_v: float
    implausible: list[str]
    raw: Hex
    confirmed: bool


class HistoryJson(ResultJson, frozen=True, kw_only=True):
    """`answered`: whether the module answered the query at all; `complete`: whether two readings agreed."""

    records: list[TriggerRecordJson]
    empty_slots: Count
    answered: bool
    complete: bool


# Pre-flight


class CheckJson(ResultJson, frozen=True, kw_only=True):
    id: str
    result: Literal["pass", "fail", "warn", "unknown"]
    measured: Value
    limit: str
    why: str
    do: str


class PreflightJson(ResultJson, frozen=True, kw_only=True):
    verdict: Literal["GO", "READY", "NO-GO"]
    checks: list[CheckJson]
    read: ReadJson
    simulated: bool
    softer_limits: list[str]


class ProvisionedJson(ResultJson, frozen=True, kw_only=True):
    """One name of a batch. `why` is empty where the module has its name."""

    name: str
    state: str
    why: str


class ProvisionJson(ResultJson, frozen=True, kw_only=True):
    modules: list[ProvisionedJson]
    complete: bool


# Recordings


class RecordingJson(ResultJson, frozen=True, kw_only=True):
    name: str
    started_at: Time
    duration_s: float
    port: str
    baud_rate: Count
    modules: list[str]
    samples: Count
    size_bytes: Count
    kept: bool
    running: bool
    cut_off: bool
    triggered: bool
    simulated: bool
    readable: bool


class RecordingsJson(ResultJson, frozen=True, kw_only=True):
    folder: str
    recordings: list[RecordingJson]


class ExportJson(ResultJson, frozen=True, kw_only=True):
    """`complete`: whether the files hold all that was recorded."""

    recordings: list[str]
    files: list[str]
    complete: bool


class VerifyJson(ResultJson, frozen=True, kw_only=True):
    """`report`: the file is a report, in which only the record is signed. `follows`: the verdict that the checks give.
    `signer`: fingerprint of the key; `names`: what stations with it call themselves, `other_keys`: who else calls
    himself so. What an altered file says is null where it cannot be read."""

    state: Literal["intact", "contradictory", "altered"]
    report: bool
    verdict: Literal["GO", "READY", "NO-GO"] | None
    follows: Literal["GO", "READY", "NO-GO"] | None
    void: str | None
    module: str | None
    at: Time | None
    who: str | None
    aircraft: str | None
    simulated: bool | None
    contradictions: list[str]
    signer: str | None
    signed_by: Literal["this_station", "known_station", "unknown_key", "nobody"]
    names: list[str]
    other_keys: dict[str, list[str]]


class DeletedJson(ResultJson, frozen=True, kw_only=True):
    deleted: list[str]


# Flight logs


class FireJson(ResultJson, frozen=True, kw_only=True):
    """`t_s`: seconds since the beginning of the log."""

    t_s: float
    source: Literal["attitude", "freefall"]
    tilt_deg: Annotated[int, Meta(ge=0)] | None


class FiredJson(ResultJson, frozen=True, kw_only=True):
    """`fires` has the first firing of each trigger, and is null where nobody can know whether it fires.

    `not_judged_s` covers the whole length of the log.
    """

    log: str
    fires: list[FireJson] | None
    tilt_max_deg: float | None
    longest_fall_s: float | None
    not_judged_s: float | None
    problems: list[str]
    answer: Literal["fires", "does_not_fire", "not_judged", "unreadable"]


# Captured bytes


class RejectedJson(ResultJson, frozen=True, kw_only=True, tag_field="kind", tag="rejected"):
    """Bytes that are no frame, and why."""

    t_s: float | UnsetType = UNSET
    offset: Count
    hex: Hex
    valid: Literal[False]
    direction: Direction | UnsetType = UNSET
    reason: str


class _FrameHeadJson(ResultJson, frozen=True, kw_only=True):
    t_s: float | UnsetType = UNSET
    offset: Count
    hex: Hex
    valid: Literal[True]
    direction: Direction
    command: CommandName | None


def _meanings() -> list[tuple[str, Any, Any]]:
    """The values that a frame can carry, from the catalogue, each left out where the frame has none."""
    names = [part.name for part in STATUS_PARTS]
    names += RECORD_PART
    for command in COMMANDS:
        names += [key for key in (command.reply_key, command.write_key) if key is not None]
    kinds: dict[str, Any] = dict.fromkeys(names, Value)
    kinds["sources"] = list[str]
    kinds["empty"] = bool
    kinds["acknowledged"] = bool
    kinds["may_answer"] = list[CommandName]
    return [(name, kind | UnsetType, UNSET) for name, kind in kinds.items()]


DecodedFrameJson = msgspec.defstruct(
    "DecodedFrameJson", _meanings(), bases=(_FrameHeadJson,), frozen=True, kw_only=True, tag_field="kind", tag="frame"
)
"""A frame with the values that it carries."""


# The archive


class ArchiveStationJson(ResultJson, frozen=True, kw_only=True):
    """`name`: what the station calls itself, which is no trust."""

    station: str
    name: str


class ArchiveStatusJson(ResultJson, frozen=True, kw_only=True):
    """`own`: facts of this station; `not_shared`: of these the ones that are not known to be on the server."""

    station: str
    facts: Count
    own: Count
    stations: list[ArchiveStationJson]
    server: str | None
    not_shared: Count
    last_sync_at: Time | None
    stations_ahead: list[str]


class LeftOutJson(ResultJson, frozen=True, kw_only=True):
    id: str
    why: str


class SyncJson(ResultJson, frozen=True, kw_only=True):
    """`left_out`: rows of the other side that are no facts, where they are met for the first time that day."""

    place: str
    sent: Count
    received: Count
    left_out: list[LeftOutJson]
    left_out_count: Count


class ArchiveCheckJson(ResultJson, frozen=True, kw_only=True):
    at: Time
    station: str
    verdict: str
    void: bool
    simulated: bool
    who: str
    aircraft: str
    settings_code: str | None


class ArchiveTestJson(ResultJson, frozen=True, kw_only=True):
    test: str
    verdict: str
    at: Time


class ArchiveDueJson(ResultJson, frozen=True, kw_only=True):
    kind: DueKind
    text: str


class ArchiveModuleJson(ResultJson, frozen=True, kw_only=True, tag_field="kind", tag="module"):
    """`two_modules`: contradictions, as if two modules had this name."""

    module: str
    last_at: Time | None
    last_check: ArchiveCheckJson | None
    checks: Count
    trigger_records: Count
    not_judged: Count
    tests: list[ArchiveTestJson]
    due: list[ArchiveDueJson]
    two_modules: list[str]


class ArchiveReportJson(ResultJson, frozen=True, kw_only=True, tag_field="kind", tag="report"):
    at: Time
    modules: list[ArchiveModuleJson]


class ArchiveEventJson(ResultJson, frozen=True, kw_only=True):
    """`content`: of the fact, by its kind."""

    at: Time
    station: str
    kind: str
    id: str
    told: str
    content: dict[str, Any]


class ModuleHistoryJson(ResultJson, frozen=True, kw_only=True, tag_field="kind", tag="history"):
    module: str
    events: list[ArchiveEventJson]


class ServicedJson(ResultJson, frozen=True, kw_only=True):
    module: str
    told: str


# Schemas

TYPES: dict[str, tuple[str, Any]] = {
    "archive_module": ("dps-s archive module --json", ModuleHistoryJson),
    "archive_report": ("dps-s archive report --json", ArchiveReportJson),
    "archive_service": ("dps-s archive service --json", ServicedJson),
    "archive_status": ("dps-s archive status --json", ArchiveStatusJson),
    "archive_sync": ("dps-s archive sync --json", SyncJson),
    "decode": ("dps-s decode --json, one line", DecodedFrameJson | RejectedJson),
    "diff": ("dps-s diff --json", DiffJson),
    "error": ("in the place of a result, with --json", ErrorJson),
    "export": ("dps-s record --json, dps-s recordings export --json", ExportJson),
    "find": ("dps-s find --json", FindJson),
    "fired": ("dps-s fired --json, one line", FiredJson),
    "history": ("dps-s history --json", HistoryJson),
    "act": ("dps-s activate | lock | zero | shutdown --json", ActJson),
    "monitor": ("dps-s monitor --json, one line", MonitorJson),
    "ports": ("dps-s ports --json", PortsJson),
    "preflight": ("dps-s preflight --json, for one port", PreflightJson),
    "provision": ("dps-s provision --json", ProvisionJson),
    "read": ("dps-s read --json", ReadJson),
    "recordings": ("dps-s recordings list --json", RecordingsJson),
    "deleted": ("dps-s recordings delete --json", DeletedJson),
    "save": ("dps-s save --json", SaveJson),
    "set": ("dps-s set --json", SetJson),
    "verify": ("dps-s verify --json", VerifyJson),
}
"""The title of each schema, and what it is made of."""


_RECORD = "record"
"""Made of a structure that is not loaded for every command."""
NAMES = sorted([*TYPES, _RECORD])


def schema_of(name: str) -> dict[str, Any]:
    """The JSON Schema of a result. Raises `KeyError` for a name that there is not."""
    if name == _RECORD:
        from app.records.record import SignedDocument

        return _schema("The signed record of a pre-flight check", SignedDocument)
    return _schema(*TYPES[name])


def _schema(title: str, type_: Any) -> dict[str, Any]:
    schema = msgspec.json.schema(type_)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title, **schema}
