"""The guided tests of one module: run step by step, lock the module in any case, keep the result.

    READY -> PREPARING -> (CONFIRMING the act) -> MEASURING -> DONE

Once an activation is confirmed, LOCK is pressed when the test ends, is cancelled, is aborted or is interrupted, and
when the page or the window is left.
"""

from collections.abc import Mapping
from enum import Enum
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Cancelled, Job, Report
from app.engine.worker import Batch
from app.guided.guided_tests import GUIDED_BY_KIND, GuidedTest, Measure, PersonSteps, light_direction
from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind, GuidedResult, StoredTest, keep_test, last_tests
from app.modules.names import remember
from app.procedures.act import Performed
from app.safety.journal import Outcome
from app.store.fact_store import Facts, Store, StoreError
from app.text.messages import UserError, message
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.storage import Storage
from ui.session.lock import PortLock
from ui.session.shown_module import ShownModule, not_kept

CANCELLED, FAILED, LOST = marked("cancelled"), marked("program error"), marked("link lost")


class Stage(Enum):
    READY = "ready"
    PREPARING = "preparing"
    CONFIRMING = "confirming"
    MEASURING = "measuring"
    DONE = "done"


class Guided(QObject):
    """The guided test of one module. Its result stays as a notice of the port where the test ended with the
    conversation."""

    changed = Signal()
    """The stage, the step or the earlier results are different."""

    def __init__(self, module: ShownModule, storage: Storage, lock: PortLock) -> None:
        super().__init__(module)
        self._module, self._storage, self._lock = module, storage, lock
        self.kind = GuidedKind.TILT
        self.stage = Stage.READY
        # The person's statement, for the next test.
        self.is_stated_safe = False
        self.steps = PersonSteps()
        self.outcome: GuidedResult | UserError | None = None
        # The name under which the last result was measured.
        self.tested_as = ""
        # Says why a result was not kept.
        self.trouble: str | None = None
        self.owes_lock = False
        # The last result of each test, as it is kept under the module's name.
        self.last: Mapping[GuidedKind, StoredTest] = {}
        self._who = ""
        # What is measured once it is prepared.
        self._measuring: Measure | None = None
        self._shown: Report | None = None
        self._job = module.job("guided")
        self._job.changed.connect(self.changed)
        self._loading: BackgroundTask[Mapping[GuidedKind, StoredTest]] = BackgroundTask("dps-s last tests", self)
        module.batch.connect(self._on_batch)
        module.ended.connect(self._on_ended)
        module.named.connect(self.load_last)
        lock.changed.connect(self._on_lock)

    # What is known

    @property
    def test(self) -> GuidedTest:
        return GUIDED_BY_KIND[self.kind]

    @property
    def is_running(self) -> bool:
        return self.stage not in (Stage.READY, Stage.DONE)

    @property
    def report(self) -> Report | None:
        return self._job.progress if self.is_running else None

    @property
    def step(self) -> int:
        """Index of the current step; the number of steps once all are done."""
        if self.stage is Stage.DONE:
            return len(self.test.steps) if isinstance(self.outcome, GuidedResult) else 0
        return self.report.done if self.stage is Stage.MEASURING and self.report is not None else 0

    @property
    def can_start(self) -> bool:
        module = self._module
        is_safe = self.is_stated_safe or not self.test.statement
        is_free = not (self.is_running or self.owes_lock or module.is_checking)
        return module.is_going and is_safe and is_free and not module.activation.may_fire

    @property
    def confirm_words(self) -> str:
        """Text of the button for the step that waits for the person; empty if none does."""
        confirms = self.test.confirms
        is_waiting = self.stage is Stage.MEASURING and self.steps.is_waiting and self.step < len(confirms)
        return confirms[self.step] if is_waiting else ""

    # What a person does

    def choose(self, kind: GuidedKind) -> None:
        if not self.is_running:
            self.kind, self.stage, self.outcome, self.trouble = kind, Stage.READY, None, None
            self._measuring, self.is_stated_safe = None, False
            self.changed.emit()

    def state_safe(self, is_safe: bool) -> None:
        self.is_stated_safe = is_safe
        self.changed.emit()

    def start(self, who: str = "") -> None:
        """`who` tests."""
        if self.can_start:
            self._who = who
            self.outcome = self.trouble = self._measuring = None
            self.stage = Stage.PREPARING
            self._job.run(self.test.prepare(), self._end)
            self.changed.emit()

    def confirm(self) -> None:
        """The step that waits for the person is done."""
        self.steps.confirm()
        self.changed.emit()

    def cancel(self, why: str = CANCELLED) -> None:
        """Abort the test; locks the module if the test may have made it active."""
        if self.is_running:
            self._break_off(why)

    # How it goes on

    def act_begun(self) -> None:
        """The act was confirmed: the module may be active from now on."""
        if self.stage is Stage.CONFIRMING:
            self.owes_lock = True

    def act_ended(self, performed: Performed | None) -> None:
        if self.stage is not Stage.CONFIRMING:
            return  # cancelled meanwhile
        if performed is None:
            self._break_off(LOST)
        elif performed.outcome is Outcome.CONFIRMED:
            self._measure()
        elif performed.outcome is Outcome.NOT_SENT:
            self.owes_lock = False
            self.changed.emit()
        else:
            self._break_off(marked("not confirmed"))

    def _measure(self) -> None:
        if self._measuring is not None:
            self.steps = PersonSteps()
            self.stage = Stage.MEASURING
            self._module.is_fired_by_test = self.test.is_active
            self._job.run(self._measuring(self.steps), self._end, expects=self.test.expects)
            self.changed.emit()

    def _end(self, job: Job[Any]) -> None:
        """It is prepared, or measured."""
        if isinstance(job.error, UserError):
            self._finish(job.error)
        elif job.error is not None:
            self._break_off(CANCELLED if isinstance(job.error, Cancelled) else FAILED)
        elif self.stage is Stage.MEASURING:
            self._finish(job.outcome())
        else:
            self._measuring = job.outcome()
            if self.test.is_active:
                self.stage = Stage.CONFIRMING
                self.changed.emit()
            else:
                self._measure()

    def _break_off(self, why: str) -> None:
        self._finish(UserError(marked("No result: {why}."), why=message(why)))

    def _finish(self, outcome: GuidedResult | UserError) -> None:
        if self.stage is Stage.DONE:
            return
        module, is_measuring = self._module, self.stage is not Stage.PREPARING
        self._job.drop()
        module.is_fired_by_test = False
        if is_measuring and module.view.fresh("active", module.now_s):
            self.owes_lock = True  # whoever activated it: somebody is holding it
        self.stage, self.outcome, self.is_stated_safe = Stage.DONE, outcome, False
        if self.owes_lock:
            self._lock.press()
        if isinstance(outcome, GuidedResult):
            module.light_direction = light_direction(outcome) or module.light_direction
            self._keep_result(outcome)
        if not module.is_going:
            word = message(VERDICT_WORDS[outcome.verdict]) if isinstance(outcome, GuidedResult) else outcome.message
            module.keep_report(message(marked("{name}: {value}"), name=message(TITLES[self.kind]), value=word))
        self.changed.emit()

    # What happens

    def _on_lock(self) -> None:
        lock = self._lock
        if lock.confirmed is not None or (lock.failed is not None and not self.is_running):
            self.owes_lock = False  # that it failed is on every page until the module reports that it is locked
        self.changed.emit()

    def _on_batch(self, batch: Batch) -> None:
        if self.is_running and not self.test.is_active and batch.conversation.fresh("active", batch.at) is True:
            self.cancel(marked("ACTIVE during the test"))
        elif self.report is not self._shown:
            self._shown = self.report
            self.changed.emit()

    def _on_ended(self) -> None:
        """End it. A test that measures ends with its job, which may have expected that."""
        if self.stage is Stage.CONFIRMING:
            self._break_off(LOST)

    # The store

    def load_last(self) -> None:
        store, name, target = self._storage.ready, self._module.name, self._module.target
        self._loading.cancel()
        self._take_last({})  # before the store has answered
        if store is not None and name:
            work = partial(last_tests, module=name, counts_simulated=target is not None and target.is_simulated)
            self._loading.run_in(store, work, self._take_last, lambda _trouble: None)

    def _take_last(self, last: Mapping[GuidedKind, StoredTest]) -> None:
        self.last = last
        self.changed.emit()

    def _keep_result(self, result: GuidedResult) -> None:
        store, target, who = self._storage.store, self._module.target, self._who
        name = self.tested_as = self._module.name
        is_simulated = target is not None and target.is_simulated
        if not isinstance(store, Store):
            self.trouble = not_kept(store, name)
            return

        def keep(facts: Facts) -> None:
            if name:
                remember(facts, name)
            keep_test(facts, result, module=name or None, who=who, is_simulated=is_simulated)

        def fail(trouble: StoreError) -> None:
            self.trouble = not_kept(trouble, name)
            self.changed.emit()

        keeping: BackgroundTask[None] = BackgroundTask("dps-s guided test", self, for_once=True)
        keeping.run_in(store, keep, lambda _none: self.load_last(), fail)
