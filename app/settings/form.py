"""Form model of a module's settings in one conversation: module value, edited value and row state.

    unknown       never reported by the module, or lost for good
    read          read from the module, or reported unasked
    acknowledged  set and acknowledged; it cannot be read back (E8)
    stale         known earlier, but something casts doubt on it
    edited        another value was entered and not sent yet
    not possible  what was typed cannot be sent; nothing is written while it stands
    writing
    verified      written and read back equal; a value that reads otherwise later ends the conversation
    failed        the write failed; with the reason, until the module has the value

The baud rate is not a row of the form: changing it may cut the link, so it has a procedure and a panel of its own.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from app.engine.conversation import ConversationView, How, Known
from app.procedures.write import SettingChange, WriteFault, Written
from app.safety.consequences import Consequence, consequences
from app.settings.setting_texts import value_text
from app.text.i18n import tr
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT, SETTINGS, Command
from protocol.fields import Value
from protocol.translatable import marked

FORM_COMMANDS: tuple[Command, ...] = (
    *(command for command in SETTINGS if command.reads_back),
    *(command for command in SETTINGS if not command.reads_back and command not in (BAUD_RATE, SERIAL_OUTPUT)),
    SERIAL_OUTPUT,
)
"""In the order of the rows, thresholds first."""
_BY_KEY = {command.key: command for command in FORM_COMMANDS}


class RowState(Enum):
    """The value is its English, translatable word."""

    UNKNOWN = marked("unknown")
    READ = marked("read")
    ACKNOWLEDGED = marked("acknowledged")
    STALE = marked("stale")
    EDITED = marked("edited")
    IMPOSSIBLE = marked("not possible")
    WRITING = marked("writing")
    VERIFIED = marked("verified")
    FAILED = marked("failed")


@dataclass(frozen=True, slots=True, kw_only=True)
class FormRow:
    command: Command
    module_value: Known | None
    edited: Value | None
    state: RowState
    reason: str = ""
    """Why it failed, in the language in use."""
    is_pending: bool = False
    """The next write will send it."""
    mistyped: str = ""
    """What was typed and cannot be sent."""

    @property
    def consequences(self) -> tuple[Consequence, ...]:
        """Of the edited value, else of the module's."""
        value = self.edited
        if value is None and self.module_value is not None and not self.module_value.is_stale:
            value = self.module_value.value
        return () if value is None else consequences(self.command, value)


class _Failure(NamedTuple):
    target: Value
    fault: WriteFault
    read_back: Value | None = None


