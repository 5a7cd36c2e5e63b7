"""A check: its entry, its input, and its result with measurement and limit."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from app.limits.past import Past
from app.preflight.evidence import CANCELLED, Evidence
from app.settings.profiles import Profile
from app.settings.values import fingerprint
from app.text.messages import UserMessage, message
from protocol.fields import Value
from protocol.translatable import marked


class CheckResult(Enum):
    """The value is the word in the JSON output."""

    PASS = "pass"  # noqa: S105  no password
    FAIL = "fail"
    # Does not stand against GO.
    WARN = "warn"
    # Counts as failed.
    UNKNOWN = "unknown"


RESULT_WORDS = {
    CheckResult.PASS: marked("passed"),
    CheckResult.FAIL: marked("FAILED"),
    CheckResult.WARN: marked("warning"),
    CheckResult.UNKNOWN: marked("UNKNOWN"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Person:
    """What a person enters for a check. `module` is None where it has no name."""

    who: str = ""
    module: str | None = None
    aircraft: str = ""
    # The trigger records on the module have been reviewed or, where it is silent to the query, it is new.
    are_records_reviewed: bool = False
    # Said by the person although boot count or records speak against it.
    is_same_module: bool = False
    # Approved by the person although they are not those of the last check that passed, or none did.
    are_settings_approved: bool = False
    # `module` is that of --module; else a person said it in this conversation.
    is_named_by_option: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Input of the checks. `profile`: what is expected, with a person's answers for its manual checks."""

    evidence: Evidence
    profile: Profile
    past: Past
    person: Person = Person()

    @property
    def settings_code(self) -> str | None:
        """None where not all settings that it covers are known."""
        return fingerprint(self.evidence.values)

    def unread(self, key: str, limit: UserMessage) -> "Finding":
        """What the check is about may well be in order."""
        why = self.evidence.faults.get(key)
        if why is None and self.evidence.void is not None:
            why = self.evidence.void.message
        do = CHECK_AGAIN if self.evidence.void == CANCELLED else CHECK_LINK
        return unknown(why or message(marked("not asked")), limit, do=do)


class Finding(NamedTuple):
    """`measured`: for programs, in the unit of `shown`, None if unknown. `do`: what to do, None: the check's own."""

    result: CheckResult
    measured: Value | str | None
    shown: UserMessage
    limit: UserMessage
    do: UserMessage | None = None


class Check(NamedTuple):
    """`id` is the one in the JSON output; texts are English, translatable."""

    id: str
    title: str
    judge: Callable[[Case], Finding]
    why: str
    do: str


def unknown(why: UserMessage, limit: UserMessage, *, do: UserMessage | None = None) -> Finding:
    return Finding(CheckResult.UNKNOWN, None, why, limit, do)


def judged(measured: Value | str, shown: str | UserMessage, limit: UserMessage, *, is_fine: bool) -> Finding:
    text = shown if isinstance(shown, UserMessage) else UserMessage(shown)
    return Finding(CheckResult.PASS if is_fine else CheckResult.FAIL, measured, text, limit)


YES = message(marked("yes"))
CHECK_AGAIN = message(marked("Check again."))
CHECK_LINK = message(marked("Check cable and power."))
