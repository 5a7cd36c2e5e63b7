"""Translatable message with its arguments, storable in a record and rendered in any language later.

The text is English with placeholders such as {limit}; their values are texts too, already formatted. Placeholders are
substituted without `str.format`, so that a text from a file cannot run a format specification.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeVar, Union

from app.text.i18n import CHINESE, language, tr
from app.text.sentences import join_sentences
from app.text.visible_text import visible

MAX_TEXT_LENGTH = 400
"""Characters of a name or a note that are shown."""
_PLACE = re.compile(r"\{(\w{1,40})(?::([\w.]{1,6}))?\}")
_LIST = re.compile(r"\{p0\}(?:, \{p\d+\})+")
_SENTENCES = re.compile(r"\{p0\}(?: \{p\d+\})+")
_DEEPEST = 4
Rendered = TypeVar("Rendered")


class UserMessage(NamedTuple):
    """`values` fill the placeholders of `text`; a `UserMessage` among them is translated too."""

    text: str
    values: tuple[tuple[str, Union[str, "UserMessage"]], ...] = ()

    def in_english(self) -> str:
        """The message in English, for JSON."""
        return _filled(self.text, self._rendered(UserMessage.in_english))

    def translated(self) -> str:
        is_list = language() == CHINESE and _LIST.fullmatch(self.text) is not None
        text = self.text.replace(", ", "，") if is_list else tr(self.text)  # see `joined`
        filled = _filled(text, self._rendered(UserMessage.translated))
        return join_sentences([filled]) if _SENTENCES.fullmatch(self.text) else filled

    def to_json(self) -> dict[str, object]:
        """As JSON for a record; `message_from_json` reverses it."""
        values = self._rendered(UserMessage.to_json)
        return {"text": self.text, "values": values} if values else {"text": self.text}

    def _rendered(self, render: "Callable[[UserMessage], Rendered]") -> "dict[str, str | Rendered]":
        return {name: render(value) if isinstance(value, UserMessage) else value for name, value in self.values}


def message(text: str, /, **values: object) -> UserMessage:
    """A message of `text`, which is `marked` if it is translatable. Values are formatted now ("{seconds:.1f} s old");
    those that are messages are translated later."""
    specs = {place[1]: place[2] or "" for place in _PLACE.finditer(text)} if values else {}
    return UserMessage(
        text,
        tuple(
            (name, value if isinstance(value, UserMessage) else format(value, specs.get(name, "")))
            for name, value in values.items()
        ),
    )


def joined(parts: Sequence[UserMessage], between: str = ", ") -> UserMessage:
    """Joins messages into one; the comma, or the space, is that of the language in which it is read."""
    places = [f"p{number}" for number in range(len(parts))]
    return UserMessage(between.join(f"{{{place}}}" for place in places), tuple(zip(places, parts, strict=True)))


def message_from_json(plain: object, *, depth: int = 0) -> UserMessage:
    """The message from `UserMessage.to_json`; from anything else the text in it, if any."""
    if not isinstance(plain, Mapping) or not isinstance(plain.get("text"), str):
        return UserMessage(plain if isinstance(plain, str) else "")
    values = plain.get("values")
    if not isinstance(values, Mapping) or depth > _DEEPEST:
        return UserMessage(plain["text"])
    pairs = (
        (str(name), message_from_json(value, depth=depth + 1) if isinstance(value, Mapping) else str(value))
        for name, value in values.items()
    )
    return UserMessage(plain["text"], tuple(pairs))


def _filled(text: str, values: Mapping[str, str]) -> str:
    return _PLACE.sub(lambda place: values.get(place[1], place[0]), text)


# Text that people typed, or that came out of a file


def clean(text: str, *, longest: int = MAX_TEXT_LENGTH) -> str:
    """`text` on one line, safe to display: control characters, direction marks and unpaired surrogates are shown as
    their code points. Cut at `longest` characters."""
    cut = text[: longest + 1]
    shown = visible(cut)
    return shown[: longest - 1] + "…" if len(shown) > longest else shown
