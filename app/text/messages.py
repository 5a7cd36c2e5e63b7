"""Texts for people: messages with values, sentences, durations, the error that is read, text made safe to show."""

import re
from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from typing import Any, Final, NamedTuple, Union

from app.text.i18n import CHINESE, language, tr

# Patterns are compiled by `re` where they are used first, as few commands need all of them.
_WIDE_STOP_AND_SPACE: Final = "([。！？；：]) "
_BEFORE_UNIT: Final = r"(?<=\d) (?=(?:g|V|s|m|km/h)\b)"


def capitalised(text: str) -> str:
    return text[:1].upper() + text[1:]


def join_sentences(sentences: Iterable[str]) -> str:
    # No space follows full-width Chinese punctuation.
    return re.sub(_WIDE_STOP_AND_SPACE, r"\1", " ".join(sentence for sentence in sentences if sentence))


def join_names(names: Iterable[str]) -> str:
    return ("、" if language() == CHINESE else ", ").join(names)


def labelled(label: object, text: object) -> str:
    return f"{label}：{text}" if language() == CHINESE else f"{label}: {text}"


def in_brackets(text: str) -> str:
    # To be appended to a word.
    return f"（{text}）" if language() == CHINESE else f" ({text})"


def with_units(text: str) -> str:
    """`text`, whose numbers keep their units on their line."""
    return re.sub(_BEFORE_UNIT, "\u00a0", text)


def not_written(file: object, error: Exception) -> str:
    # `error`: a `UserError`, whose own sentence says it, OSError, or ValueError for an invalid name.
    why = tr("{file} cannot be written: {why}.", file=file, why=error_text(error))
    return getattr(error, "sentence", why)


def saved_text(path: object, rows: int, *, is_whole: bool = True) -> str:
    """`is_whole`: no older rows were gone by then."""
    if is_whole:
        return tr("Saved to {path}. Rows: {rows}.", rows=f"{rows:,}", path=path)
    return tr("Saved to {path}. Rows: {rows}; older ones are gone.", rows=f"{rows:,}", path=path)


def error_text(error: Exception) -> str:
    """The system's message without error number and path, the sentence of a `UserError`, else the text of the error."""
    return getattr(error, "strerror", None) or getattr(error, "sentence", None) or str(error)


