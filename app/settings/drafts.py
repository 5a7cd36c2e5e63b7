"""Edited values of settings that were not sent yet, with undo and redo."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from app.settings.setting_texts import plain_text
from app.settings.values import field_of, parse_value
from app.text.messages import UserMessage
from app.text.user_error import UserError
from protocol.catalogue import Command
from protocol.fields import Quantity, Value

MAX_STEPS = 200
_HALF_WIDTH = {0xFF01 + one: 0x21 + one for one in range(94)} | {ord("。"): "."}


@dataclass(frozen=True, slots=True)
class Draft:
    """The edited value of one setting: the text as typed, and its value unless that is `invalid`."""

    text: str
    value: Value | None
    invalid: UserMessage | None = None


def draft_of(command: Command, text: str) -> Draft:
    """The draft of a typed text. A comma counts as a decimal point; full-width characters and the unit are allowed."""
    field, plain = field_of(command), text.translate(_HALF_WIDTH)
    if isinstance(field, Quantity):
        plain = plain.removesuffix(field.unit).rstrip()
    try:
        return Draft(text, parse_value(field, plain if "." in plain else plain.replace(",", ".")))
    except UserError as error:
        return Draft(text, None, error.message)


def draft_for(command: Command, value: Value) -> Draft:
    return Draft(plain_text(command, value), value)


class Drafts:
    """Drafts by the setting's key; `now` is replaced, never modified."""

    def __init__(self) -> None:
        self.now: Mapping[str, Draft] = {}
        self._past: list[Mapping[str, Draft]] = []
        self._future: list[Mapping[str, Draft]] = []
        self._typing: str | None = None
        """The setting that is being typed into: all its keystrokes are one step."""

    @property
    def can_undo(self) -> bool:
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        return bool(self._future)

    def change(self, drafts: Mapping[str, Draft], *, typing: str | None = None) -> None:
        """Adds an undo step; further keystrokes in the setting `typing` belong to its last step."""
        if drafts == self.now:
            return
        if typing is None or typing != self._typing:
            self._past.append(self.now)
            del self._past[:-MAX_STEPS]
        self._future.clear()
        self.now, self._typing = drafts, typing

    def undo(self) -> None:
        self._future.append(self.now)
        self.now, self._typing = self._past.pop(), None

    def redo(self) -> None:
        self._past.append(self.now)
        self.now, self._typing = self._future.pop(), None

    def end_typing(self) -> None:
        self._typing = None

    def without(self, key: str) -> dict[str, Draft]:
        return {name: draft for name, draft in self.now.items() if name != key}

    def drop(self, keys: Iterable[str]) -> None:
        """Removes these drafts, also from all steps of undo and redo."""
        gone = frozenset(keys)
        if not gone:
            return

        def without(drafts: Mapping[str, Draft]) -> dict[str, Draft]:
            return {key: draft for key, draft in drafts.items() if key not in gone}

        self.now, self._typing = without(self.now), None
        self._past = _distinct([*map(without, self._past), self.now])[:-1]
        self._future = _distinct([*map(without, self._future), self.now])[:-1]


def _distinct(steps: list[Mapping[str, Draft]]) -> list[Mapping[str, Draft]]:
    """`steps` without those that change nothing."""
    last = len(steps) - 1
    return [step for number, step in enumerate(steps) if number == last or step != steps[number + 1]]
