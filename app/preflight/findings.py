"""A check: its entry, its input, and its result with measurement and limit."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from app.limits.expectations import Expectations, Fingerprint, Past
from app.preflight.evidence import Evidence
from app.text.messages import UserMessage, message
from protocol.fields import Value
from protocol.translatable import marked


class CheckResult(Enum):
    """The value is the word in the JSON output."""

    PASS = "pass"  # noqa: S105  no password
    FAIL = "fail"
    WARN = "warn"
    """Does not stand against GO."""
    UNKNOWN = "unknown"
    """Counts as failed."""


RESULT_WORDS = {
    CheckResult.PASS: marked("pass"),
    CheckResult.FAIL: marked("FAIL"),
    CheckResult.WARN: marked("warning"),
    CheckResult.UNKNOWN: marked("UNKNOWN"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Input of the checks. The last four are a person's statements."""

    evidence: Evidence
    expectations: Expectations
    past: Past
    fingerprint: Fingerprint | None = None
    are_records_reviewed: bool = False
    is_same_module: bool = False
    are_settings_approved: bool = False
    is_named_by_option: bool = False

    def fault(self, key: str) -> UserMessage:
        """Why a value is not known."""
        why = self.evidence.faults.get(key)
        if why is None and self.evidence.disturbance is not None:
            why = message(self.evidence.disturbance.value)
        return why or message(marked("not asked"))


@dataclass(frozen=True, slots=True)
class Finding:
    """`measured`: for programs, in the unit of `shown`, None if unknown. `do`: what to do, None: the check's own."""

    result: CheckResult
    measured: Value | str | None
    shown: UserMessage
    limit: UserMessage
    do: UserMessage | None = None


@dataclass(frozen=True, slots=True)
class Check:
    """`id` is the one in the JSON output; texts are English, translatable."""

    id: str
    title: str
    judge: Callable[[Case], Finding]
    why: str
    do: str


def unknown(why: UserMessage, limit: UserMessage, *, do: UserMessage | None = None) -> Finding:
    return Finding(CheckResult.UNKNOWN, None, message(marked("unknown: {why}"), why=why), limit, do)


def judged(measured: Value | str, shown: str | UserMessage, limit: UserMessage, *, is_fine: bool) -> Finding:
    text = shown if isinstance(shown, UserMessage) else UserMessage(shown)
    return Finding(CheckResult.PASS if is_fine else CheckResult.FAIL, measured, text, limit)


YES = message(marked("yes"))
NO = message(marked("no"))
