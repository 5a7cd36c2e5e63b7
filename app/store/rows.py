"""A fact as a row: its id, how it is made, and what a row from outside must look like.

A fact's id is 12 hexadecimal digits of its time in milliseconds and 28 of the SHA-256 of what the row says. So new
facts stand together, and a row that was changed in place no longer has its own id.
"""

import hashlib
from datetime import UTC, datetime, timedelta
from functools import cache
from typing import Annotated, NamedTuple, TypeVar

import msgspec
from msgspec import Meta

from app.store.kinds import KIND_OF, KINDS, MAX_CONTENT_BYTES, Content
from app.text.messages import clean

EARLIEST = "1970-01-02"
# Every computer can show the times between these two in its own zone.
LATEST = "3000"
# A fact from later than this has a wrong time: it is kept and counts for nothing.
AHEAD = timedelta(days=1)
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
OneContent = TypeVar("OneContent", bound=Content)


class Row(NamedTuple):
    """A fact as it is stored, in the order of the columns. `station`: the public key of who made it, as hex."""

    id: str
    kind: Annotated[str, Meta(pattern=r"^[a-z][a-z_]{0,39}\Z")]
    module: str | None
    station: Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")]
    made_at: str
    content: str


COLUMNS = ", ".join(Row._fields)


class BadRow(ValueError):
    """The row is nothing that a station writes. The text is for people, in English."""


def time_text(at: datetime) -> str:
    """In UTC with microseconds, so that times sort as text."""
    return at.astimezone(UTC).isoformat(timespec="microseconds")


def fact_id(kind: str, module: str | None, station: str, made_at: str, content: str) -> str:
    """Raises `ValueError` for a time or a text that is none."""
    told = "\n".join((kind, module or "", station, made_at, content))
    return _time_in_id(datetime.fromisoformat(made_at)) + hashlib.sha256(told.encode()).hexdigest()[:28]


def last_id_of(at: datetime) -> str:
    """Only the ids of facts that were made later are greater."""
    return _time_in_id(at) + "g"


def _time_in_id(at: datetime) -> str:
    return f"{(at - _EPOCH) // timedelta(milliseconds=1):012x}"


def content_text(content: Content) -> str:
    """The JSON of a content. Raises `ValueError` for one that could not be read again, which is a fault of ours.

    msgspec does not check what is constructed, and writes NaN as null: so what it wrote is read again."""
    kind = KIND_OF[type(content)]
    text = msgspec.json.encode(content, order="deterministic").decode()
    if len(text.encode()) > MAX_CONTENT_BYTES or _decoder(kind).decode(text) != content:
        raise ValueError(f"this {kind} cannot be kept: {text[:200]}")
    return text


def make_row(kind: str, text: str, *, module: str | None, station: str, at: datetime) -> Row:
    """`text`: of `content_text`. Raises `ValueError` for a name that is none."""
    if module is not None and not is_module_name(module):
        raise ValueError(f"no name of a module: {module!r}")
    made_at = time_text(at)
    return Row(fact_id(kind, module, station, made_at, text), kind, module, station, made_at, text)


def check_row(row: tuple[object, ...]) -> Row:
    """A row that somebody else wrote. Raises `BadRow`."""
    try:
        checked = msgspec.convert(row, Row)
        if checked.module is not None and not is_module_name(checked.module):
            raise BadRow("no name of a module")
        if not _is_time(checked.made_at):
            raise BadRow("no time")
        if len(checked.content.encode()) > MAX_CONTENT_BYTES:
            raise BadRow("too large")
        if fact_id(*checked[1:]) != checked.id:
            raise BadRow("altered")
        if checked.kind in KINDS:
            _decoder(checked.kind).decode(checked.content)
        elif not isinstance(msgspec.json.decode(checked.content), dict):
            raise BadRow("no object")  # a kind of a newer version
    except (msgspec.MsgspecError, UnicodeEncodeError, RecursionError) as error:
        raise BadRow(str(error)) from error
    return checked


def content_of(row: Row, type_: type[OneContent]) -> OneContent | None:
    """What a row of our own files says; None for what cannot be read, as of a newer version. This is the one place
    where the decoding of a stored row may fail."""
    try:
        content = _decoder(row.kind).decode(row.content)
    except (KeyError, msgspec.MsgspecError, RecursionError):
        return None
    return content if isinstance(content, type_) else None


@cache
def _decoder(kind: str) -> msgspec.json.Decoder[Content]:
    return msgspec.json.Decoder(KINDS[kind])


def is_module_name(module: str) -> bool:
    return module.strip() != "" and clean(module) == module


def _is_time(text: str) -> bool:
    try:
        return EARLIEST <= text < LATEST and time_text(datetime.fromisoformat(text)) == text
    except (ValueError, OverflowError):
        return False
