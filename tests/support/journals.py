"""An in-memory journal that records the order of events."""

from collections.abc import Callable, Mapping

from app.safety.journal import Act, Entry, Journal, Outcome
from app.text.messages import UserError, UserMessage


class FakeJournal(Journal):
    """Calls `on_begin` while an intent is written. Writing fails if `is_broken`, and waits for `flush` if `is_held`."""

    def __init__(self) -> None:
        self.intents: list[tuple[Act, bytes, Mapping[str, object]]] = []
        self.outcomes: dict[int, Outcome] = {}
        self.results: dict[int, Mapping[str, object]] = {}
        self.is_ready = True
        self.is_broken = False
        self.is_held = False
        self._entries: list[Entry] = []
        self.on_begin: Callable[[], object] = lambda: None

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], /) -> Entry:
        entry = Entry()
        if self.is_broken:
            entry.set_exception(UserError(UserMessage("The disk is full.")))
            return entry
        self.intents.append((act, frame, detail))
        self.on_begin()
        self._entries.append(entry)
        if not self.is_held:
            self.flush()
        return entry

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object], /) -> None:
        if entry in self._entries:
            number = self._entries.index(entry)
            self.outcomes[number], self.results[number] = outcome, result

    def flush(self) -> None:
        """Complete the writes that were held."""
        for number, entry in enumerate(self._entries):
            if not entry.done():
                entry.set_result(str(number))
