"""Hands, faults and accidents in any order on a `Desk`, and what must hold after every step.

No dangerous frame without its whole gesture, never two for one, nothing sent again; nothing armed after a loss or a
restart; and what the window shows never claims more than the module holds.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from app.guided.catalogue import GUIDED_TESTS, GuidedTest, measure, prepare
from app.guided.status_watch import GuidedSetup, PersonSteps
from app.safety.acts import Act
from app.safety.ritual import DISARMING, Input, Stage
from app.settings.form import SettingsForm
from app.settings.profile_file import parse_profile, profile_text
from app.settings.profiles import Profile, compare
from protocol.catalogue import BAUD_RATES
from protocol.link_states import Presence
from tests.scenarios.desk import Desk
from tests.scenarios.desk_draws import ACTS, CLICKS, DIALECTS, FAULTS, FORGETFUL, RAWS, SHORT_S, THEN
from tests.scenarios.desk_judge import KEYS, Judge, value_of


class DeskMachine(RuleBasedStateMachine):
    """The steps of a session; none corrupts bytes, because an 8-bit sum misses some of them."""

    steps: ClassVar[int] = 0
    """Count of the steps of all machines."""

    @initialize(quirks=DIALECTS, is_watching=st.booleans(), wait_s=st.sampled_from([0.0, 3.0]))
    def sit_down(self, quirks: dict[str, Any], is_watching: bool, wait_s: float) -> None:
        self.desk = Desk(quirks, is_watching=is_watching)
        self.judge = Judge(self.desk)
        self.desk.connect()
        self.desk.read_all()
        self.desk.wait(wait_s)

    # Hands on the settings

    @rule(raws=RAWS, wait_s=SHORT_S)
    def edit(self, raws: dict[str, int], wait_s: float) -> None:
        for key, raw in raws.items():
            self.desk.edit(partial(self.desk.form.choose, key, value_of(KEYS[key], raw)))
        self.desk.wait(wait_s)

    @rule(key=st.sampled_from(sorted(KEYS)[:4]), raw=st.sampled_from([6, 60, 255]))
    def type_value(self, key: str, raw: int) -> None:
        self.desk.edit(lambda: self.desk.form.choose(key, value_of(KEYS[key], raw), is_typing=True))

    @rule(change=st.sampled_from([SettingsForm.undo, SettingsForm.redo, SettingsForm.revert,
                                  SettingsForm.fill_defaults, SettingsForm.end_typing]))  # fmt: skip
    def change_mind(self, change: Callable[[SettingsForm], None]) -> None:
        self.desk.edit(lambda: change(self.desk.form))

    @rule(clicks=CLICKS, is_unlocked=st.booleans(), wait_s=st.sampled_from([0.0, 0.05, 1.0, 8.0]))
    def write(self, clicks: int, is_unlocked: bool, wait_s: float) -> None:
        for _ in range(clicks):
            self.desk.write(is_unlocked=is_unlocked)
        self.desk.wait(wait_s)

    @rule(raws=RAWS, wait_s=st.sampled_from([0.05, 8.0]))
    def load_profile(self, raws: dict[str, int], wait_s: float) -> None:
        profile = Profile(name="P", settings={key: value_of(KEYS[key], raw) for key, raw in raws.items()})
        assert parse_profile(profile_text(profile).encode()) == profile
        rows = compare(profile, self.desk.view, self.desk.clock())
        ticked = {row.command.key: row.wanted for row in rows if row.is_worth_applying and row.wanted is not None}
        self.desk.edit(lambda: self.desk.form.fill(ticked))
        self.desk.write()
        self.desk.wait(wait_s)

    @rule()
    def want_as_found(self) -> None:
        found = self.desk.found
        if found is not None:
            self.desk.edit(lambda: self.desk.form.fill(found.settings))

    @rule(raws=RAWS, faults=FAULTS)
    def write_in_trouble(self, raws: dict[str, int], faults: dict[str, Any]) -> None:
        self._bring_in_order(is_active=False)
        self.edit(raws, 0.02)
        self.fault(faults)
        self.desk.write()
        self.desk.wait(6.0)

    @rule(raws=RAWS, forgets=st.booleans())
    def watch_a_power_cycle(self, raws: dict[str, int], forgets: bool) -> None:
        self.load_profile(raws, 5.0)
        self.desk.check_survival()
        self.desk.wait(1.5)
        self.restart(forgets, 4.0)

    @rule(what=st.sampled_from(["read_all", "check_survival", "cancel"]), wait_s=st.sampled_from([0.02, 3.0]))
    def work(self, what: str, wait_s: float) -> None:
        getattr(self.desk, what)()
        self.desk.wait(wait_s)

    # Hands on the commands

    @rule(act=st.sampled_from(ACTS), clicks=CLICKS, pause_s=st.sampled_from([0.1, 0.1, 11.0]), wait_s=SHORT_S)
    def confirm(self, act: Act, clicks: int, pause_s: float, wait_s: float) -> None:
        self.desk.ask(act)
        self.desk.wait(pause_s)
        for _ in range(clicks):
            self.desk.go(act)
        self.desk.wait(wait_s)

    @rule(act=st.sampled_from(ACTS), is_busy=st.booleans(), wait_s=st.sampled_from([0.0, 0.02, 0.1]), then=THEN)
    def confirm_in_order(self, act: Act, is_busy: bool, wait_s: float, then: str) -> None:
        """Give an order, perhaps behind a long read on a slow line, so that it expires."""
        self._bring_in_order(is_active=False)
        if is_busy:
            self.fault({"delay_ms": 900.0})
            self.desk.read_all()
        self.desk.ask(act)
        self.desk.go(act)
        self.desk.wait(wait_s)
        self._follow(then)

    @rule(rate=st.sampled_from(BAUD_RATES), wait_s=st.sampled_from([0.05, 15.0]))
    def change_rate(self, rate: int, wait_s: float) -> None:
        self.judge.truth.miss(self.desk.clock())
        self.desk.ask(Act.CHANGE_BAUD)
        self.desk.go(Act.CHANGE_BAUD, baud_rate=rate)
        self.desk.wait(wait_s)

    @rule(data=st.data(), act=st.sampled_from([*ACTS, Act.DEPLOY]))
    def order_again(self, data: st.DataObject, act: Act) -> None:
        """Use a permit twice, late, or not at all, as only a faulty window would."""
        permit = data.draw(st.sampled_from([None, *self.desk.permits[-3:]]))
        self.desk.hand_in(permit, act=None if permit is not None and permit.act is not Act.DEPLOY else act)
        self.desk.wait(0.1)

    @rule(wait_s=SHORT_S)
    def lock(self, wait_s: float) -> None:
        self.desk.lock()
        self.desk.wait(wait_s)

    # Hands on a guided test

    @rule(
        test=st.sampled_from(GUIDED_TESTS),
        is_confirmed=st.booleans(),
        presses=st.integers(0, 3),
        tilt_deg=st.sampled_from([0.0, 5.0, 90.0]),
        wait_s=st.sampled_from([0.1, 2.0]),
        then=THEN,
    )
    def guide(
        self, test: GuidedTest, is_confirmed: bool, presses: int, tilt_deg: float, wait_s: float, then: str
    ) -> None:
        """Run a guided test; its acts are confirmed, and the module is locked afterwards by whoever activated it."""
        self._bring_in_order(is_active=False)
        desk, steps = self.desk, PersonSteps()
        desk.guide(prepare(test))
        desk.wait(1.0)
        setup = desk.guided
        if test.is_active and is_confirmed:
            desk.ask(Act.ACTIVATE)
            desk.go(Act.ACTIVATE)
            desk.wait(1.0)
        if isinstance(setup, GuidedSetup):
            desk.guide(measure(test, setup, steps))
        desk.bench.set_tilt(tilt_deg)
        for _ in range(presses):
            desk.wait(0.5)
            steps.confirm()
        desk.wait(wait_s)
        if desk.permits:
            self._follow(then)
        desk.cancel()
        desk.bench.set_tilt(0.0)
        if test.is_active:
            desk.lock()
            desk.wait(1.0)

    # Hands on the ritual

    @rule(is_rehearsal=st.sampled_from([False, False, True]))
    def choose(self, is_rehearsal: bool) -> None:
        self.desk.choose(is_rehearsal=is_rehearsal)

    @rule()
    def arm(self) -> None:
        self.desk.arm()

    @rule(kind=st.sampled_from(["single", "repeat", "double"]), seconds=st.sampled_from([0.02, 1.0, 1.9, 2.2, 11.0]))
    def press(self, kind: str, seconds: float) -> None:
        self.desk.press(kind)
        self.desk.wait(seconds)

    @rule(
        is_rehearsal=st.sampled_from([False, False, True]),
        kind=st.sampled_from(["single", "single", "single", "repeat", "double"]),
        seconds=st.sampled_from([0.5, 1.9, 2.02, 2.2, 2.2, 5.0]),
        then=THEN,
    )
    def go_through_the_ritual(self, is_rehearsal: bool, kind: str, seconds: float, then: str) -> None:
        self._bring_in_order(is_active=True)
        self.desk.choose(is_rehearsal=is_rehearsal)
        self.desk.arm()
        self.desk.wait(0.3)
        self.desk.press(kind)
        self.desk.wait(seconds)
        if self.desk.permits:
            self._follow(then)

    @precondition(lambda self: self.desk.ritual.stage is Stage.HOLDING)
    @rule()
    def release(self) -> None:
        self.desk.release()

    @rule(why=st.sampled_from(DISARMING))
    def leave_the_ritual(self, why: Input) -> None:
        self.desk.disarm(why)

    # What happens to them

    @rule(faults=FAULTS)
    def fault(self, faults: dict[str, Any]) -> None:
        self.judge.truth.disturb(self.desk.clock())
        self.desk.bench.end_faults()
        self.desk.bench.change(**faults)

    @rule(seconds=st.sampled_from([0.0, 5.0]))
    def repair_line(self, seconds: float) -> None:
        self.desk.bench.end_faults()
        self.judge.truth.calm(self.desk.clock())
        self.desk.wait(seconds)

    @rule(seconds=st.sampled_from([0.02, 0.3, 3.0, 12.0]))
    def wait(self, seconds: float) -> None:
        self.desk.wait(seconds)

    @rule(seconds=st.sampled_from([0.3, 2.5]), is_let_go=st.booleans())
    def hang(self, seconds: float, is_let_go: bool) -> None:
        self.desk.hang(seconds, is_let_go=is_let_go)

    @rule(forgets=st.booleans(), wait_s=st.sampled_from([0.0, 0.1, 2.0]))
    def restart(self, forgets: bool, wait_s: float) -> None:
        bench = self.desk.bench
        bench.restart()
        for name, raw in FORGETFUL.items() if forgets else ():
            setattr(bench.module.memory, name, raw)
        self.judge.restarted()
        self.desk.wait(wait_s)

    @rule(wait_s=st.sampled_from([0.0, 0.1, 2.0]))
    def unplug(self, wait_s: float) -> None:
        self.desk.bench.unplug()
        self.desk.wait(wait_s)

    @rule(is_pulled=st.sampled_from([False, False, True]), wait_s=st.sampled_from([0.05, 3.0]))
    def open_port(self, is_pulled: bool, wait_s: float) -> None:
        """Plug it in, connect and read; earlier requests must not be sent."""
        if is_pulled:
            self.desk.bench.unplug()
            self.desk.turn()
        self.desk.bench.plug()
        self.desk.connect()
        self.desk.read_all()
        self.desk.wait(wait_s)

    @rule()
    def close_port(self) -> None:
        self.desk.disconnect()

    @rule(quirks=DIALECTS)
    def change_module(self, quirks: dict[str, Any]) -> None:
        self.desk.replace_module(quirks)
        self.judge = Judge(self.desk)
        self.desk.connect()

    def _bring_in_order(self, *, is_active: bool) -> None:
        """Reach a state that is rare at random: no fault, connected, idle, and all values known."""
        desk, bench = self.desk, self.desk.bench
        if not bench.module.is_on:
            bench.press_switch()
            self.judge.restarted()
        bench.end_faults()
        self.judge.truth.calm(desk.clock())
        desk.disarm(Input.CANCEL)
        desk.cancel()
        bench.plug()
        desk.find()
        for is_so in (False, is_active):  # locked once, it is triggered no more
            bench.module.activate(is_active=is_so)
        self.judge.somebody_activated()
        desk.read_all()
        for _ in range(200):
            if not desk.is_busy and desk.view.presence is Presence.ONLINE:
                break
            desk.turn()

    def _follow(self, then: str) -> None:
        """Make an order be followed at once by another event."""
        match then:
            case "again":
                self.desk.hand_in(self.desk.permits[-1])
            case "lock":
                self.desk.lock()
            case "unplug":
                self.open_port(is_pulled=True, wait_s=0.05)
            case "restart":
                self.restart(forgets=False, wait_s=0.0)
            case "silence":
                self.fault({"drop": 1.0, "direction": "to-host"})
            case _:
                pass
        self.desk.wait(3.0)

    # What holds

    @invariant()
    def all_holds(self) -> None:
        DeskMachine.steps += 1
        assert not self.desk.ledger.complaints, self.desk.ledger.complaints
        self._nothing_stays_armed()
        self.judge.rows()

    def _nothing_stays_armed(self) -> None:
        desk = self.desk
        if not desk.is_open or desk.view.presence is Presence.OFFLINE or desk.has_restarted_since_choosing:
            assert not desk.ritual.is_armed or desk.ritual.is_rehearsal
            assert desk.armed.act is None or desk.ritual.is_rehearsal
