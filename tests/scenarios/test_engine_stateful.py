"""Ritual, procedures, session and simulated module together, in any order of gestures, faults and accidents.

Always: no dangerous frame without its permit, never two for one, never one without an intent in the log; "verified" is
what the module holds; what the device calls known is what the module holds.
"""

from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from app.engine.device import How
from app.procedures.act import Armed, perform
from app.procedures.baud import BaudEnd, change_baud
from app.procedures.lock import lock
from app.procedures.write_all import Leave, SettingChange, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from app.safety.ritual import DISARMING, Input, Ritual, Stage
from protocol.catalogue import BAUD_RATE, BAUD_RATES, BY_NAME, Hazard, Request
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig

READABLE = ("light_threshold", "attitude_threshold", "freefall_acceleration", "freefall_time")
FLAGS = {"attitude_trigger": "attitude_is_enabled", "freefall_trigger": "freefall_is_enabled"}
DIALECTS = st.fixed_dictionaries(
    {
        "ack": st.sampled_from(["echo", "one"]),
        "freefall_ack": st.sampled_from(["16", "17"]),
        "baud_ack": st.sampled_from(["old", "new", "restart"]),
        "clamps": st.booleans(),
        "refuses": st.sampled_from([False, False, True]),
        "seed": st.integers(0, 10_000),
        "uptime": st.sampled_from([0, 60]),
    }
)
FAULTS = st.fixed_dictionaries(
    {},
    optional={
        "drop": st.sampled_from([0.1, 0.4, 1.0]),
        "double": st.sampled_from([0.3, 1.0]),
        "delay_ms": st.sampled_from([30.0, 250.0, 1300.0]),
        "jitter_ms": st.sampled_from([50.0, 500.0]),
        "direction": st.sampled_from(["to-host", "to-module", "both"]),
        "mute": st.booleans(),
    },
)
ACTS = st.sampled_from([Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY, Act.DEPLOY])