def stopwatch(seconds: float) -> str:
    """Whole minutes and seconds, with hours if any: "1:48", "18:12:15"."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def duration(seconds: float) -> str:
    """ "0.4 s", "12 s", "3 min", "2 h"."""
    if seconds < 1.95:  # else "2.0 s" beside "2 s"
        return tr("{value} s", value=f"{max(0.0, seconds):.1f}")
    if seconds < 120:
        return tr("{value} s", value=f"{seconds:.0f}")
    if seconds < 7200:
        return tr("{value:.0f} min", value=seconds / 60)
    return tr("{value:.0f} h", value=seconds / 3600)


# Control characters, line breaks, direction marks and unpaired surrogates.
_HIDDEN: Final = "[\0-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]"


def visible(text: str, *, keep: str = "") -> str:
    """`text` with spaces for line breaks and tabs, and with code points for other characters that are not seen; those
    in `keep` stay. Terminals execute escape characters, and direction marks reorder text."""

    def shown(match: re.Match[str]) -> str:
        character = match[0]
        if character in keep:
            return character
        return " " if character.isspace() else f"[U+{ord(character):04X}]"

    return re.sub(_HIDDEN, shown, text)


def visible_json(text: str) -> str:
    """JSON with such characters escaped."""
    return re.sub(_HIDDEN, lambda match: f"\\u{ord(match[0]):04x}", text)


MAX_TEXT_LENGTH = 400  # characters of a name or a note that are shown
_PLACE = r"\{(\w{1,40})(?::([\w.]{1,6}))?\}"
_DEEPEST = 4


class UserMessage(NamedTuple):
    """A translatable message, which can be kept in a record and read in any language later.

    `values` fill the place-holders of `text`, such as {limit}: texts that are already formatted, or messages, which are
    translated, too. They are filled in without `str.format`, so that a text from a file runs no format specification.
    """

    text: str
    values: tuple[tuple[str, Union[str, "UserMessage"]], ...] = ()

    def in_english(self) -> str:
        """Return it in English, for JSON and logs."""
        values = {name: value if isinstance(value, str) else value.in_english() for name, value in self.values}
        return _filled(self.text, values)

    def translated(self) -> str:
        """Return it in the language in use; see `joined` for lists."""
        values = {name: value if isinstance(value, str) else value.translated() for name, value in self.values}
        text = tr(self.text)
        if text.startswith("{p0}, ") and language() == CHINESE:
            text = text.replace(", ", "，")
        return join_sentences([_filled(text, values)])

    def to_json(self) -> dict[str, Any]:
        """Return it for a record; `message_from_json` reverses it."""
        values = {name: value if isinstance(value, str) else value.to_json() for name, value in self.values}
        return {"text": self.text, "values": values} if values else {"text": self.text}


def message(text: str, /, **values: object) -> UserMessage:
    """`text` is `marked` if it is translatable. Values are formatted now, as in "{seconds:.1f} s old"; those that are
    messages are translated later."""
    specs = dict(re.findall(_PLACE, text))

    def kept(name: str, value: object) -> str | UserMessage:
        return value if isinstance(value, UserMessage) else format(value, specs.get(name, ""))

    return UserMessage(text, tuple((name, kept(name, value)) for name, value in values.items()))


def joined(parts: Sequence[UserMessage], between: str = ", ") -> UserMessage:
    """Join messages. The comma between them, or the space between sentences, is that of the language in which it is
    read."""
    places = [f"p{number}" for number in range(len(parts))]
    return UserMessage(between.join(f"{{{place}}}" for place in places), tuple(zip(places, parts, strict=True)))


def message_from_json(plain: object, *, depth: int = 0) -> UserMessage:
    """The message of `UserMessage.to_json`; of anything else the text in it, if there is one."""
    if not isinstance(plain, Mapping) or not isinstance(plain.get("text"), str):
        return UserMessage(plain if isinstance(plain, str) else "")
    values = plain.get("values")
    if not isinstance(values, Mapping) or depth > _DEEPEST:
        return UserMessage(plain["text"])
    kept = []
    for name, value in values.items():
        is_message = isinstance(value, Mapping)
        kept.append((str(name), message_from_json(value, depth=depth + 1) if is_message else str(value)))
    return UserMessage(plain["text"], tuple(kept))


def _filled(text: str, values: Mapping[str, str]) -> str:
    return re.sub(_PLACE, lambda place: values.get(place[1], place[0]), text)


def clean(text: str, *, longest: int = MAX_TEXT_LENGTH) -> str:
    """Return what somebody typed, or what a file says, on one line, `visible`, and cut at `longest` characters."""
    shown = visible(text[: longest + 1])
    return shown[: longest - 1] + "…" if len(shown) > longest else shown


class ErrorCode(StrEnum):
    """Why a command has no result: the closed list of the command line's contract."""

    USAGE = "usage"
    NO_PORT = "no_port"
    BUSY = "busy"
    NO_PERMISSION = "no_permission"
    NO_LINK = "no_link"
    INTERRUPTED = "interrupted"
    REFUSED = "refused"
    # These two are of the contract, for other programs. Here such a command has a result, which says it.
    NOT_CONFIRMED = "not_confirmed"
    NOT_VERIFIED = "not_verified"
    UNREADABLE = "unreadable"
    NOT_JUDGED = "not_judged"
    STORE = "store"
    CANCELLED = "cancelled"
    INTERNAL = "internal"

    @property
    def exit_code(self) -> int:
        match self:
            case self.USAGE | self.UNREADABLE | self.NOT_JUDGED:
                return 2
            case self.NO_PORT | self.BUSY | self.NO_PERMISSION | self.NO_LINK | self.INTERRUPTED:
                return 3
            case self.CANCELLED:
                return 130
        return 1


class UserError(Exception):
    """Something cannot be had or done. Its text says what, why and, where a person can help it, what to do.

    `text` is `marked` if it is translatable; `values` fill its place-holders. As text the error is English, for logs.
    """

    # Why a command that it ends has no result.
    code = ErrorCode.USAGE
    # What happened, and what to do next, where the two are known apart.
    what = hint = ""

    def __init__(self, text: str | UserMessage, /, **values: object) -> None:
        self.message = text if isinstance(text, UserMessage) else message(text, **values)
        super().__init__(self.message)  # the only argument, so that it can be pickled

    def __str__(self) -> str:
        return self.message.in_english()

    @property
    def sentence(self) -> str:
        """The text in the language in use now."""
        return self.message.translated()
