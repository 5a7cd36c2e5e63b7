"""The last pre-flight check of a connected module, and whether it still holds."""

from typing import NamedTuple

from app.engine.device import DeviceView
from app.preflight.evidence import Disturbance
from app.preflight.reread import TITLES
from app.preflight.verdict import Verdict, Void, void_reason
from app.records.filing import Filed
from app.text.messages import UserMessage


class HeldVerdict(NamedTuple):
    """`verdict` None: the check is void, `void` says why. `at`: when it ended, in monotonic seconds;
    None for one that broke off."""

    verdict: Verdict | None
    at: float | None
    void: Void | None = None
    against: tuple[UserMessage, ...] = ()
    """Titles of what stands against it."""


class KeptCheck(NamedTuple):
    """A module's last check. `void`: why it does not hold; it stays so until the next one."""

    filed: Filed
    void: Void | None = None

    def polled(self, device: DeviceView, now: float, *, is_open: bool) -> "KeptCheck":
        """Call it at every report of the module and every change of its port."""
        if self.void is not None:
            return self
        evidence = self.filed.assessment.case.evidence
        void = void_reason(self.filed.assessment, device, now, opened_at=evidence.opened_at if is_open else None)
        if void is None and device.fresh("active", now) is True and evidence.is_active is False:
            void = Void(Disturbance.CHANGED, UserMessage(TITLES["active"]))  # GO needs another reading of everything
        return self._replace(void=void)

    def held(self, device: DeviceView, now: float) -> HeldVerdict:
        """The verdict at `now`: GO only while the module reports ACTIVE."""
        assessment = self.filed.assessment
        ended_at, verdict = assessment.case.evidence.ended_at, assessment.verdict
        if self.void is not None:
            return HeldVerdict(None, ended_at, self.void)
        if verdict is Verdict.GO and device.fresh("active", now) is not True:
            verdict = Verdict.READY
        return HeldVerdict(verdict, ended_at, None, assessment.titles_against)
