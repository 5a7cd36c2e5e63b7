"""An in-memory journal that records the order of events."""

from collections.abc import Mapping

from app.safety.journal import Act, Entry, Outcome
from app.text.messages import UserError, UserMessage


class FakeJournal:
    """Calls `on_begin` while an intent is written. Writing fails if `is_broken`, and waits for `flush` if `is_held`."""

    def __init__(self) -> None:
        self.intents: list[tuple[Act, bytes, Mapping[str, object]]] = []
        self.outcomes: dict[int, Outcome] = {}
        self.results: dict[int, Mapping[str, object]] = {}
        self.is_ready = True
        self.is_broken = False
        self.is_held = False
        self._numbers: dict[Entry, int] = {}
        self.sent_before: list[int] = []
        self.line_length = lambda: 0
        self.on_begin = lambda: None

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], /) -> Entry:
        if self.is_broken:
            return _failed()
        self.intents.append((act, frame, detail))
        self.sent_before.append(self.line_length())
        self.on_begin()
        return self._entry(len(self.intents) - 1)

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object], /) -> None:
        if entry in self._numbers:
            self.outcomes[self._numbers[entry]] = outcome
            self.results[self._numbers[entry]] = result

    def flush(self) -> None:
        """Complete the writes that were held."""
        for entry, number in self._numbers.items():
            if not entry.done():
                entry.set_result(str(number))

    def _entry(self, number: int) -> Entry:
        entry = Entry()
        self._numbers[entry] = number
        if not self.is_held:
            entry.set_result(str(number))
        return entry


def _failed() -> Entry:
    entry = Entry()
    entry.set_exception(UserError(UserMessage("The disk is full.")))
    return entry
