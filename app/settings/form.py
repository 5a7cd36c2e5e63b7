"""The form of a module's settings: what it says, what a person wants, and what came of writing it. Of one conversation.

The baud rate is no row of the form: changing it may cut the link, so it has a procedure and a panel of its own.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from app.engine.conversation import ConversationView, How, Known
from app.procedures.write import SettingChange, Written
from app.safety.consequences import Consequence, consequences
from app.settings.profiles import Profile
from app.settings.values import value_text
from app.text.i18n import tr
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT, SETTINGS, Command
from protocol.fields import Value
from protocol.translatable import marked

# In the order of the rows, thresholds first.
FORM_COMMANDS: tuple[Command, ...] = (
    *(command for command in SETTINGS if command.reads_back),
    *(command for command in SETTINGS if not command.reads_back and command not in (BAUD_RATE, SERIAL_OUTPUT)),
    SERIAL_OUTPUT,
)
_BY_KEY = {command.key: command for command in FORM_COMMANDS}


class RowState(Enum):
    """The value is its English, translatable word."""

    UNKNOWN = marked("unknown")  # never reported by the module
    READ = marked("read")  # or reported unasked
    ACKNOWLEDGED = marked("acknowledged")  # it cannot be read back (E8)
    STALE = marked("stale")
    EDITED = marked("edited")
    IMPOSSIBLE = marked("not possible")  # what was typed cannot be sent
    WRITING = marked("writing")
    VERIFIED = marked("verified")  # written and read back equal; what reads otherwise later ends the conversation
    FAILED = marked("failed")  # until the module has the value


@dataclass(frozen=True, slots=True, kw_only=True)
class FormRow:
    """One setting. `reason` says why it failed, in the language in use; with `is_pending` the next
    write sends it; `mistyped` was typed and cannot be sent."""

    command: Command
    module_value: Known | None
    edited: Value | None
    state: RowState
    reason: str = ""
    is_pending: bool = False
    mistyped: str = ""

    @property
    def consequences(self) -> tuple[Consequence, ...]:
        """What the edited value means, or the module's where there is no edit."""
        value = self.edited
        if value is None and self.module_value is not None and not self.module_value.is_stale:
            value = self.module_value.value
        return () if value is None else consequences(self.command, value)


