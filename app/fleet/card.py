"""State of one module as the fleet page shows it and what it needs next; one profile for several modules."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from app.diagnosis.link_state import LinkState, Phase
from app.engine.conversation import ConversationView
from app.limits.limits import Outside
from app.preflight.verdict import NOT_CHECKED, CheckState, Standing, Verdict, verdict_sentence
from app.procedures.lock import Locked, waiting_sentence
from app.procedures.write import SettingChange, WriteReport, why_not_verified
from app.safety.last_known import LAST_HEARD_ACTIVE, Activation, SeenActivation
from app.settings.form import ProfileRow, compare
from app.settings.profiles import ActivatedBy, Profile
from app.text.i18n import tr
from app.text.messages import UserMessage, capitalised, in_brackets, join_names, joined, labelled, message
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT
from protocol.translatable import marked


class Need(Enum):
    """The next thing that a module needs, the most urgent first. The value is a translatable sentence, or a name where
    `Card.needed` has another one."""

    TRIGGERED = marked("TRIGGERED: lock it, read its records.")
    NOT_LOCKED = "not locked"
    WAS_ACTIVE = LAST_HEARD_ACTIVE
    MAY_HAVE_FIRED = marked("The module may have fired before the restart: read the trigger records.")
    LINK = "link"
    NO_GO = marked("Not met: {names}")
    OUTSIDE = "outside"
    ACTIVE = marked("ACTIVE, not checked")
    ACTIVE_READY = marked("ACTIVE; the check said READY")
    VOID = marked("Check again: {why}")
    NAME = marked("{module} again? Read its label.")
    CHECK = marked("Start the check.")
    ACTIVATE = "activate"
    WAIT = "wait"
    NOTHING = marked("None")


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """A card shows one module."""

    port: str
    link: LinkState
    conversation: ConversationView = field(compare=False, repr=False)
    activation: SeenActivation
    # It was ACTIVE before it restarted, and its trigger records were not read since.
    may_have_fired: bool = False
    # Said by a person in this conversation; `expected` is the name in the one before.
    name: str = ""
    expected: str = ""
    check: CheckState = NOT_CHECKED
    # How often LOCK was sent, while it is being repeated.
    lock_sent: int | None = None
    # The module did not report that it is locked.
    lock_failed: Locked | None = None
    # The other pages show this module.
    is_shown: bool = False
    # What is wrong with the present cell voltage.
    cell_outside: Outside | None = None

    def needed(self) -> tuple[Need, str]:
        """The most urgent thing for a person to do, and its sentence in the language in use."""
        # In this order: what may fire or has fired, then what cannot be known, then what a check said.
        check, state = self.check, self.activation.state
        if self.conversation.reported[0] is True:
            return _plain(Need.TRIGGERED)
        if self.lock_sent is not None:
            return Need.NOT_LOCKED, waiting_sentence(self.lock_sent)
        if self.lock_failed is not None:
            return Need.NOT_LOCKED, self.lock_failed.sentence
        if state is Activation.WAS_ACTIVE:
            return _plain(Need.WAS_ACTIVE)
        if self.may_have_fired:
            return _plain(Need.MAY_HAVE_FIRED)
        if self.link.phase is not Phase.ONLINE:
            is_coming = self.link.phase in (Phase.OPENING, Phase.FINDING, Phase.ASKING)
            return Need.WAIT if is_coming else Need.LINK, self.link.next_step or self.link.what
        if check.standing is Standing.CHECKING:
            return Need.WAIT, capitalised(tr("checking…"))
        if check.standing is Standing.NO_GO:
            against = () if check.assessment is None else check.assessment.titles_against
            return Need.NO_GO, tr(Need.NO_GO.value, names=join_names(title.translated() for title in against))
        if self.cell_outside is not None:
            fault, limit = tr(self.cell_outside.fault.value), tr("limit {value}", value=self.cell_outside.limit)
            return Need.OUTSIDE, labelled(tr("Cell voltage"), join_names((fault, limit)))
        if check.standing is Standing.GO:
            return _plain(Need.NOTHING)
        if check.standing is Standing.READY and state is Activation.ACTIVE:
            return _plain(Need.ACTIVE_READY)
        if check.standing is Standing.READY:
            return Need.ACTIVATE, verdict_sentence(Verdict.READY, ActivatedBy.PERSON).translated()
        if check.void is not None:
            return Need.VOID, tr(Need.VOID.value, why=check.void.message.translated())
        if state is Activation.ACTIVE:
            return _plain(Need.ACTIVE)
        if self.expected and not self.name:
            return Need.NAME, tr(Need.NAME.value, module=self.expected)
        return _plain(Need.CHECK)


def _plain(need: Need) -> tuple[Need, str]:
    return need, tr(need.value)


# One profile for several modules


def differences(profile: Profile, conversation: ConversationView, now: float) -> list[ProfileRow]:
    """Return the settings that differ from the profile or are unknown, in the catalogue's order. The baud rate needs a
    permit for each module, and the serial output is switched by the program itself, so neither is ever written to
    several."""
    rows = compare(profile, conversation, now)
    return [row for row in rows if row.is_worth_applying and row.command not in (BAUD_RATE, SERIAL_OUTPUT)]


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
    """`why`: one sentence or several."""

    state: Applied
    why: UserMessage = UserMessage("")


def outcome_of(report: WriteReport) -> AppliedProfile:
    """Verified only if everything that can be read back was read back equal."""
    if report.is_refused:
        return AppliedProfile(Applied.REFUSED, joined([refusal.message for refusal in report.refusals], " "))
    if not report.is_fine:
        return AppliedProfile(Applied.FAILED, joined(whats_not_as_written(report), " "))
    unproven = [message(one.command.title) for one in report.results if one.verified is None]
    if unproven:
        why = message(marked("Not read back: {names}."), names=joined(unproven))
        return AppliedProfile(Applied.ACKNOWLEDGED, why)
    return AppliedProfile(Applied.VERIFIED if report.results else Applied.NOTHING_TO_DO)


def whats_not_as_written(report: WriteReport) -> tuple[UserMessage, ...]:
    """Each setting that is not as it was written, with the reason."""
    named = []
    for written in report.results:
        why = why_not_verified(written, report)
        if why is not None:
            named.append(message(marked("{value}: {why}"), value=message(written.command.title), why=why))
    return tuple(named)


def result_line(applied: Iterable[tuple[str, AppliedProfile]]) -> str:
    """Return what came of each module, by name, and why where one was not written: "2 verified: M-01, M-02 · 1 refused:
    M-03 (…)"."""
    words: dict[Applied, list[str]] = {state: [] for state in Applied}
    for name, result in applied:
        why = "" if result.state.is_fine else result.why.translated()
        words[result.state].append(name + in_brackets(why) if why else name)
    lines = (labelled(f"{len(names)} {tr(one.value)}", join_names(names)) for one, names in words.items() if names)
    return " · ".join(lines)
