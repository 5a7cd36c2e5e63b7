"""One profile for several modules: what differs on each, what is to be written, and what came of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from app.engine.device import DeviceView
from app.engine.procedure import Cancelled
from app.procedures.write import Written
from app.procedures.write_all import SettingChange, WriteReport
from app.settings.profiles import Match, Profile, ProfileRow, compare
from app.text.i18n import tr
from app.text.sentences import listed, together
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT, Command
from protocol.translatable import marked

LEFT_OUT = (BAUD_RATE, SERIAL_OUTPUT)
"""Never written to several: the one needs a permit for each module, the other is switched by the program."""


@dataclass(frozen=True, slots=True)
class Column:
    """One module: a row for each setting of the profile."""

    port: str
    title: str
    rows: tuple[ProfileRow, ...]
    is_reachable: bool = True

    @property
    def changes(self) -> tuple[SettingChange, ...]:
        """What differs from the profile, and what nobody knows."""
        return tuple(
            SettingChange(row.command, row.wanted)
            for row in self.rows
            if row.is_worth_applying and row.wanted is not None
        )


def settings_in(profile: Profile) -> tuple[Command, ...]:
    """Those that are compared and written, in the catalogue's order."""
    rows = compare(profile, DeviceView(), 0.0)
    return tuple(row.command for row in rows if row.match is not Match.NOT_IN_PROFILE and row.command not in LEFT_OUT)


def column(
    profile: Profile, device: DeviceView, now: float, *, port: str, title: str, is_reachable: bool = True
) -> Column:
    wanted = settings_in(profile)
    rows = tuple(row for row in compare(profile, device, now) if row.command in wanted)
    return Column(port, title, rows, is_reachable)


class Applied(Enum):
    """How a module stands after the profile was applied; the value is a word, translatable."""

    WAITING = marked("waiting")
    WRITING = marked("writing")
    NOTHING_TO_DO = marked("matches already")
    VERIFIED = marked("written and verified")
    ACKNOWLEDGED = marked("written")
    REFUSED = marked("refused")
    FAILED = marked("FAILED")
    UNREACHABLE = marked("not reached")

    @property
    def is_fine(self) -> bool:
        return self in (Applied.NOTHING_TO_DO, Applied.VERIFIED, Applied.ACKNOWLEDGED)

    @property
    def is_over(self) -> bool:
        return self not in (Applied.WAITING, Applied.WRITING)


@dataclass(frozen=True, slots=True)
class AppliedProfile:
    """`why`: a sentence, in the language in which it was made."""

    state: Applied = Applied.WAITING
    why: str = ""


def outcome_of(report: WriteReport) -> AppliedProfile:
    """Fine only where everything that can be read back was read back equal."""
    if report.refusals:
        return AppliedProfile(Applied.REFUSED, together(one.sentence for one in report.refusals))
    failed = [one.command for one in report.results if not one.is_fine]
    changed = [one.command for one in report.changed]
    if failed or changed or report.unread:
        parts = (
            (marked("Not as written: {names}."), failed),
            (marked("Changed without being written: {names}."), changed),
            (marked("Not read back: {names}."), report.unread),
        )
        why = together(tr(text, names=_titles(commands)) for text, commands in parts if commands)
        return AppliedProfile(Applied.FAILED, why)
    unproven = [one.command for one in report.results if one.verified is None]
    if unproven:
        return AppliedProfile(Applied.ACKNOWLEDGED, tr("Not read back: {names}.", names=_titles(unproven)))
    return AppliedProfile(Applied.VERIFIED if report.results else Applied.NOTHING_TO_DO)


def broken_off(heard: Sequence[Written], error: BaseException) -> AppliedProfile:
    """The connection was lost, or it was cancelled: what was not read back is not known."""
    if isinstance(error, Cancelled):
        text = tr("Cancelled: the rest is unknown.")
    else:
        text = tr("Link lost: the rest is unknown.")
    done = [one.command for one in heard if one.verified]
    more = tr("Written: {names}.", names=_titles(done)) if done else ""
    return AppliedProfile(Applied.FAILED, together((text, more)))


def result_line(applied: Mapping[str, AppliedProfile]) -> str:
    """ "3 written and verified, 1 FAILED"."""
    states = [one.state for one in applied.values()]
    return listed(f"{states.count(state)} {tr(state.value)}" for state in Applied if state in states)


def _titles(commands: Sequence[Command]) -> str:
    return listed(tr(command.title) for command in commands)