class Engine(RuleBasedStateMachine):
    """Nothing here corrupts bytes: what an 8-bit sum lets pass is another test's."""

    @initialize(quirks=DIALECTS)
    def connect(self, quirks: dict[str, Any]) -> None:
        self.rig = Rig(quirks)
        self.journal = FakeJournal()
        self.armed = Armed()
        self.ritual = Ritual()
        self.permits: list[Permit] = []
        self.seen = 0
        self.flags_are_known = True

    # What a person does

    @rule(name=st.sampled_from([*READABLE, *FLAGS]), raw=st.integers(0, 255), is_unlocked=st.booleans())
    def write(self, name: str, raw: int, is_unlocked: bool) -> None:
        self._write([(name, raw)], is_unlocked=is_unlocked)

    @rule(raws=st.dictionaries(st.sampled_from([*READABLE, *FLAGS]), st.integers(0, 255), min_size=2))
    def apply_profile(self, raws: dict[str, int]) -> None:
        self._write(list(raws.items()), is_unlocked=False)

    def _write(self, wanted: list[tuple[str, int]], *, is_unlocked: bool) -> None:
        changes = []
        for name, raw in wanted:
            field = BY_NAME[name].write
            assert field is not None
            changes.append(SettingChange(BY_NAME[name], field.decode(raw if name in READABLE else raw & 1)))
        was_active = self.rig.bench.module.state.is_active
        before = len(self._sets())
        report = self.rig.run(
            write_all(changes, Leave(journal=self.journal, armed=self.armed, is_unlocked=is_unlocked))
        )
        for written in report.results:
            if written.verified:
                assert written.command.write is not None
                assert getattr(self.rig.bench.module.memory, written.command.name) == written.command.write.encode(
                    written.wanted
                )
        if (was_active and not is_unlocked) or self.armed.act is not None:
            assert len(self._sets()) == before

    @rule(rate=st.sampled_from(BAUD_RATES), is_confirmed=st.booleans())
    def change_rate(self, rate: int, is_confirmed: bool) -> None:
        permit = self._permit(Act.CHANGE_BAUD, Origin.CONFIRMATION) if is_confirmed else None
        changed = self.rig.run(change_baud(rate, self.journal, permit=permit, armed=self.armed))
        if changed.end in (BaudEnd.CHANGED, BaudEnd.AT_RESTART, BaudEnd.UNCHANGED):
            assert self.rig.line.baud_rate == changed.found_rate == self.rig.bench.module.baud_rate

    @rule(act=ACTS, origin=st.sampled_from(Origin), late_s=st.sampled_from([0.0, 0.0, 2.0, 30.0]))
    def confirm(self, act: Act, origin: Origin, late_s: float) -> None:
        if act is Act.DEPLOY and origin is Origin.RITUAL:
            origin = Origin.CONFIRMATION  # a ritual's permit comes from the ritual alone
        permit = self._permit(act, origin)
        self.rig.step_for(late_s)
        self._perform(act, permit)

    @rule(act=ACTS, data=st.data())
    def use_an_old_permit(self, act: Act, data: st.DataObject) -> None:
        permit = data.draw(st.sampled_from([None, *self.permits]))
        self._perform(act, permit)

    @rule()
    def lock(self) -> None:
        locked = self.rig.run(lock(self.journal))
        assert locked.is_locked is not True or not self.rig.bench.module.state.is_active

    def _perform(self, act: Act, permit: Permit | None) -> None:
        done = self.rig.run(perform(act, self.journal, permit=permit, armed=self.armed))
        module = self.rig.bench.module
        if done.outcome is Outcome.CONFIRMED:
            assert {
                Act.ACTIVATE: module.state.is_active,
                Act.ZERO: True,
                Act.SHUTDOWN: not module.is_on,
                Act.FORBID_DEPLOY: module.state.is_forbidden,
                Act.DEPLOY: module.is_triggered,
            }[act]

    @rule(is_rehearsal=st.sampled_from([False, False, True]))
    def choose_and_arm(self, is_rehearsal: bool) -> None:
        self.ritual.choose(is_rehearsal=is_rehearsal)
        self.ritual.arm(self.rig.clock())

    @rule(kind=st.sampled_from(["single", "repeat", "double"]))
    def press(self, kind: str) -> None:
        self.ritual.press(self.rig.clock(), is_auto_repeat=kind == "repeat", is_double_click=kind == "double")

    @rule(seconds=st.sampled_from([0.5, 1.9, 2.2, 2.2, 11.0]))
    def hold(self, seconds: float) -> None:
        end_s = self.rig.clock() + seconds
        while self.rig.clock() < end_s:
            self.rig.step_for(0.05)
            self.armed.act = Act.DEPLOY if self.ritual.is_armed else None
            permit = self.ritual.tick(self.rig.clock())
            if permit is not None:
                self.armed.act = None
                self.permits.append(permit)
                self._perform(Act.DEPLOY, permit)

    @rule(is_rehearsal=st.sampled_from([False, False, True]), seconds=st.sampled_from([1.9, 2.2, 2.2, 5.0]))
    def go_through_the_ritual(self, is_rehearsal: bool, seconds: float) -> None:
        """On an active module, most often: what random gestures hardly ever bring together."""
        self.rig.bench.module.press_switch(self.rig.clock())
        self.rig.bench.module.activate(is_active=True)
        self.ritual.disarm(Input.FINISHED)
        self.ritual.disarm(Input.CANCEL)
        self.choose_and_arm(is_rehearsal)
        self.rig.step_for(0.3)
        self.press("single")
        self.hold(seconds)

    @rule(why=st.sampled_from(DISARMING))
    def disarm(self, why: Input) -> None:
        self.ritual.disarm(why)
        self.armed.act = Act.DEPLOY if self.ritual.is_armed else None

    @precondition(lambda self: self.ritual.stage is Stage.HOLDING)
    @rule()
    def release(self) -> None:
        self.ritual.release()

    # What happens to them

    @rule(faults=FAULTS)
    def fault(self, faults: dict[str, Any]) -> None:
        self.rig.bench.heal()
        self.rig.bench.change(**faults)

    @rule()
    def heal(self) -> None:
        self.rig.bench.heal()
        self.rig.step_for(4.0)

    @rule(seconds=st.sampled_from([0.2, 3.0, 12.0]))
    def wait(self, seconds: float) -> None:
        self.rig.step_for(seconds)

    @rule()
    def restart(self) -> None:
        self.flags_are_known = self.flags_are_known and self.rig.bench.wire.faults.drop == 0
        self.flags_are_known = self.flags_are_known and not self.rig.bench.wire.faults.mute
        # E9: a rate that counts from now on, and the host is not there: its heartbeats are garbage to the host.
        self.flags_are_known = (
            self.flags_are_known and self.rig.bench.module.memory.baud_rate == self.rig.line.baud_rate
        )
        self.rig.bench.restart()
        self.rig.step_for(2.0)

    @rule(is_active=st.booleans())
    def somebody_else_switches(self, is_active: bool) -> None:
        self.rig.bench.module.activate(is_active=is_active)
        self.rig.step_for(1.1)

    # What holds

    def _permit(self, act: Act, origin: Origin) -> Permit:
        permit = Permit(act, origin, self.rig.clock())
        self.permits.append(permit)
        return permit

    def _sets(self) -> list[Request]:
        return [request for request in self.rig.line.requests if request.is_set]

    @invariant()
    def every_dangerous_frame_has_its_permit_and_its_intent(self) -> None:
        sent = [request for request in self.rig.line.requests if request.hazard is Hazard.DANGEROUS]
        for act in (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY, Act.DEPLOY, Act.CHANGE_BAUD):
            if act is Act.CHANGE_BAUD:
                frames = sum(request.command is BAUD_RATE for request in sent)
            else:
                frames = sum(request == REQUESTS[act] for request in sent)
            spent = [permit for permit in self.permits if permit.act is act and permit.is_spent]
            assert frames <= len(spent)
            assert frames <= sum(intent[0] is act for intent in self.journal.intents)
            assert not any(permit.is_rehearsal and permit.is_good(act, self.rig.clock()) for permit in spent)
            if act is Act.DEPLOY:
                assert all(permit.origin is Origin.RITUAL for permit in spent)

    @invariant()
    def what_is_known_is_what_the_module_holds(self) -> None:
        now = self.rig.clock()
        device = self.rig.session.device.view(now)
        for name in READABLE:
            known = device.known(BY_NAME[name].key, now)
            if known is not None and not known.is_stale and known.how is How.READ:
                field = BY_NAME[name].write
                assert field is not None
                assert field.encode(known.value) == getattr(self.rig.bench.module.memory, name)
        for name, attribute in FLAGS.items():
            known = device.known(name, now)
            if self.flags_are_known and known is not None and not known.is_stale:
                assert known.value == getattr(self.rig.bench.module.state, attribute)


Engine.TestCase.settings = settings(
    max_examples=max(15, settings().max_examples // 4), stateful_step_count=25, deadline=None
)
TestEngine = Engine.TestCase
