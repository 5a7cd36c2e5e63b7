"""The kinds of facts, and a fact as a row: its id, how it is made, and what a row from outside must look like.

A structure is the whole rule for one kind: msgspec checks types, bounds and lengths on reading. Fields that this
version does not know are ignored, so that a newer version may add some, each with a default, as older facts lack it.
A kind that this version does not know is kept and passed on, but nothing here reads it.
"""

from datetime import UTC, date, datetime, timedelta
from enum import Enum
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

import msgspec
from msgspec import Meta, Struct

from app.safety.journal import Outcome
from app.text.messages import clean
from protocol.translatable import marked

# A record with all the frames that a check keeps has 150,000.
MAX_CONTENT_BYTES = 1_000_000
# A fact from later than this has a wrong time: it is kept and counts for nothing.
AHEAD = timedelta(days=1)
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)

# What `clean` makes of what people type: on one line, at most 400 characters.
Text = Annotated[str, Meta(max_length=400)]
Note = Annotated[str, Meta(max_length=2000)]
# A word of the program, such as an act or a setting.
Word = Annotated[str, Meta(max_length=60)]
Hex = Annotated[str, Meta(max_length=200, pattern=r"^([0-9A-Fa-f]{2} ?)*$")]
Key = Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
Byte = Annotated[int, Meta(ge=0, le=255)]
Count = Annotated[int, Meta(ge=0, le=2**53)]
Whole = Annotated[int, Meta(ge=-(2**53), le=2**53)]
Settings = dict[Word, bool | Whole | float]
Detail = dict[Word, bool | Whole | float | Text | list[Text] | None]


class Content(Struct, frozen=True, kw_only=True):
    """The base of every kind of fact."""


OneContent = TypeVar("OneContent", bound=Content)


class StationNamed(Content, frozen=True, kw_only=True):
    """A station introduces itself: the key that signs its records, and its name."""

    public_key: Key
    name: Text


class ModuleNamed(Content, frozen=True, kw_only=True):
    """A person gave a module its name."""


class SaidNew(Content, frozen=True, kw_only=True):
    """A person's word that a module is new and has no records, or no longer."""

    is_new: bool


class ModuleVisited(Content, frozen=True, kw_only=True):
    """One reading of a module: what it is recognised by and the records in its slots."""

    port: Text
    boot_count: Byte | None
    slots: Annotated[list[Hex], Meta(max_length=9)]
    is_confirmed: bool


class TriggerRecordSeen(Content, frozen=True, kw_only=True):
    # From 0, the oldest record that was ever seen of the module.
    place: Count
    raw: Hex


class Judgement(Enum):
    """The value is translatable."""

    BENCH_TEST = marked("bench test")
    REAL = marked("real")
    FALSE = marked("false trigger")
    # Looked at, and known; also the word with which a person passes a pre-flight check.
    REVIEWED = marked("reviewed")


class TriggerRecordJudged(Content, frozen=True, kw_only=True):
    """A person's judgement of a trigger record; null takes it back."""

    place: Count
    raw: Hex
    judgement: Judgement | None
    note: Note = ""


class SettingsSeen(Content, frozen=True, kw_only=True):
    """The settings as they were found before the first write of a conversation; what was written is an act."""

    port: Text
    boot_count: Byte | None
    settings: Settings


class PreflightCheck(Content, frozen=True, kw_only=True):
    """The signed document is carried as text, exactly as it was signed. What stands beside it is for lists."""

    verdict: Literal["GO", "READY", "NO-GO"]
    is_void: bool
    is_simulated: bool
    who: Text = ""
    aircraft: Text = ""
    # Of the settings.
    code: Word | None = None
    cell_voltage_v: float | None = None
    document: Annotated[str, Meta(max_length=MAX_CONTENT_BYTES)]


class MayHaveFired(Content, frozen=True, kw_only=True):
    """A TRIGGERED was seen, or a deploy left before the module had this name: no earlier verdict holds."""

    port: Text
    adapter: Text = ""


class GuidedTestDone(Content, frozen=True, kw_only=True):
    test: Word
    verdict: Word
    who: Text = ""
    is_simulated: bool = False
    # Of each value its name, what was measured and the tolerance, as messages, and the verdict on it.
    measured: list[dict[Word, Any]] = []


class ActIntended(Content, frozen=True, kw_only=True):
    """The intent of an act; it is on the disk before anything is sent."""

    act: Word
    port: Text
    frame: Hex
    origin: Word = ""
    adapter: Text = ""
    # Names the conversation.
    run: Word = ""
    detail: Detail = {}
    # Who wrote the settings, and why, where that was said.
    note: Note = ""


class DeployIntended(ActIntended, frozen=True, kw_only=True):
    """A kind of its own, as every report looks for it."""


class ActEnded(Content, frozen=True, kw_only=True):
    """The end of the intent `of`; an intent without an end reads as unknown."""

    of: Annotated[str, Meta(pattern=r"^[0-9a-f]{40}$")]
    outcome: Outcome
    result: Detail = {}


