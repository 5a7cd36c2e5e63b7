"""What a person wants of each setting beside what the module says of it, and a profile beside the module.

The baud rate is no row of the form: changing it may cut the link, so it has a procedure and a panel of its own.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from app.engine.conversation import ConversationView, How, Known
from app.procedures.write import Written
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


@dataclass(slots=True)
class SettingDraft:
    """The draft of one setting in one conversation."""

    command: Command
    known: Known | None = None
    # Text is what was typed and cannot be sent: it takes the place of an edit, so half of it is never sent.
    wanted: Value | str | None = None
    is_writing: bool = False
    # What came of writing it, as long as it stands: verified, or failed.
    result: Written | None = None

    def want(self, wanted: Value | str | None) -> None:
        """Another wish ends what had failed."""
        if wanted != self.wanted:
            if self.result is not None and self.result.fault is not None:
                self.result = None
            self.wanted = wanted

    def take(self, known: Known | None) -> None:
        """Take what the module says, which may end a "verified", or mend what had failed."""
        self.known, result = known, self.result
        if result is None:
            return
        if result.fault is None:
            if known is None or known.is_stale or known.value != result.target:
                self.result = None  # set again, by another part of the program
        elif is_confirmed(self.command, known, result.target):
            self.result = None  # written after all, but late
            if self.wanted == result.target:
                self.wanted = None

    def end_write(self, written: Written | None, known: Known | None) -> None:
        """Take the report of a write: what was not sent stays edited; what the module has already is no edit any
        more."""
        self.is_writing = False
        if written is not None and written.is_sent:
            if written.fault is None:
                self.wanted = None
            self.result = written if written.fault is not None or written.verified else None
        self.take(known)
        if self.edited is not None and self.pending is None:
            self.wanted = None

    @property
    def edited(self) -> Value | None:
        return None if isinstance(self.wanted, str) else self.wanted

    @property
    def pending(self) -> Value | None:
        """What the next write sends: an edit that the module is not known to have."""
        edited = self.edited
        has_it = edited is not None and is_confirmed(self.command, self.known, edited)
        return None if has_it or self.is_writing else edited

    @property
    def unsent(self) -> Value | str | None:
        return self.wanted if isinstance(self.wanted, str) else self.pending

    @property
    def state(self) -> RowState:
        if self.is_writing:
            return RowState.WRITING
        if isinstance(self.wanted, str):
            return RowState.IMPOSSIBLE
        if self.result is not None and self.result.fault is not None:
            return RowState.FAILED
        if self.pending is not None:
            return RowState.EDITED
        if self.result is not None:
            return RowState.VERIFIED
        if self.known is None:
            return RowState.UNKNOWN
        if self.known.is_stale:
            return RowState.STALE
        return RowState.ACKNOWLEDGED if self.known.how is How.ACKNOWLEDGED else RowState.READ

    @property
    def reason(self) -> str:
        """Why it is in its state, in the language in use."""
        if self.state is RowState.ACKNOWLEDGED:
            return tr("cannot be read")
        result = self.result
        if self.state is not RowState.FAILED or result is None or result.fault is None:
            return ""
        target, why = value_text(self.command, result.target), tr(result.fault.value)
        if result.read_back is None:
            return tr("{wanted} was sent: {why}.", wanted=target, why=why)
        stands = value_text(self.command, result.read_back)
        return tr("{wanted} was sent: {why}. It holds {stands}.", wanted=target, why=why, stands=stands)

    @property
    def consequences(self) -> tuple[Consequence, ...]:
        """What the edited value means, or the module's where there is no edit."""
        value = self.edited
        if value is None and self.known is not None and not self.known.is_stale:
            value = self.known.value
        return () if value is None else consequences(self.command, value)


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
    """One setting as the profile has it (`target`) and as the module has it."""

    command: Command
    target: Value | None
    module_value: Known | None

    @property
    def match(self) -> Match:
        """A stale value of the module counts as unknown."""
        if self.target is None:
            return Match.NOT_IN_PROFILE
        if self.module_value is None or self.module_value.is_stale:
            return Match.UNKNOWN
        return Match.SAME if self.module_value.value == self.target else Match.DIFFERENT

    @property
    def is_worth_applying(self) -> bool:
        """Ticked at first: different or unknown."""
        return self.match in (Match.DIFFERENT, Match.UNKNOWN)


def compare(profile: Profile, conversation: ConversationView, now: float) -> tuple[ProfileRow, ...]:
    """Compare all settings, in the order of the catalogue."""
    return tuple(
        ProfileRow(command, profile.settings.get(command.key), conversation.known(command.key, now))
        for command in SETTINGS
    )
