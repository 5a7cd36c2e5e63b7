"""Controller of the Tests page: runs a guided test, locks the module in any case, keeps the result.

    READY -> PREPARING -> (CONFIRMING the act) -> MEASURING -> DONE

Once an activation is confirmed, LOCK is pressed when the test ends, is cancelled, is aborted or loses the link, and
when the page or the window is left.
"""

from collections.abc import Mapping
from enum import Enum
from functools import partial

from app.store.modules import register_module
from protocol.link_states import Presence
from PySide6.QtCore import QObject, Signal

from app import version
from app.engine.procedure import Cancelled, PortLost, Report, Slept
from app.engine.transport import PortError
from app.engine.worker import Batch, Job
from app.guided.bay import light_direction
from app.guided.catalogue import GUIDED_BY_KIND, GuidedTest
from app.guided.guided_store import keep_test, last_tests
from app.guided.results import GuidedKind, GuidedResult, StoredTest
from app.guided.status_watch import Measure, PersonSteps
from app.procedures.act import Performed
from app.safety.journal import Outcome
from app.store.fact_store import Facts, Store
from app.store.trouble import StoreTrouble
from app.text.messages import message
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.context import Services
from ui.services.module_name import not_kept
from ui.session.running_job import RunningJob

CANCELLED = marked("cancelled")
LOST = marked("link lost")
SLEPT = marked("computer slept")
FAILED = marked("program error")
UNPROVEN = marked("not confirmed")
BECAME_ACTIVE = marked("ACTIVE during the test")


class Stage(Enum):
    READY = "ready"
    PREPARING = "preparing"
    CONFIRMING = "confirming"
    MEASURING = "measuring"
    DONE = "done"


RUNNING = (Stage.PREPARING, Stage.CONFIRMING, Stage.MEASURING)