class ServiceKind(Enum):
    """The value is the word on the command line, too."""

    REPACK = "repack"
    EJECTOR = "ejector"
    CELL = "cell"
    FIRMWARE = "firmware"


class Serviced(Content, frozen=True, kw_only=True):
    """A service that a person did to a module, and when it is due again."""

    service: ServiceKind
    on: date
    due: date | None
    who: Text
    note: Note = ""


class ModuleProvisioned(Content, frozen=True, kw_only=True):
    """The turn of one module in a batch: it got this name, or it was set aside, and `why`."""

    batch: Text
    name: Text
    # As `UserMessage.to_json` has it.
    why: dict[Word, Any] | None
    code: Word


KINDS: dict[str, type[Content]] = {
    "station": StationNamed,
    "module": ModuleNamed,
    "said_new": SaidNew,
    "visit": ModuleVisited,
    "trigger_record": TriggerRecordSeen,
    "judgement": TriggerRecordJudged,
    "settings_seen": SettingsSeen,
    "preflight_check": PreflightCheck,
    "fired": MayHaveFired,
    "guided_test": GuidedTestDone,
    "act": ActIntended,
    "deploy": DeployIntended,
    "outcome": ActEnded,
    "service": Serviced,
    "provisioned": ModuleProvisioned,
}
KIND_OF: dict[type[Content], str] = {type_: kind for kind, type_ in KINDS.items()}


class Row(NamedTuple):
    """A fact as it is stored, in the order of the columns. `station`: the public key of who made it, as hex."""

    id: str
    kind: Annotated[str, Meta(pattern=r"^[a-z][a-z_]{0,39}\Z")]
    module: str | None
    station: Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")]
    # Every computer can show these years in its own zone.
    made_at: Annotated[str, Meta(pattern=r"^(197[1-9]|19[89]\d|2\d{3})-")]
    content: str


COLUMNS = ", ".join(Row._fields)


class BadRow(ValueError):
    """The row is nothing that a station writes. The text is for people, in English."""


def time_text(at: datetime) -> str:
    """Return the time in UTC with microseconds, so that times sort as text."""
    return at.astimezone(UTC).isoformat(timespec="microseconds")


def time_in_id(at: datetime) -> str:
    """The first digits of an id, so that new facts stand together and sort by their time."""
    return f"{(at - _EPOCH) // timedelta(milliseconds=1):012x}"


def fact_id(kind: str, module: str | None, station: str, made_at: str, content: str) -> str:
    """Return the id, made from what the row says, so that one that was changed in place no longer has its own. Raises
    `ValueError` for a time or a text that is none."""
    import hashlib  # the window's first paint does not wait for it

    told = "\n".join((kind, module or "", station, made_at, content))
    return time_in_id(datetime.fromisoformat(made_at)) + hashlib.sha256(told.encode()).hexdigest()[:28]


def content_text(content: Content) -> str:
    """The JSON of a content. Raises `ValueError` for one that could not be read again, which is a fault of ours."""
    text = msgspec.json.encode(content, order="deterministic").decode()
    # msgspec does not check what is constructed, and writes NaN as null: so what it wrote is read again.
    if len(text.encode()) > MAX_CONTENT_BYTES or msgspec.json.decode(text, type=type(content)) != content:
        raise ValueError(f"this {KIND_OF[type(content)]} cannot be kept: {text[:200]}")
    return text


def row_of(content: Content, *, module: str | None, station: str, at: datetime) -> Row:
    """Return a fact as it is stored. Raises `ValueError` as `content_text` and `make_row`."""
    return make_row(KIND_OF[type(content)], content_text(content), module=module, station=station, at=at)


def make_row(kind: str, text: str, *, module: str | None, station: str, at: datetime) -> Row:
    """`text`: of `content_text`. Raises `ValueError` for a name that is none."""
    if module is not None and (not module.strip() or clean(module) != module):
        raise ValueError(f"no name of a module: {module!r}")
    made_at = time_text(at)
    return Row(fact_id(kind, module, station, made_at, text), kind, module, station, made_at, text)


def check_row(row: tuple[object, ...]) -> tuple[Row, object]:
    """Return a row that somebody else wrote, and that is not too large, with its content. Raises `BadRow`."""
    try:
        checked = msgspec.convert(row, Row)
        _id, kind, module, station, made_at, text = checked
        if make_row(kind, text, module=module, station=station, at=datetime.fromisoformat(made_at)) != checked:
            raise BadRow("altered")
        # Of a kind of a newer version no more is known than that it is an object.
        content = msgspec.json.decode(text, type=KINDS.get(kind, dict))
    except (ValueError, OverflowError, RecursionError) as error:  # msgspec's own and those of times and encodings
        raise BadRow(str(error)) from error
    return checked, content
