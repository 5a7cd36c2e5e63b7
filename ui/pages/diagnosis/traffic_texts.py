"""Text, icon and colour of a row of the traffic list."""

from functools import cache
from typing import NamedTuple

from PySide6.QtGui import QColor, QIcon

from app.captures.explain import event_sentence
from app.text.i18n import tr
from protocol.events import Ended, Event, OutcomeUnknown, Received, Rejected, Role, Sent, Unanswered
from protocol.translatable import marked
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, current

_ROLES = {
    Role.ANSWER: marked("reply"),
    Role.STREAMED: marked("stream"),
    Role.LATE: marked("late"),
    Role.DUPLICATE: marked("doubled"),
    Role.UNSOLICITED: marked("unasked"),
    Role.ECHO: marked("echo"),
}


class Shown(NamedTuple):
    """What a row shows besides its meaning: its kind, in one word; its bytes, which may be none; a picture for its
    direction or a warning; and the colour of rows that need attention."""

    kind: str
    raw: bytes
    picture: Icon
    emphasis: Meaning | None = None


def shown(row: Event) -> Shown:
    match row:
        case Rejected(noise=noise):
            return Shown(tr("invalid"), noise.raw, Icon.WARNING, Meaning.ATTENTION)
        case Sent(attempt=attempt, raw=raw):
            return Shown(tr("sent") if attempt == 1 else f"{tr('sent')} ({attempt})", raw, Icon.CHEVRON_RIGHT)
        case Received(role=role, frame=frame):
            is_odd = role in (Role.LATE, Role.DUPLICATE, Role.ECHO)
            return Shown(tr(_ROLES[role]), frame.raw, Icon.CHEVRON_LEFT, Meaning.INFORMATION if is_odd else None)
        case OutcomeUnknown() | Unanswered():
            return Shown(tr("link"), b"", Icon.WARNING, Meaning.ATTENTION)
        case Ended():
            return Shown(tr("link"), b"", Icon.INFORMATION, Meaning.ATTENTION)
        case _:
            return Shown(tr("link"), b"", Icon.INFORMATION)


def hex_of(raw: bytes, longest: int | None = None) -> str:
    """ "41 75 32"; longer ones are cut after `longest` bytes, with the number of the rest."""
    if longest is None or len(raw) <= longest:
        return raw.hex(" ").upper()
    return f"{raw[:longest].hex(' ').upper()} … +{len(raw) - longest}"


def words_of(row: Event) -> str:
    """Kind, all bytes and meaning, separated by tabs."""
    seen = shown(row)
    return "\t".join((seen.kind, hex_of(seen.raw), event_sentence(row)))


def is_rejected(row: Event) -> bool:
    return isinstance(row, Rejected)


def is_streamed(row: Event) -> bool:
    """Whether it is an unasked status."""
    return isinstance(row, Received) and row.role is Role.STREAMED


_picture = cache(icon)


def icon_of(row: Event) -> QIcon:
    seen = shown(row)
    return _picture(seen.picture, seen.emphasis)


def colour_of(row: Event, *, is_time: bool) -> QColor | None:
    emphasis = shown(row).emphasis
    if emphasis is not None:
        return current().ink(emphasis)
    return current().ink(Meaning.UNKNOWN) if is_time or is_streamed(row) else None
