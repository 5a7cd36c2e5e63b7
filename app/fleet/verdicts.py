"""Last pre-flight check of each connected module, and whether it still holds."""

from collections.abc import Callable
from dataclasses import dataclass

from app.engine.device import DeviceView
from app.preflight.evidence import Disturbance
from app.preflight.reread import TITLES
from app.preflight.verdict import Verdict, Void, void_reason
from app.records.filing import Filed
from app.text.messages import UserMessage


@dataclass(frozen=True, slots=True)
class HeldVerdict:
    """`verdict` None: the check no longer holds, and `void` says why. `at`: monotonic seconds of its end."""

    verdict: Verdict | None
    at: float
    void: Void | None = None
    against: tuple[UserMessage, ...] = ()
    """Titles of the checks that stand against it."""


def titles_against(filed: Filed) -> tuple[UserMessage, ...]:
    """What stands against GO and READY: checks by their title, then items that a person judged."""
    assessment = filed.assessment
    checks = [UserMessage(one.check.title) for one in assessment.checks if one.stands_against]
    return (*checks, *(UserMessage(item.text) for item in assessment.manual if item.is_done is False))


class Verdicts:
    """By the key of the connection (`whose`). A check that was void once stays void until the next one."""

    def __init__(self) -> None:
        self._filed: dict[str, Filed] = {}
        self._void: dict[str, Void] = {}
        self.on_change: Callable[[], object] = bool

    def keep(self, whose: str, filed: Filed) -> None:
        """The check that was filed last."""
        self._filed[whose] = filed
        self._void.pop(whose, None)
        self.on_change()

    def forget(self, whose: str) -> None:
        self._filed.pop(whose, None)
        self._void.pop(whose, None)

    def filed(self, whose: str) -> Filed | None:
        return self._filed.get(whose)

    def poll(self, whose: str, device: DeviceView, now: float, *, is_open: bool) -> None:
        """Ask it whenever the module or its port has said something."""
        filed = self._filed.get(whose)
        if filed is None or whose in self._void:
            return
        evidence = filed.assessment.case.evidence
        void = void_reason(filed.assessment, device, now, opened_at=evidence.opened_at if is_open else None)
        active = device.fresh("active", now)
        if void is None and active is True and evidence.is_active is False:
            void = Void(Disturbance.CHANGED, UserMessage(TITLES["active"]))  # GO needs another reading of everything
        if void is not None:
            self._void[whose] = void

    def held(self, whose: str, device: DeviceView, now: float, *, is_open: bool) -> HeldVerdict | None:
        """The verdict at `now`: GO only while the module reports that it is active. None where nothing was checked."""
        self.poll(whose, device, now, is_open=is_open)
        filed = self._filed.get(whose)
        if filed is None:
            return None
        evidence, void = filed.assessment.case.evidence, self._void.get(whose)
        at = evidence.ended_at if evidence.ended_at is not None else now
        if void is not None:
            return HeldVerdict(None, at, void)
        verdict = filed.assessment.verdict
        if verdict is Verdict.GO and device.fresh("active", now) is not True:
            verdict = Verdict.READY
        return HeldVerdict(verdict, at, None, titles_against(filed))
