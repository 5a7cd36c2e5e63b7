"""A window without pixels on a simulated module: form, ritual, questions, session and line, in one thread on one clock.

It does with the program's parts what the Settings and the Commands page do, one small step of time after the other,
so that hands, faults and accidents fall into the middle of what is under way. `tests.scenarios.desk_ledger` watches.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

from app.engine.procedure import Procedure
from app.engine.session import Run
from app.engine.snapshots import Snapshot
from app.procedures.act import Armed, Performed, perform, rehearse
from app.procedures.baud import change_baud
from app.procedures.lock import Locked, lock
from app.procedures.power_cycle import PowerCycleResult, survives_power_cycle
from app.procedures.read import read_everything
from app.procedures.write import Written
from app.procedures.write_all import WriteContext, WriteReport, unconfirmed, write_all
from app.safety.acts import Act
from app.safety.interlocks import Interlock, interlock_inputs, refusals
from app.safety.permit import Origin, Permit
from app.safety.ritual import Input, Ritual, Stage
from app.settings.form import FormRow, SettingsForm
from protocol.catalogue import Command
from protocol.link_states import Presence
from tests.scenarios.desk_ledger import Hands
from tests.scenarios.desk_port import DeskPort, LedgerJournal

ASKS_FOR_S: Final = 10.0


class Desk(DeskPort):
    """See the module's docstring; the `on_…` callbacks are called when a claim is made."""

    def __init__(self, options: Mapping[str, Any], *, is_watching: bool) -> None:
        self.hands = Hands()
        self.armed = Armed()
        self.ritual = Ritual()
        self.form = SettingsForm()
        self.found: Snapshot | None = None
        self.permits: list[Permit] = []
        self.on_write: Callable[[WriteReport], None] = lambda _report: None
        self.on_perform: Callable[[Performed], None] = lambda _done: None
        self.on_survive: Callable[[PowerCycleResult], None] = lambda _survival: None
        self.on_lock: Callable[[Locked], None] = lambda _locked: None
        self._settings_job: Run[Any] | None = None
        self.guided: Any = None
        self._asked_at: dict[Act, float] = {}
        self._restarts, self._was_online = 0, False
        super().__init__(options, is_watching=is_watching)
        self.journal = LedgerJournal(self.ledger)

    def replace_module(self, options: Mapping[str, Any]) -> None:
        super().replace_module(options)
        self.form.reset()
        self.found = None

    def hang(self, seconds: float, *, is_let_go: bool) -> None:
        """Block the window, but not the thread of the port; a release is handled only afterwards."""
        end_s = self.clock() + seconds
        while self.clock() < end_s:
            self.step()
        if is_let_go:
            self.release()
        self.turn()

    def turn(self) -> None:
        super().turn()
        now = self.clock()
        if self.hands.take_full(now):
            self.ledger.gesture(Act.DEPLOY, now)
        permit = self.ritual.tick(now)
        if permit is not None:
            self._fire(permit)
        self._follow()

    # Settings

    def rows(self) -> tuple[FormRow, ...]:
        return self.form.rows(self.view, self.clock())

    @property
    def is_busy(self) -> bool:
        """Return whether the Settings page is busy; it does one thing at a time."""
        return self._settings_job is not None and not self._settings_job.is_done

    def edit(self, act: Callable[[], object]) -> None:
        if not self.form.is_writing:
            act()

    def read_all(self) -> None:
        if self.is_open and not self.is_busy:
            self._settings_job = self.run(read_everything(), lambda _run: None)

    def write(self, *, is_unlocked: bool = False) -> None:
        """Click Write, after any warning."""
        changes = self.form.changes(self.view, self.clock())
        if not changes or not self.is_open or self.is_busy:
            return
        now_is = interlock_inputs(
            self.view, self.clock(), must_be_proven=False, armed=self.armed.act, is_unlocked=is_unlocked
        )
        if any(one.condition is not Interlock.MAY_WRITE or now_is.active for one in refusals(Act.WRITE, now_is)):
            return
        heard: list[Written] = []
        begun: list[Command] = []
        leave = WriteContext(
            journal=self.journal, armed=self.armed, is_unlocked=is_unlocked, accepted_risks=frozenset(changes),
            store_snapshot=self._keep if self.found is None else None, on_written=heard.append, on_begun=begun.append,
        )  # fmt: skip
        self.form.begin_write(changes)
        self._settings_job = self.run(write_all(changes, leave), partial(self._end_writing, heard, begun))
        self.ledger.allow(id(self._settings_job), [change.command.set(change.value) for change in changes])

    def _keep(self, snapshot: Snapshot) -> None:
        self.found = snapshot

    def _end_writing(self, heard: list[Written], begun: list[Command], run: Run[WriteReport]) -> None:
        if run.error is not None or run.result is None:
            self.form.abort_write(unconfirmed(heard), begun)
            return
        self.on_write(run.result)
        self.form.on_written(run.result.results)

    def check_survival(self) -> None:
        if self.is_open and not self.is_busy and self.form.written:
            job = survives_power_cycle(dict(self.form.written), longest_wait_s=20.0)
            self._settings_job = self.run(job, self._end_survival)

    def _end_survival(self, run: Run[PowerCycleResult]) -> None:
        if run.result is not None:
            self.on_survive(run.result)
            self.form.set_retentions(run.result.stamps)

    def cancel(self) -> None:
        if self._settings_job is not None:
            self._settings_job.cancel()

    # Guided tests

    def guide(self, procedure: Procedure[Any]) -> None:
        """Run a part of a guided test; the result is in `guided`."""
        self.guided = None
        if self.is_open and not self.is_busy:
            self._settings_job = self.run(procedure, self._end_guided)

    def _end_guided(self, run: Run[Any]) -> None:
        self.guided = run.result

    # Commands

    def ask(self, act: Act) -> None:
        self._asked_at[act] = self.clock()

    def go(self, act: Act, *, baud_rate: int = 115200) -> None:
        """Confirm; a click without a question, or too late, has no effect."""
        now = self.clock()
        if now - self._asked_at.pop(act, now - ASKS_FOR_S) >= ASKS_FOR_S:
            return
        self.ledger.gesture(act, now)
        self.hand_in(self._permit(act), baud_rate=baud_rate)

    def _permit(self, act: Act) -> Permit:
        permit = Permit(act, Origin.CONFIRMATION, self.clock())
        self.permits.append(permit)
        return permit

    def hand_in(self, permit: Permit | None, *, act: Act | None = None, baud_rate: int = 115200) -> None:
        """Order the act of this permit, even as a faulty window would."""
        act = act or (permit.act if permit is not None else Act.DEPLOY)
        if act is Act.CHANGE_BAUD:
            self._seeking += 1
            self.run(change_baud(baud_rate, self.journal, permit=permit, armed=self.armed), self._end_seeking)
        else:
            self.run(perform(act, self.journal, permit=permit, armed=self.armed), self._end_act)

    def lock(self) -> None:
        self.ledger.lock(self.clock())
        self.run(lock(), self._end_lock, is_urgent=True)

    def _end_lock(self, run: Run[Locked]) -> None:
        if run.result is not None:
            self.on_lock(run.result)

    def _end_seeking(self, _run: Run[Any]) -> None:
        self._seeking -= 1

    def _end_act(self, run: Run[Performed]) -> None:
        self.ritual.disarm(Input.FINISHED)
        if run.result is not None:
            self.on_perform(run.result)

    # The ritual

    @property
    def is_under_way(self) -> bool:
        return self.ritual.stage in (Stage.CHOSEN, Stage.ARMED, Stage.HOLDING)

    @property
    def has_restarted_since_choosing(self) -> bool:
        return self.is_under_way and self.view.restarts != self._restarts

    def choose(self, *, is_rehearsal: bool) -> None:
        if not self.is_under_way:
            self.ritual.choose(is_rehearsal=is_rehearsal)
            self.hands.choose(is_rehearsal=is_rehearsal)
            self._restarts, self._was_online = self.view.restarts, self.view.presence is Presence.ONLINE

    def arm(self) -> None:
        if self.ritual.stage is Stage.CHOSEN and (self.ritual.is_rehearsal or not self._open_conditions()):
            self.ritual.arm(self.clock())
            self.hands.arm(self.clock())
            self.armed.act = Act.DEPLOY

    def press(self, kind: str) -> None:
        now = self.clock()
        self.ritual.press(now, is_auto_repeat=kind == "repeat", is_double_click=kind == "double")
        self.hands.press(now, kind)

    def release(self) -> None:
        self.ritual.release()
        self.hands.release()

    def disarm(self, why: Input) -> None:
        self.hands.leave()
        self.ritual.disarm(why)
        self._follow()

    def poll(self) -> None:
        """Disarm what ends by itself."""
        if not self.is_under_way:
            return
        view = self.view
        if self.has_restarted_since_choosing:
            self.disarm(Input.MODULE_RESTARTED)
        elif self._was_online and not (self.is_open and view.presence is Presence.ONLINE):
            self.disarm(Input.LINK_LOST)
        elif self.ritual.is_armed and not self.ritual.is_rehearsal and self._open_conditions():
            self.disarm(Input.CONDITION_OPENED)

    def _open_conditions(self) -> bool:
        asked_anyway = (Interlock.CONFIRMED, Interlock.RITUAL_DONE)
        now_is = interlock_inputs(self.view, self.clock(), must_be_proven=False, armed=self.armed.act)
        return any(one.condition not in asked_anyway for one in refusals(Act.DEPLOY, now_is))

    def _follow(self) -> None:
        if not self.is_under_way:
            self.armed.act = None

    def _fire(self, permit: Permit) -> None:
        self.permits.append(permit)
        if permit.is_rehearsal:
            rehearse(Act.DEPLOY, permit)
            self.ritual.disarm(Input.FINISHED)
        else:
            self.run(perform(Act.DEPLOY, self.journal, permit=permit, armed=self.armed), self._end_act)
