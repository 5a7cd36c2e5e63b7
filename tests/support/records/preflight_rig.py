"""Runs pre-flight checks on the simulated module with a fake clock, and lists the single faults."""

import itertools
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from app.limits.past import Past
from app.modules.names import Remembered
from app.preflight.checks import Case, Person
from app.preflight.evidence import Evidence
from app.preflight.run import run_preflight
from app.preflight.verdict import Assessment, assess
from app.records.record import Record, make_record
from app.settings.profiles import ManualLine, Profile
from app.text.messages import UserError
from protocol.catalogue import HEARTBEAT_CODE, STATUS_CODE, Hazard, Request
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame, at_frame, lose
from tests.support.line.sim_line import AnyRig, Rig

APPROVED = "OPQ7-5ZRY"
FORBIDDEN = {0x10, 0x11, 0x12, 0x13, 0x24, 0x25}
Arrange = Callable[[Rig], object]


@dataclass(frozen=True, slots=True)
class Checked:
    rig: Rig
    assessment: Assessment

    @property
    def against(self) -> set[str]:
        manual = self.assessment.case.profile.manual
        return set(self.assessment.open_checks) | {"manual" for item in manual if item.is_done is False}

    def record(self, about: dict[str, Any], **person: Any) -> Record:
        """As checked by this person. `about`: further arguments of `make_record`."""
        case = replace(self.assessment.case, person=Person(**person))
        return make_record(self.assessment._replace(case=case), **about)


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault; the checks in `named` must fail because of it."""

    named: frozenset[str] = frozenset()
    options: Mapping[str, object] = field(default_factory=dict)
    arrange: Arrange | None = None
    profile: Mapping[str, Any] = field(default_factory=dict)
    past: Mapping[str, Any] = field(default_factory=dict)
    is_enabling: bool = True


def check(*faults: Fault, is_enabling: bool = True) -> Checked:
    """Run and judge a check of a module with these faults."""
    options: dict[str, object] = {}
    for fault in faults:
        options |= fault.options
    rig = Rig(options)
    rig.step_for(1.5)
    for fault in faults:
        if fault.arrange is not None:
            fault.arrange(rig)
    return judged(rig, gather(rig, is_enabling=is_enabling and all(fault.is_enabling for fault in faults)), *faults)


def gather(rig: AnyRig, *, is_enabling: bool = False) -> Evidence:
    """Run a check; one that is interrupted, or that nobody answers, is void."""
    evidence = Evidence(port="sim")
    job = rig.job(run_preflight(evidence, is_enabling=is_enabling, journal=FakeJournal()))
    rig.step_until(lambda: job.has_ended)
    if job.error is not None:
        assert isinstance(job.error, UserError)
        evidence.note_error(job.error)
    return evidence


def judged(rig: Rig, evidence: Evidence, *faults: Fault) -> Checked:
    """Judge the evidence by the expectations of these faults."""
    profile: dict[str, Any] = {"approved_fingerprint": APPROVED, "settings": {"light_threshold_v": 1.8}}
    past: dict[str, Any] = {"module": "M-07", "remembered": Remembered("M-07", boot_count=36), "has_check": True}
    for fault in faults:
        profile |= fault.profile
        past |= fault.past
    case = Case(evidence=evidence, profile=Profile(**profile), past=Past(**past))
    return Checked(rig, assess(case))


def assert_only_questions(checked: Checked, *, is_enabling: bool = True) -> None:
    """Assert that the host sent only queries, and enabled each of the two triggers at most once."""
    sets = Counter(request for request in checked.rig.line.requests if request.hazard is not Hazard.NONE)
    for request, count in sets.items():
        assert is_enabling
        assert request.command.code in (0x16, 0x17)
        assert request.data == 0x00
        assert count == 1
    assert not FORBIDDEN & {request.command.code for request in checked.rig.line.requests}


def on_request(code: int, number: int, act: Callable[[Rig], object], *, is_lost: bool = False) -> Arrange:
    """Call `act` at the `number`-th frame of this code; with `is_lost` the frame is dropped."""
    return lambda rig: at_frame(rig.bench, number, lambda: act(rig), code=code, is_lost=is_lost)


def loses(*codes: int) -> Arrange:
    """It neither answers nor carries out what has these codes."""
    return lambda rig: lose(rig.bench, *codes)


def _memory(**values: int) -> Arrange:
    def arrange(rig: Rig) -> None:
        for name, value in values.items():
            setattr(rig.bench.module.memory, name, value)

    return arrange


def _fire(rig: Rig) -> None:
    assert rig.bench.pulse_pwm()


def _wobble(rig: Rig) -> None:
    """Tilt by 4° to and fro, from one status to the next."""
    ways = itertools.cycle((4.0, -4.0))

    def wobble(request: Request) -> None:
        if request.command.code == STATUS_CODE:
            rig.bench.world.tilt_deg += next(ways)

    at_each_frame(rig.bench, wobble)


def _switch_activation(rig: Rig) -> None:
    rig.bench.module.activate(is_active=not rig.bench.module.state.is_active)


def _names(*names: str) -> frozenset[str]:
    return frozenset(names)


_STATUS = _names("read_twice", "triggered", "activation", "tilt", "tilt_spread", "acceleration", "acceleration_spread")
_FLAGS = _names("attitude_trigger", "freefall_trigger")

FAULTS: Mapping[str, Fault] = {
    "a heartbeat lost": Fault(
        _names("link_loss"), arrange=on_request(HEARTBEAT_CODE, 7, lambda rig: None, is_lost=True)
    ),
    "damaged bytes": Fault(_names("link_loss"), {"corrupt": 0.02}),
    "slow": Fault(_names("round_trip"), {"lag_ms": 120.0}),
    "no status": Fault(_STATUS, arrange=loses(STATUS_CODE)),
    "fired": Fault(_names("triggered") | _FLAGS, {"active": True}, _fire),
    "active, triggers not known": Fault(_FLAGS, {"active": True}),
    "activation switched": Fault(_names("activation"), arrange=on_request(STATUS_CODE, 6, _switch_activation)),
    "tilted": Fault(_names("tilt"), {"tilt": 20.0}),
    "wobbling": Fault(_names("tilt_spread"), arrange=_wobble),
    "charging": Fault(_names("charging", "cell_voltage"), {"charger": True}),
    "bay open": Fault(_names("light"), {"bay_open": True}),
    "attitude threshold": Fault(_names("attitude_threshold", "fingerprint"), arrange=_memory(attitude_threshold=40)),
    "triggers not set": Fault(_FLAGS, is_enabling=False),
    "free-fall trigger mute": Fault(_names("freefall_trigger"), arrange=loses(0x17)),
    "new records": Fault(_names("trigger_records"), {"history": 3}),
    "no boot count": Fault(_names("connection", "boot_count"), arrange=loses(0x23)),
    "no settings": Fault(_names("attitude_threshold", "freefall_time", "fingerprint"), arrange=loses(0x20, 0x22)),
    "restarted": Fault(_names("connection"), arrange=on_request(STATUS_CODE, 6, lambda rig: rig.bench.restart())),
    # Nothing of the module.
    "another module": Fault(_names("boot_count"), past={"remembered": Remembered("M-07", boot_count=100)}),
    "canopy torn": Fault(_names("manual"), profile={"manual": (ManualLine("Canopy", is_done=False),)}),
}