class SettingsForm:
    """Of one conversation, and for one thread."""

    def __init__(self) -> None:
        # All by the setting's key. What was typed and cannot be sent takes the place of an edit.
        self.edited: dict[str, Value] = {}
        self.mistyped: dict[str, str] = {}
        self._writing: dict[str, Value] = {}
        # What came of writing it, as long as it stands: verified, or failed.
        self._results: dict[str, Written] = {}

    # Editing: not while it writes

    @property
    def is_writing(self) -> bool:
        return bool(self._writing)

    @property
    def has_drafts(self) -> bool:
        return bool(self.edited or self.mistyped)

    def fill(self, values: Mapping[str, Value]) -> None:
        """Edit all of these; what is no row of the form is left out."""
        for key, value in values.items():
            if key in _BY_KEY and not self._writing:
                if self.edited.get(key) != value:
                    self.revert(key)
                    self.edited[key] = value
                self.mistyped.pop(key, None)

    def mistype(self, key: str, text: str) -> None:
        """What was typed is no value, so half of it is never sent."""
        if not self._writing:
            self.revert(key)
            self.mistyped[key] = text

    def revert(self, key: str | None = None) -> None:
        """Remove the edit of one row with its failure, or all of them."""
        if self._writing:
            return
        for one in list(_BY_KEY) if key is None else [key]:
            self.mistyped.pop(one, None)
            self.edited.pop(one, None)
            if one in self._results and self._results[one].fault is not None:
                del self._results[one]

    # Rows

    def rows(self, conversation: ConversationView, now: float) -> tuple[FormRow, ...]:
        """Takes what the module says first: it may end a "verified", or settle what had failed."""
        for key, result in list(self._results.items()):
            if result.fault is None:
                if conversation.fresh(key, now) != result.target:  # set again, by another part of the program
                    del self._results[key]
            elif not self._writing and is_confirmed(result.command, conversation.known(key, now), result.target):
                del self._results[key]  # written after all, but late
                if self.edited.get(key) == result.target:
                    del self.edited[key]
        return tuple(self._row(command, conversation.known(command.key, now)) for command in FORM_COMMANDS)

    def changes(self, conversation: ConversationView, now: float) -> tuple[SettingChange, ...]:
        """Return what a write would send: edits that are not known to be on the module."""
        rows = self.rows(conversation, now)
        return tuple(
            SettingChange(row.command, row.edited) for row in rows if row.is_pending and row.edited is not None
        )

    def count_unsent(self, conversation: ConversationView, now: float) -> int:
        """Return how many edits leaving would lose, those being written included."""
        rows = self.rows(conversation, now)
        return sum(row.is_pending or row.state is RowState.WRITING or bool(row.mistyped) for row in rows)

    def _row(self, command: Command, known: Known | None) -> FormRow:
        key = command.key
        edited, result = self.edited.get(key), self._results.get(key)
        has_it = edited is not None and is_confirmed(command, known, edited)
        is_pending = edited is not None and not has_it and key not in self._writing
        reason = ""
        if key in self._writing:
            state = RowState.WRITING
        elif key in self.mistyped:
            state = RowState.IMPOSSIBLE
        elif result is not None and result.fault is not None:
            state = RowState.FAILED
            target, why = value_text(command, result.target), tr(result.fault.value)
            if result.read_back is None:
                reason = tr("{wanted} was sent: {why}.", wanted=target, why=why)
            else:
                stands = value_text(command, result.read_back)
                reason = tr("{wanted} was sent: {why}. It holds {stands}.", wanted=target, why=why, stands=stands)
        elif is_pending:
            state = RowState.EDITED
        elif result is not None:
            state = RowState.VERIFIED
        elif known is None:
            state = RowState.UNKNOWN
        elif known.is_stale:
            state = RowState.STALE
        else:
            state = RowState.ACKNOWLEDGED if known.how is How.ACKNOWLEDGED else RowState.READ
        return FormRow(
            command=command,
            module_value=known,
            edited=edited,
            state=state,
            reason=reason,
            is_pending=is_pending,
            mistyped=self.mistyped.get(key, ""),
        )

    # Writing

    def begin_write(self, changes: Iterable[SettingChange]) -> None:
        """Nothing can be edited until `on_written`."""
        self._writing = {change.command.key: change.value for change in changes}
        for key in self._writing:
            self._results.pop(key, None)

    def on_written(self, results: Iterable[Written], conversation: ConversationView, now: float) -> None:
        """Take what came of each change. What was not sent stays edited; of the rest, what the module has already is no
        edit any more."""
        self._writing = {}
        for written in results:
            key = written.command.key
            if written.is_sent and key in _BY_KEY:
                if written.fault is not None or written.verified:
                    self._results[key] = written
                if written.fault is None:
                    self.edited.pop(key, None)
        for key, value in list(self.edited.items()):
            if is_confirmed(_BY_KEY[key], conversation.known(key, now), value):
                del self.edited[key]


def is_confirmed(command: Command, known: Known | None, value: Value) -> bool:
    """Return whether the module has reported `value`. An acknowledgement proves nothing where it can be read (E2)."""
    if known is None or known.is_stale or known.value != value:
        return False
    return known.how is not How.ACKNOWLEDGED or not command.reads_back


# A profile beside the module


class Match(Enum):
    """How a setting of a profile compares; the value is its English, translatable word."""

    SAME = marked("same")
    DIFFERENT = marked("different")
    UNKNOWN = marked("unknown")
    NOT_IN_PROFILE = marked("not in the profile")


class ProfileRow(NamedTuple):
    """One setting in the profile (`target`) and on the module."""

    command: Command
    target: Value | None
    module_value: Known | None
    match: Match

    @property
    def is_worth_applying(self) -> bool:
        """Ticked at first: different or unknown."""
        return self.match in (Match.DIFFERENT, Match.UNKNOWN)


def compare(profile: Profile, conversation: ConversationView, now: float) -> tuple[ProfileRow, ...]:
    """Compare all settings, in the order of the catalogue. A stale value of the module counts as unknown."""
    rows = []
    for command in SETTINGS:
        target, known = profile.settings.get(command.key), conversation.known(command.key, now)
        if target is None:
            match = Match.NOT_IN_PROFILE
        elif known is None or known.is_stale:
            match = Match.UNKNOWN
        else:
            match = Match.SAME if known.value == target else Match.DIFFERENT
        rows.append(ProfileRow(command, target, known, match))
    return tuple(rows)
