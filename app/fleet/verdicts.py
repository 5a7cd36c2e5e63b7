"""Last pre-flight check of each connected module, and whether it still holds."""

from collections.abc import Hashable
from dataclasses import dataclass

from app.engine.device import DeviceView
from app.preflight.evidence import Disturbance
from app.preflight.reread import TITLES
from app.preflight.verdict import Verdict, Void, void_reason
from app.records.filing import Filed
from app.text.messages import UserMessage


@dataclass(frozen=True, slots=True)
class HeldVerdict:
    """`verdict` None: the check is void, `void` says why. `at`: when it ended, in monotonic seconds;
    None for one that broke off."""

    verdict: Verdict | None
    at: float | None
    void: Void | None = None
    against: tuple[UserMessage, ...] = ()
    """Titles of what stands against it."""


class Verdicts:
    """By connection (`whose`). A void check stays void until the next one."""

    def __init__(self) -> None:
        self._filed: dict[Hashable, Filed] = {}
        self._void: dict[Hashable, Void] = {}

    def store(self, whose: Hashable, filed: Filed, void: Void | None = None) -> None:
        """Keep the module's last check; `void`: why it does not hold."""
        self._filed[whose] = filed
        self._void.pop(whose, None)
        if void is not None:
            self._void[whose] = void

    def remove(self, whose: Hashable) -> None:
        self._filed.pop(whose, None)
        self._void.pop(whose, None)

    def filed(self, whose: Hashable) -> Filed | None:
        return self._filed.get(whose)

    def poll(self, whose: Hashable, device: DeviceView, now: float, *, is_open: bool) -> None:
        """Call it at every report of the module and every change of its port."""
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

    def held(self, whose: Hashable, device: DeviceView, now: float, *, is_open: bool) -> HeldVerdict | None:
        """The verdict at `now`: GO only while the module reports ACTIVE. None without a check."""
        self.poll(whose, device, now, is_open=is_open)
        filed = self._filed.get(whose)
        if filed is None:
            return None
        evidence, void = filed.assessment.case.evidence, self._void.get(whose)
        if void is not None:
            return HeldVerdict(None, evidence.ended_at, void)
        verdict = filed.assessment.verdict
        if verdict is Verdict.GO and device.fresh("active", now) is not True:
            verdict = Verdict.READY
        return HeldVerdict(verdict, evidence.ended_at, None, filed.assessment.titles_against)