class SettingsForm:
    """See the module docstring. Belongs to one thread."""

    def __init__(self) -> None:
        # By the setting's key; replaced, never modified.
        self._edited: Mapping[str, Value] = {}
        # What was typed and cannot be sent.
        self._mistyped: dict[str, str] = {}
        self._writing: dict[str, Value] = {}
        self._verified: dict[str, Value] = {}
        self._failures: dict[str, _Failure] = {}

    # Editing

    def choose(self, key: str, value: Value) -> None:
        self._forget_mistyped([key])
        self._change({**self._edited, key: value})

    def mistype(self, key: str, text: str) -> None:
        """What was typed is no value: it takes the place of the edit, so that half of it is never sent."""
        if self._writing:
            return
        self.revert(key)
        self._mistyped[key] = text

    def fill(self, values: Mapping[str, Value]) -> None:
        """Edits all of these; keys that are not rows of the form are ignored."""
        known = {key: value for key, value in values.items() if key in _BY_KEY}
        self._forget_mistyped(known)
        self._change({**self._edited, **known})

    def revert(self, key: str | None = None) -> None:
        """Removes the edit of one row, or all edits."""
        self._forget_mistyped(list(self._mistyped) if key is None else [key])
        self._change({} if key is None else {name: value for name, value in self._edited.items() if name != key})

    def _forget_mistyped(self, keys: Iterable[str]) -> None:
        if not self._writing:
            for key in keys:
                self._mistyped.pop(key, None)

    def _change(self, values: Mapping[str, Value]) -> None:
        """Replaces the edits, and removes failures of settings that are no longer edited."""
        if self._writing or values == self._edited:
            return
        self._edited = values
        self._failures = {key: failure for key, failure in self._failures.items() if key in values}

    def _drop(self, keys: Iterable[str]) -> None:
        """Removes these edits, of values that the module has now."""
        gone = frozenset(keys)
        self._edited = {key: value for key, value in self._edited.items() if key not in gone}

    # Rows

    def rows(self, conversation: ConversationView, now: float) -> tuple[FormRow, ...]:
        self.observe(conversation, now)
        return tuple(self._row(command, conversation, now) for command in FORM_COMMANDS)

    @property
    def is_writing(self) -> bool:
        return bool(self._writing)

    @property
    def edited(self) -> dict[str, Value]:
        """The edited values by key, those that the module already has included."""
        return dict(self._edited)

    @property
    def mistyped(self) -> dict[str, str]:
        """What was typed and cannot be sent, by the setting's key."""
        return dict(self._mistyped)

    @property
    def has_drafts(self) -> bool:
        return bool(self._edited or self._mistyped)

    def changes(self, conversation: ConversationView, now: float) -> tuple[SettingChange, ...]:
        """What a write would send: edits that are not known to be on the module."""
        rows = self.rows(conversation, now)
        return tuple(
            SettingChange(row.command, row.edited) for row in rows if row.is_pending and row.edited is not None
        )

    def count_unsent(self, conversation: ConversationView, now: float) -> int:
        """Edits that leaving would lose, those being written included."""
        rows = self.rows(conversation, now)
        return sum(row.is_pending or row.state is RowState.WRITING or bool(row.mistyped) for row in rows)

    def observe(self, conversation: ConversationView, now: float) -> None:
        """Note what the module reports: what was written after all, but late, is no failure and no edit any more."""
        for key, value in list(self._verified.items()):
            if conversation.fresh(key, now) != value:  # set again, by another part of the program
                del self._verified[key]
        if self._writing:
            return
        settled = []
        for key, failure in self._failures.items():
            if is_confirmed(_BY_KEY[key], conversation.known(key, now), failure.target):
                settled.append(key)
        self._drop(key for key in settled if self._edited.get(key) == self._failures[key].target)
        for key in settled:
            del self._failures[key]

    def _row(self, command: Command, conversation: ConversationView, now: float) -> FormRow:
        key = command.key
        module_value, edited = conversation.known(key, now), self._edited.get(key)
        failure = self._failures.get(key)
        is_pending = edited is not None and key not in self._writing
        if edited is not None and is_confirmed(command, module_value, edited):
            is_pending = False
        if key in self._writing:
            state = RowState.WRITING
        elif key in self._mistyped:
            state = RowState.IMPOSSIBLE
        elif failure is not None:
            state = RowState.FAILED
        elif is_pending:
            state = RowState.EDITED
        elif key in self._verified:
            state = RowState.VERIFIED
        else:
            state = _known_state(module_value)
        return FormRow(
            command=command,
            module_value=module_value,
            edited=edited,
            state=state,
            reason=_failure_text(command, failure) if state is RowState.FAILED and failure is not None else "",
            is_pending=is_pending,
            mistyped=self._mistyped.get(key, ""),
        )

    # Writing

    def begin_write(self, changes: Iterable[SettingChange]) -> None:
        """Blocks editing until `on_written`."""
        self._writing = {change.command.key: change.value for change in changes}
        for key in self._writing:
            self._failures.pop(key, None)
            self._verified.pop(key, None)

    def on_written(self, results: Iterable[Written], conversation: ConversationView, now: float) -> None:
        """Takes the outcome of each change. What was not sent stays edited; of the rest, what the module has already is
        no edit any more."""
        self._writing = {}
        settled = []
        for written in results:
            key = written.command.key
            if not written.is_sent or key not in _BY_KEY:
                continue
            if written.fault is not None:
                self._failures[key] = _Failure(written.target, written.fault, written.read_back)
                continue
            settled.append(key)
            if written.verified:
                self._verified[key] = written.target
        for key, value in self._edited.items():
            if is_confirmed(_BY_KEY[key], conversation.known(key, now), value):
                settled.append(key)
        self._drop(settled)


def is_confirmed(command: Command, known: Known | None, value: Value) -> bool:
    """Whether the module has reported `value`. An acknowledgement proves nothing where it can be read back (E2)."""
    if known is None or known.is_stale or known.value != value:
        return False
    return known.how is not How.ACKNOWLEDGED or not command.reads_back


def _known_state(known: Known | None) -> RowState:
    if known is None:
        return RowState.UNKNOWN
    if known.is_stale:
        return RowState.STALE
    return RowState.ACKNOWLEDGED if known.how is How.ACKNOWLEDGED else RowState.READ


def _failure_text(command: Command, failure: _Failure) -> str:
    target, why = value_text(command, failure.target), tr(failure.fault.value)
    if failure.read_back is None:
        return tr("{wanted} was sent: {why}.", wanted=target, why=why)
    read_back = value_text(command, failure.read_back)
    return tr("{wanted} was sent: {why}. It holds {stands}.", wanted=target, why=why, stands=read_back)
