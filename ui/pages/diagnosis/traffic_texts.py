"""Text, icon and colour of a row of the traffic list."""

import time
from functools import cache, lru_cache

from PySide6.QtGui import QColor, QIcon

from app.captures.entries import Way
from app.captures.explain import Asked, sentence
from app.captures.explained import Explained
from app.text import i18n
from app.text.i18n import tr
from protocol.events import (
    Event,
    OutcomeUnknown,
    Received,
    Rejected,
    Restarted,
    Role,
    Sent,
    Unanswered,
    WentOffline,
    WentOnline,
)
from protocol.frame import Direction, Frame, Noise
from protocol.messages import Acknowledgement, Reading
from protocol.translatable import marked
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, current

Row = Event | Explained
"""A live event, or a line of a capture."""
_ROLES = {
    Role.ANSWER: marked("answer"),
    Role.STREAMED: marked("stream"),
    Role.LATE: marked("late"),
    Role.DUPLICATE: marked("doubled"),
    Role.UNSOLICITED: marked("unasked"),
    Role.ECHO: marked("echo"),
}


def kind_of(row: Row) -> str:
    """Kind of row, in one word."""
    match row:
        case Explained(piece=Noise()):
            return tr("invalid")
        case Explained(way=way, piece=Frame(direction=direction)):
            if way is Way.OUT:
                return tr("sent")
            return tr("echo") if direction is Direction.HOST_TO_MODULE else tr("received")
        case Sent():
            return tr("sent") if row.attempt == 1 else f"{tr('sent')} ({row.attempt})"
        case Received():
            return tr(_ROLES[row.role])
        case Rejected():
            return tr("invalid")
        case _:
            return tr("link")


def raw_of(row: Row) -> bytes:
    """The bytes of a row; may be empty."""
    match row:
        case Explained():
            return row.piece.raw
        case Sent():
            return row.raw
        case Received():
            return row.frame.raw
        case Rejected():
            return row.noise.raw
        case _:
            return b""


def at_of(row: Row) -> float:
    """Monotonic seconds, or seconds since the beginning of the capture."""
    return row.at_s if isinstance(row, Explained) else row.at


def meaning_of(row: Row) -> str:
    """Meaning of a row, as a sentence."""
    match row:
        case Explained(piece=Frame() as frame):
            return _sentence(frame.direction, frame.raw, row.asked, i18n.language())
        case Explained(piece=noise):
            return sentence(noise)
        case Sent():
            return _sentence(Direction.HOST_TO_MODULE, row.raw, None, i18n.language())
        case Received():
            return _sentence(row.frame.direction, row.frame.raw, _asked(row), i18n.language())
        case Rejected():
            return sentence(row.noise)
        case _:
            return _link_sentence(row)


def _link_sentence(event: Event) -> str:
    match event:
        case Unanswered() if event.attempts == 0:
            return tr("not sent: heartbeat not answered")
        case Unanswered():
            return tr("no answer within {seconds:.2f} s ({n}×)", seconds=event.waited_s, n=event.attempts)
        case OutcomeUnknown():
            wait_s = event.waited_s
            return tr("not confirmed within {seconds:.2f} s; may have been carried out", seconds=wait_s)
        case Restarted():
            return tr("the module restarted") if event.is_certain else tr("the module probably restarted")
        case WentOnline():
            return tr("the module answers")
        case WentOffline():
            return tr("the module does not answer")
        case _:
            return ""


@lru_cache(maxsize=4096)
def _sentence(direction: Direction, raw: bytes, asked: Asked, language: str) -> str:
    """Cached, since few frames differ and a search needs all rows."""
    with i18n.temporary_language(language):  # a background thread may be here while the language is switched
        return sentence(Frame(direction, raw), asked)


def _asked(received: Received) -> Asked:
    """The request that the frame answers."""
    match received.message:
        case Acknowledgement(request=request):
            return request
        case Reading(command=command) if received.role is not Role.UNSOLICITED and command.can_be_asked:
            return command.query()
        case _:
            return None


def hex_of(raw: bytes, longest: int | None = None) -> str:
    """ "41 75 32"; longer ones are cut after `longest` bytes, with the number of the rest."""
    if longest is None or len(raw) <= longest:
        return raw.hex(" ").upper()
    return f"{raw[:longest].hex(' ').upper()} … +{len(raw) - longest}"


def words_of(row: Row) -> str:
    """Kind, all bytes and meaning, separated by tabs."""
    return "\t".join((kind_of(row), hex_of(raw_of(row)), meaning_of(row)))


def since_start(at_s: float) -> str:
    """Seconds since the beginning of a capture."""
    return f"{at_s:.3f} s"


@lru_cache(maxsize=1024)
def time_of_day(wall_s: int) -> str:
    """Local time, cached, since many rows share a second."""
    return time.strftime("%H:%M:%S", time.localtime(wall_s))


def is_rejected(row: Row) -> bool:
    return isinstance(row, Rejected) or (isinstance(row, Explained) and isinstance(row.piece, Noise))


def is_streamed(row: Row) -> bool:
    """Whether it is an unasked status; in a capture, any status."""
    if isinstance(row, Explained):
        return isinstance(row.piece, Frame) and len(row.piece.raw) == _STATUS_BYTES
    return isinstance(row, Received) and row.role is Role.STREAMED


_STATUS_BYTES = 8


def emphasis_of(row: Row) -> Meaning | None:
    """Colour of rows that need attention."""
    match row:
        case Explained():
            return Meaning.ATTENTION if isinstance(row.piece, Noise) else None
        case Rejected() | OutcomeUnknown() | Unanswered() | WentOffline():
            return Meaning.ATTENTION
        case Received(role=Role.LATE | Role.DUPLICATE | Role.ECHO) | Restarted():
            return Meaning.INFORMATION
        case _:
            return None


_picture = cache(icon)


def icon_of(row: Row) -> QIcon:
    """Direction, or a warning."""
    emphasis = emphasis_of(row)
    match row:
        case Explained(piece=Frame()):
            return _picture(Icon.CHEVRON_RIGHT if row.way is Way.OUT else Icon.CHEVRON_LEFT, None)
        case Explained() | Rejected() | OutcomeUnknown() | Unanswered():
            return _picture(Icon.WARNING, emphasis)
        case Sent():
            return _picture(Icon.CHEVRON_RIGHT, None)
        case Received():
            return _picture(Icon.CHEVRON_LEFT, emphasis)
        case _:
            return _picture(Icon.INFORMATION, emphasis)


def colour_of(row: Row, *, is_time: bool) -> QColor | None:
    """Colour of the text; None: default."""
    emphasis = emphasis_of(row)
    if emphasis is not None:
        return current().ink(emphasis)
    return current().ink(Meaning.UNKNOWN) if is_time or is_streamed(row) else None
