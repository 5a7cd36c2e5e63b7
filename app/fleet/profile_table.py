"""One profile for several modules: differences, what to write, and the results."""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from app.engine.conversation import ConversationView
from app.procedures.write import SettingChange, WriteReport
from app.settings.form import ProfileRow, compare
from app.settings.profiles import Profile
from app.text.i18n import tr
from app.text.messages import UserMessage, joined, message
from app.text.sentences import in_brackets, join_names, labelled
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT, Command
from protocol.translatable import marked

# Never written to several: the baud rate needs a permit for each module, the program itself switches the other.
LEFT_OUT = (BAUD_RATE, SERIAL_OUTPUT)
NOT_READ_BACK = marked("Not read back: {names}.")


def differences(profile: Profile, conversation: ConversationView, now: float) -> list[ProfileRow]:
    """What differs from the profile or is unknown, in the catalogue's order."""
    rows = compare(profile, conversation, now)
    return [row for row in rows if row.is_worth_applying and row.command not in LEFT_OUT]


def changes_of(rows: Iterable[ProfileRow]) -> tuple[SettingChange, ...]:
    return tuple(SettingChange(row.command, row.target) for row in rows if row.target is not None)


class Applied(Enum):
    """Result of applying the profile to a module; the value is translatable."""

    WRITING = marked("writing")
    NOTHING_TO_DO = marked("unchanged")
    VERIFIED = marked("verified")
    ACKNOWLEDGED = marked("written")
    REFUSED = marked("refused")
    FAILED = marked("FAILED")
    UNREACHABLE = marked("offline")

    @property
    def is_fine(self) -> bool:
        return self in (Applied.NOTHING_TO_DO, Applied.VERIFIED, Applied.ACKNOWLEDGED)


class AppliedProfile(NamedTuple):
    """`why`: sentences."""

    state: Applied
    why: tuple[UserMessage, ...] = ()

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        return joined(self.why, " ").translated() if self.why else ""


def outcome_of(report: WriteReport) -> AppliedProfile:
    """Verified only if everything that can be read back was read back equal."""
    refused = tuple(refusal.message for refusal in report.refusals)
    if report.is_refused:
        return AppliedProfile(Applied.REFUSED, refused)
    why = [*refused]
    if report.interrupted is not None:
        why.append(report.interrupted.message)
    if report.is_cancelled:
        why.append(message(marked("Cancelled: the rest is unknown.")))
    why += _named(marked("Not verified: {names}."), [one.command for one in report.results if not one.is_fine])
    changed = [] if report.changed is None else [report.changed.after.command]
    why += _named(marked("Changed without being written: {names}."), changed)
    why += _named(NOT_READ_BACK, report.unread)
    if why:
        return AppliedProfile(Applied.FAILED, tuple(why))
    unproven = _named(NOT_READ_BACK, [one.command for one in report.results if one.verified is None])
    if unproven:
        return AppliedProfile(Applied.ACKNOWLEDGED, tuple(unproven))
    return AppliedProfile(Applied.VERIFIED if report.results else Applied.NOTHING_TO_DO)


def _named(text: str, commands: Iterable[Command]) -> list[UserMessage]:
    """One sentence with the names of these settings; none where there are none."""
    titles = [message(command.title) for command in commands]
    return [message(text, names=joined(titles))] if titles else []


def result_line(applied: Iterable[tuple[str, AppliedProfile]]) -> str:
    """What came of each, by name, and why where one was not written: "2 verified: M-01, M-02 · 1 refused: M-03: …"."""
    results = list(applied)
    parts = []
    for state in Applied:
        names = [in_words(name, result) for name, result in results if result.state is state]
        if names:
            parts.append(labelled(f"{len(names)} {tr(state.value)}", join_names(names)))
    return " · ".join(parts)


def in_words(name: str, result: AppliedProfile) -> str:
    return name if result.state.is_fine or not result.why else name + in_brackets(result.sentence)
