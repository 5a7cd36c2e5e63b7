"""Edited values of settings that were not sent yet, with undo and redo."""

from collections.abc import Iterable, Mapping

from protocol.fields import Value

MAX_STEPS = 200


class Drafts:
    """Edited values by the setting's key; `now` is replaced, never modified."""

    def __init__(self) -> None:
        self.now: Mapping[str, Value] = {}
        self._past: list[Mapping[str, Value]] = []
        self._future: list[Mapping[str, Value]] = []
        self._typing: str | None = None
        """The setting whose field has the focus: all changes in it are one step."""

    @property
    def can_undo(self) -> bool:
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        return bool(self._future)

    def change(self, values: Mapping[str, Value], *, typing: str | None = None) -> None:
        """Adds an undo step; further changes of the setting `typing` belong to its last step."""
        if values == self.now:
            return
        if typing is None or typing != self._typing:
            self._past.append(self.now)
            del self._past[:-MAX_STEPS]
        self._future.clear()
        self.now, self._typing = values, typing

    def undo(self) -> None:
        self._future.append(self.now)
        self.now, self._typing = self._past.pop(), None

    def redo(self) -> None:
        self._past.append(self.now)
        self.now, self._typing = self._future.pop(), None

    def end_typing(self) -> None:
        self._typing = None

    def without(self, key: str) -> dict[str, Value]:
        return {name: value for name, value in self.now.items() if name != key}

    def drop(self, keys: Iterable[str]) -> None:
        """Removes these edits, also from all steps of undo and redo."""
        gone = frozenset(keys)
        if not gone:
            return

        def without(values: Mapping[str, Value]) -> dict[str, Value]:
            return {key: value for key, value in values.items() if key not in gone}

        self.now, self._typing = without(self.now), None
        self._past = _distinct([*map(without, self._past), self.now])[:-1]
        self._future = _distinct([*map(without, self._future), self.now])[:-1]


def _distinct(steps: list[Mapping[str, Value]]) -> list[Mapping[str, Value]]:
    """`steps` without those that change nothing."""
    last = len(steps) - 1
    return [step for number, step in enumerate(steps) if number == last or step != steps[number + 1]]