class GuidedController(QObject):
    """`changed`: the stage, the step or the earlier results are different."""

    changed = Signal()

    def __init__(self, services: Services, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._connector = services, services.ports
        self.kind = GuidedKind.TILT
        self.stage = Stage.READY
        self.is_stated_safe = False
        """The person's statement, for the next test."""
        self.steps = PersonSteps()
        self._measuring: Measure | None = None
        """What is measured once it is prepared."""
        self.outcome: GuidedResult | UserError | None = None
        self.tested_as = ""
        """The name under which the last result is kept."""
        self.trouble: str | None = None
        """Says why a result was not kept, and whose."""
        self.owes_lock = False
        self.last: Mapping[GuidedKind, StoredTest] = {}
        """The last results of the module `last_of`."""
        self.last_of = ""
        self._shown: Report | None = None
        self._job = RunningJob(services.ports, self)
        self._loading: BackgroundTask[Mapping[GuidedKind, StoredTest]] = BackgroundTask("dps-s last tests", self)
        self._connector.changed.connect(self._watch)
        self._connector.batch.connect(self._on_batch)
        self._connector.invalidated.connect(self._reset)
        self._connector.broke_in_doubt.connect(partial(self.state_safe, False))
        self._connector.leaving.connect(self.cancel)
        services.ports.lock_changed.connect(self._on_lock)
        services.ports.renamed.connect(self.load_last)

    # What is known

    @property
    def test(self) -> GuidedTest:
        return GUIDED_BY_KIND[self.kind]

    @property
    def is_running(self) -> bool:
        return self.stage in RUNNING

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
        port = self._connector.current
        is_there = port.is_open and port.device.presence is Presence.ONLINE
        is_safe = self.is_stated_safe or not self.test.statement
        return is_there and is_safe and not self.is_running and not self.owes_lock and not port.is_active

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

    def start(self) -> None:
        if not self.can_start:
            return
        self.outcome = self.trouble = self._measuring = None
        self.stage = Stage.PREPARING
        self._job.run(self.test.prepare(), self._end_preparing)
        self.changed.emit()

    def confirm(self) -> None:
        """The step that waits for the person is done."""
        self.steps.confirm()
        self.changed.emit()

    def cancel(self, why: str = CANCELLED) -> None:
        """Abort the test; locks the module if the test may have made it active."""
        if self.is_running:
            self._finish(_broken_off(why))

    # How it goes on

    def act_begun(self) -> None:
        """The act was confirmed: the module may be active from now on."""
        if self.stage is Stage.CONFIRMING:
            self.owes_lock = True

    def act_ended(self, performed: Performed | None) -> None:
        if self.stage is not Stage.CONFIRMING:
            return  # cancelled meanwhile
        match None if performed is None else performed.outcome:
            case Outcome.CONFIRMED:
                self._measure()
            case None:
                self._finish(_broken_off(LOST))
            case Outcome.NOT_SENT:
                self.owes_lock = False
                self.changed.emit()
            case _:
                self._finish(_broken_off(UNPROVEN))

    def _end_preparing(self, job: Job[Measure]) -> None:
        if job.run.error is not None:
            self._finish(_why(job.run.error))
            return
        self._measuring = job.outcome()
        if self.test.is_active:
            self.stage = Stage.CONFIRMING
            self.changed.emit()
        else:
            self._measure()

    def _measure(self) -> None:
        if self._measuring is not None:
            self.steps = PersonSteps()
            self.stage = Stage.MEASURING
            self._connector.current.kept.is_fired_by_test = self.test.is_active
            self._job.run(self._measuring(self.steps), self._end_measuring)
            self.changed.emit()

    def _end_measuring(self, job: Job[GuidedResult]) -> None:
        self._finish(job.outcome() if job.run.error is None else _why(job.run.error))

    def _finish(self, outcome: GuidedResult | UserError) -> None:
        self._job.cancel()
        self._job.drop()
        self._connector.current.kept.is_fired_by_test = False
        if self.stage is not Stage.PREPARING and self._connector.current.device.fresh(
            "active", self._connector.clock()
        ):
            self.owes_lock = True  # whoever activated it: somebody is holding it
        self.stage, self.outcome, self.is_stated_safe = Stage.DONE, outcome, False
        if self.owes_lock:
            self._connector.current.lock.ensure_locked()
        if isinstance(outcome, GuidedResult):
            direction = light_direction(outcome)
            if direction is not None:
                self._connector.current.keep_light_direction(direction)
            self._store_result(outcome)
        self.changed.emit()

    # The lock

    def _on_lock(self) -> None:
        lock = self._connector.current.lock
        if lock.confirmed is not None or (lock.failed is not None and not self.is_running):
            self.owes_lock = False  # that it failed is on every page until the module reports that it is locked
        self.changed.emit()

    # What happens

    def _on_batch(self, batch: Batch) -> None:
        if self.is_running and not self.test.is_active and batch.device.fresh("active", batch.at) is True:
            self.cancel(BECAME_ACTIVE)
        elif self.report is not self._shown:
            self._shown = self.report
            self.changed.emit()

    def _watch(self) -> None:
        if not self._connector.current.is_open:
            self.cancel(LOST)
        self.changed.emit()

    def _reset(self) -> None:
        """Another module: nothing of the former one, and no LOCK that was meant for it."""
        self._loading.cancel()
        self.last, self.owes_lock = {}, False
        self.cancel(LOST)
        self.choose(self.kind)

    # The store

    def load_last(self) -> None:
        store, name = self._services.storage.store, self._connector.current.module.name
        if name != self.last_of:
            self.last_of, self.last = name, {}
            self.changed.emit()  # before the store has answered
        if not isinstance(store, Store) or not name:
            self._loading.cancel()
            self._on_last_tests({})
            return
        work = partial(last_tests, module=name, counts_simulated=self._is_simulated)
        self._loading.run_in(store, work, self._on_last_tests, lambda _trouble: self._on_last_tests({}))

    def _on_last_tests(self, last: Mapping[GuidedKind, StoredTest]) -> None:
        self.last = last
        self.changed.emit()

    @property
    def _is_simulated(self) -> bool:
        target = self._connector.current.target
        return target is not None and target.is_simulated

    def _store_result(self, result: GuidedResult) -> None:
        store, target = self._services.storage.store, self._connector.current.target
        name = self.tested_as = self._connector.current.module.name
        if not isinstance(store, Store):
            self.trouble = not_kept(store, name)
            return
        adapter = "" if target is None else target.key
        work = partial(
            _store, result=result, name=name, adapter=adapter,
            who=self._services.preferences.who, is_simulated=self._is_simulated,
        )  # fmt: skip
        storing: BackgroundTask[None] = BackgroundTask("dps-s guided test", self, for_once=True)
        storing.run_in(store, work, lambda _none: self.load_last(), partial(self._show_trouble, name))

    def _show_trouble(self, name: str, trouble: StoreTrouble) -> None:
        self.trouble = not_kept(trouble, name)
        self.changed.emit()


def _broken_off(why: str) -> UserError:
    return UserError(marked("No result: {why}."), why=message(why))


def _why(error: BaseException) -> UserError:
    match error:
        case UserError():
            return error
        case Slept():
            return _broken_off(SLEPT)
        case Cancelled():
            return _broken_off(CANCELLED)
        case PortLost() | PortError():
            return _broken_off(LOST)
        case _:
            return _broken_off(FAILED)


def _store(facts: Facts, result: GuidedResult, *, name: str, adapter: str, who: str, is_simulated: bool) -> None:
    if name:
        register_module(facts, name)
    keep_test(
        facts, result, module=name or None, adapter=adapter, who=who, is_simulated=is_simulated, program=version()
    )
