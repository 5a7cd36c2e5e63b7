"""One profile for several modules: differences, what to write, and the results."""

from collections.abc import Iterable, Sequence
from enum import Enum
from typing import NamedTuple

from app.engine.device import DeviceView
from app.engine.procedure import Cancelled, TwoModules
from app.procedures.write import Written
from app.procedures.write_all import SettingChange, WriteReport
from app.safety.interlocks import Refusal
from app.settings.form import ProfileRow, compare
from app.settings.profiles import Profile
from app.text.i18n import tr
from app.text.sentences import in_brackets, join_names, join_sentences, labelled
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT, SETTINGS, Command
from protocol.translatable import marked

LEFT_OUT = (BAUD_RATE, SERIAL_OUTPUT)
"""Never written to several: the baud rate needs a permit for each module, the program itself switches the other."""
NOT_READ_BACK = marked("Not read back: {names}.")


class Column(NamedTuple):
    """One module: a row for each setting of the profile."""

    port: str
    title: str
    rows: tuple[ProfileRow, ...]
    is_reachable: bool = True

    @property
    def changes(self) -> tuple[SettingChange, ...]:
        """What differs from the profile or is unknown; nothing of a module that is not reached."""
        return tuple(
            SettingChange(row.command, row.target)
            for row in self.rows
            if self.is_reachable and row.is_worth_applying and row.target is not None
        )


def settings_in(profile: Profile) -> tuple[Command, ...]:
    """Settings that are compared and written, in the catalogue's order."""
    return tuple(command for command in SETTINGS if command.key in profile.settings and command not in LEFT_OUT)


def column(
    profile: Profile, device: DeviceView, now: float, *, port: str, title: str, is_reachable: bool = True
) -> Column:
    settings = settings_in(profile)
    rows = tuple(row for row in compare(profile, device, now) if row.command in settings)
    return Column(port, title, rows, is_reachable)


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
    """`parts`: sentences with the place for the names of these settings."""

    state: Applied
    parts: tuple[tuple[str, tuple[Command, ...]], ...] = ()
    refusals: tuple[Refusal, ...] = ()

    @property
    def why(self) -> str:
        """In the language in use now."""
        lines = (tr(text, names=join_names(tr(command.title) for command in commands)) for text, commands in self.parts)
        return join_sentences((*(refusal.sentence for refusal in self.refusals), *lines))


def outcome_of(report: WriteReport) -> AppliedProfile:
    """Verified only if everything that can be read back was read back equal."""
    if report.is_refused:
        return AppliedProfile(Applied.REFUSED, refusals=report.refusals)
    parts = (
        (marked("Not as written: {names}."), tuple(result.command for result in report.results if not result.is_fine)),
        (marked("Changed without being written: {names}."), tuple(change.command for change in report.changed)),
        (NOT_READ_BACK, report.unread),
    )
    failed = tuple((text, commands) for text, commands in parts if commands)
    if failed:
        return AppliedProfile(Applied.FAILED, failed, report.refusals)
    unproven = tuple(result.command for result in report.results if result.verified is None)
    if unproven:
        return AppliedProfile(Applied.ACKNOWLEDGED, ((NOT_READ_BACK, unproven),))
    return AppliedProfile(Applied.VERIFIED if report.results else Applied.NOTHING_TO_DO)


def broken_off(heard: Sequence[Written], error: BaseException) -> AppliedProfile:
    """The result after a lost link or a cancel: what was not read back is unknown."""
    text = marked("Link lost: the rest is unknown.")
    if isinstance(error, TwoModules):
        text = marked("Two modules on this line? The rest is unknown.")
    elif isinstance(error, Cancelled):
        text = marked("Cancelled: the rest is unknown.")
    done = tuple(written.command for written in heard if written.verified)
    written = ((marked("Written: {names}."), done),) if done else ()
    return AppliedProfile(Applied.FAILED, ((text, ()), *written))


def result_line(applied: Iterable[tuple[str, AppliedProfile]]) -> str:
    """What came of each, by name, and why where one was not written: "2 verified: M-01, M-02 · 1 refused: M-03: …"."""
    results = list(applied)
    parts = []
    for state in Applied:
        names = [
            in_words(name, "" if state.is_fine else result.why) for name, result in results if result.state is state
        ]
        if names:
            parts.append(labelled(f"{len(names)} {tr(state.value)}", join_names(names)))
    return " · ".join(parts)


def in_words(name: str, why: str) -> str:
    return name + in_brackets(why) if why else name
