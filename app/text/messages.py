"""A translatable message with its values, which can be kept in a record and read in any language later.

Its text is English with place-holders such as {limit}; their values are texts too, already formatted. They are filled
in without `str.format`, so that a text from a file cannot run a format specification.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Union

from app.text.i18n import CHINESE, language, tr
from app.text.sentences import join_sentences
from app.text.visible_text import visible

MAX_TEXT_LENGTH = 400  # characters of a name or a note that are shown
_PLACE = re.compile(r"\{(\w{1,40})(?::([\w.]{1,6}))?\}")
_LIST = re.compile(r"\{p0\}(?:, \{p\d+\})+")
_SENTENCES = re.compile(r"\{p0\}(?: \{p\d+\})+")
_DEEPEST = 4


class UserMessage(NamedTuple):
    """`values` fill the place-holders of `text`; a `UserMessage` among them is translated, too."""

    text: str
    values: tuple[tuple[str, Union[str, "UserMessage"]], ...] = ()

    def in_english(self) -> str:
        """Return the message in English, for JSON and logs."""
        values = {name: value if isinstance(value, str) else value.in_english() for name, value in self.values}
        return _filled(self.text, values)

    def translated(self) -> str:
        """Return the message in the language in use; see `joined` for lists."""
        values = {name: value if isinstance(value, str) else value.translated() for name, value in self.values}
        if language() == CHINESE and _LIST.fullmatch(self.text):
            return _filled(self.text.replace(", ", "，"), values)
        filled = _filled(tr(self.text), values)
        return join_sentences([filled]) if _SENTENCES.fullmatch(self.text) else filled

    def to_json(self) -> dict[str, Any]:
        """Return it for a record; `message_from_json` reverses it."""
        values = {name: value if isinstance(value, str) else value.to_json() for name, value in self.values}
        return {"text": self.text, "values": values} if values else {"text": self.text}


def message(text: str, /, **values: object) -> UserMessage:
    """Return a message of `text`, which is `marked` if it is translatable. Values are formatted now, as in
    "{seconds:.1f} s old"; those that are messages are translated later."""
    specs = dict(_PLACE.findall(text))
    kept = []
    for name, value in values.items():
        kept.append((name, value if isinstance(value, UserMessage) else format(value, specs.get(name, ""))))
    return UserMessage(text, tuple(kept))


def joined(parts: Sequence[UserMessage], between: str = ", ") -> UserMessage:
    """Join messages to one; its comma, or the space between sentences, is that of the language in which it is read."""
    places = [f"p{number}" for number in range(len(parts))]
    return UserMessage(between.join(f"{{{place}}}" for place in places), tuple(zip(places, parts, strict=True)))


def message_from_json(plain: object, *, depth: int = 0) -> UserMessage:
    """Return the message of `UserMessage.to_json`; of anything else the text in it, if there is one."""
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
    return _PLACE.sub(lambda place: values.get(place[1], place[0]), text)


def clean(text: str, *, longest: int = MAX_TEXT_LENGTH) -> str:
    """Return what somebody typed, or what a file says, on one line, `visible`, and cut at `longest` characters."""
    shown = visible(text[: longest + 1])
    return shown[: longest - 1] + "…" if len(shown) > longest else shown
