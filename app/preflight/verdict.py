"""Verdict of a pre-flight check, and what voids it later.

NO-GO   a check fails or its input is unknown, or a manual item stands against it
READY   everything holds and the module is locked: it does not fire yet
GO      everything holds and the module itself reports that it is active
"""

from collections.abc import Iterable, Mapping
from enum import Enum
from typing import NamedTuple

from app.engine.conversation import ConversationView, StatusSample
from app.limits.limits import is_bay_open, softened
from app.preflight.checks import CHECKS, Case, Check, CheckResult, Finding
from app.preflight.evidence import FIRED, OVER, TOO_OLD, UNFINISHED, Void, changed, void_of_end
from app.safety.journal import REQUESTS, Act
from app.settings.profiles import ActivatedBy, ManualLine
from app.text.messages import UserMessage, clean, message
from protocol.catalogue import COMMANDS
from protocol.events import Event, Sent
from protocol.translatable import marked

# 15 minutes, then the check has to be repeated.
VALID_FOR_S = 900.0
# While GO or READY stands, everything is read again this often.
REREAD_EVERY_S = 10.0
_TITLES = {command.key: command.title for command in COMMANDS}


class Verdict(Enum):
    """The value is the word in records and in the JSON output, translatable."""

    GO = marked("GO")
    READY = marked("READY")
    NO_GO = marked("NO-GO")


def verdict_of(*, is_fine: bool, is_active: bool | None) -> Verdict:
    """`is_fine`: no check or manual item stands against it. `is_active`: as last reported by the module."""
    # Whether it fires has to be known: neither word is said of a module that does not report it.
    if not is_fine or is_active is None:
        return Verdict.NO_GO
    return Verdict.GO if is_active else Verdict.READY


def meaning_of(verdict: Verdict, activated_by: ActivatedBy) -> UserMessage:
    match verdict:
        case Verdict.GO:
            return message(marked("fit to fly"))
        case Verdict.NO_GO:
            return message(marked("do not fly"))
        case Verdict.READY if activated_by is ActivatedBy.AIRCRAFT:
            return message(marked("the aircraft activates it"))
        case Verdict.READY:
            return message(marked("activate before the flight"))


def verdict_sentence(verdict: Verdict, activated_by: ActivatedBy) -> UserMessage:
    word = UserMessage(verdict.value)
    return message(marked("{value}: {why}"), value=word, why=meaning_of(verdict, activated_by))


MANUAL_WORDS: Mapping[bool | None, str] = {
    True: marked("done"),
    False: marked("Not OK"),
    None: marked("skipped"),
}


def blocks_go(item: ManualLine) -> bool:
    """A required item must not be skipped; the others are printed as skipped."""
    return item.is_done is False or (item.is_done is None and item.is_required)


class Judged(NamedTuple):
    check: Check
    finding: Finding

    @property
    def blocks_go(self) -> bool:
        return self.finding.result in (CheckResult.FAIL, CheckResult.UNKNOWN)

    @property
    def do(self) -> UserMessage:
        return self.finding.do or UserMessage(self.check.do)


class Assessment(NamedTuple):
    """Results of all checks, in the order of `CHECKS`. `softened`: ids of those whose limit is softer in the profile
    than advised."""

    case: Case
    checks: tuple[Judged, ...]
    softened: tuple[str, ...] = ()

    @property
    def verdict(self) -> Verdict:
        is_fine = not any(map(blocks_go, self.case.profile.manual)) and not self.open_checks
        return verdict_of(is_fine=is_fine, is_active=self.case.evidence.is_active)

    @property
    def open_checks(self) -> tuple[str, ...]:
        """Ids of the checks that stand against GO and READY."""
        return tuple(check.check.id for check in self.checks if check.blocks_go)

    @property
    def titles_against(self) -> tuple[UserMessage, ...]:
        """Titles of the checks and texts of the manual items that stand against GO and READY."""
        checks = (check.check.title for check in self.checks if check.blocks_go)
        items = (clean(item.text, longest=40) for item in self.case.profile.manual if blocks_go(item))
        return tuple(map(UserMessage, (*checks, *items)))

    def result(self, id_: str) -> CheckResult:
        return next(check.finding.result for check in self.checks if check.check.id == id_)


class Standing(Enum):
    """The verdict as it stands now. The value is translatable, of one that holds that of its `Verdict`."""

    NOT_CHECKED = marked("not checked")
    CHECKING = marked("checking…")
    GO = Verdict.GO.value
    READY = Verdict.READY.value
    NO_GO = Verdict.NO_GO.value
    VOID = marked("void")


class CheckState(NamedTuple):
    """How the check of a module stands now, for everything that speaks of it. `assessment`: what came of it, also where
    it is `void`; None while it runs, so that no old finding is shown."""

    standing: Standing = Standing.NOT_CHECKED
    assessment: Assessment | None = None
    void: Void | None = None

    @property
    def verdict(self) -> Verdict | None:
        """None unless it holds."""
        return next((verdict for verdict in Verdict if verdict.value == self.standing.value), None)

    @property
    def has_passed(self) -> bool:
        return self.standing in (Standing.GO, Standing.READY)

    @property
    def ended_at(self) -> float | None:
        """None also for one that broke off."""
        return None if self.assessment is None else self.assessment.case.evidence.ended_at


NOT_CHECKED = CheckState()


def check_state(assessment: Assessment | None, void: Void | None, *, is_running: bool) -> CheckState:
    """Return the state of a check that was begun."""
    # What voids one that runs is said when it ends, with what it found.
    if is_running or (assessment is None and void is None):
        return CheckState(Standing.CHECKING)
    if assessment is None or void is not None:
        return CheckState(Standing.VOID, assessment, void)
    return CheckState(Standing(assessment.verdict.value), assessment)


def assess(case: Case) -> Assessment:
    """Judge everything. A limit softer than advised is shown with the advice, and is a warning."""
    soft, judged = softened(case.profile), list[Judged]()
    for check in CHECKS:
        finding, advised = check.judge(case), soft.get(check.id)
        if advised is not None:
            limit = message(marked("{limit}, advised {advised}"), limit=finding.limit, advised=advised)
            is_passed = finding.result is CheckResult.PASS
            finding = finding._replace(limit=limit, result=CheckResult.WARN if is_passed else finding.result)
        judged.append(Judged(check, finding))
    return Assessment(case, tuple(judged), tuple(soft))


# What voids it later


def void_of_news(events: Iterable[Event], samples: Iterable[StatusSample]) -> Void | None:
    """Whether it may have fired by what came with one batch. To be asked with each."""
    # A deploy that left the computer counts, confirmed or not.
    has_left = any(isinstance(event, Sent) and event.request == REQUESTS[Act.DEPLOY] for event in events)
    return FIRED if has_left or any(sample.triggered for sample in samples) else None


def void_reason(assessment: Assessment, conversation: ConversationView, now: float) -> Void | None:
    """Why the verdict does not hold at `now`; None while it does. To be asked with each batch."""
    evidence = assessment.case.evidence
    if evidence.void is not None:
        return evidence.void
    if evidence.ended_at is None:
        return UNFINISHED
    if conversation.number != evidence.conversation:
        return OVER
    if conversation.ended is not None:
        return void_of_end(conversation.ended)
    if conversation.reported[0] is True and not evidence.has_triggered:
        return FIRED
    key = _changed(assessment, conversation, now)
    if key is not None:
        return changed(UserMessage(_TITLES[key]))
    # Also from the future: the clock that judges would be another one.
    return None if 0.0 <= now - evidence.ended_at <= VALID_FOR_S else TOO_OLD


def _changed(assessment: Assessment, conversation: ConversationView, now: float) -> str | None:
    """The key of the first value that differs from the checked one: it was set since, or drifted."""
    evidence, profile = assessment.case.evidence, assessment.case.profile
    checked = evidence.settings
    charging = evidence.series.get("charging")
    if charging:
        checked["charging"] = charging[-1]
    for key, before in checked.items():
        known = conversation.values.get(key)
        if known is not None and known.value != before:
            return key
    for key, flag in evidence.flags.items():
        known = conversation.values.get(key)
        # Absent: it was set and not acknowledged, or an acknowledgement came once more.
        if flag.is_enabled is not None and (known is None or known.value is not flag.is_enabled):
            return key
    # What drifts voids only what had passed.
    voltage = conversation.fresh("cell_voltage_v", now)
    was_charged = assessment.result("cell_voltage") is CheckResult.PASS
    if was_charged and voltage is not None and voltage < profile.limit("cell_voltage_min_v"):
        return "cell_voltage_v"
    light, threshold = conversation.fresh("light_v", now), evidence.values.get("light_threshold_v")
    if light is None or threshold is None or assessment.result("light") is not CheckResult.PASS:
        return None
    return "light_v" if is_bay_open(light, threshold, is_inverted=profile.is_light_inverted) else None
