"""The Pre-flight controller on the desk: check, activate, and observe whether the verdict holds."""

from types import SimpleNamespace
from typing import Any, Final, cast

from PySide6.QtCore import QObject, Signal

from app.diagnosis.link_state import Phase
from app.engine.procedure import PortLost, Procedure
from app.engine.worker import Batch, Connection, Job, PortState
from app.preflight.reread import REREAD_EVERY_S
from app.preflight.run import TRIGGERS
from app.safety.acts import Act
from app.safety.journal import NoJournal
from tests.adversary.judge import LOOKS_IN_A_ROW, Breach, Finding
from tests.adversary.program import PORT
from tests.adversary.truth import settings_keys
from tests.adversary.window import Session, WindowDesk
from ui.core.module_memory import ModuleMemory
from ui.pages.preflight.controller import PreflightController, Standing, Statement
from ui.services.context import Services

CHECK_LIMIT_S: Final = 60.0
WATCHED_S: Final = 24.0
SEEN_WITHIN_S: Final = REREAD_EVERY_S + 2.0
"""Time within which a change must end the verdict."""


class _Naming(QObject):
    changed = Signal()
    name = "M1"

    def remember_adapter(self) -> None:
        """Does nothing, because there is no store."""


class _Connector(QObject):
    """The part of the window's connector that the controller uses."""

    changed = Signal()
    invalidated = Signal()
    batch = Signal(object)
    adapter_key = ""
    target = None

    def __init__(self, desk: WindowDesk) -> None:
        super().__init__()
        self._desk, self._jobs = desk, list[tuple[Job[Any], Any]]()
        self._was_open = desk.is_open
        self.clock = desk.clock
        self.connection = Connection(PortState.OPEN, PORT, 115200)
        self.kept = ModuleMemory()
        self.current = self  # its only port
        self.last = Batch(self.clock(), self.connection, self.device, None)

    @property
    def device(self) -> Any:
        return self._desk.view

    @property
    def is_open(self) -> bool:
        return self._desk.is_open

    @property
    def state(self) -> Any:
        return SimpleNamespace(phase=Phase.ONLINE if self.is_open else Phase.CLOSED)

    def run(self, procedure: Procedure[Any], then: Any, on_progress: Any = None) -> Job[Any]:
        job = Job(procedure, on_progress)
        self._jobs.append((job, then))
        if self._desk.session is None:
            job.run.throw(PortLost(), self.clock())
        else:
            self._desk.session.run(job.run)
        return job

    def turn(self) -> None:
        """Deliver the events, as the window's bridge does."""
        if self._was_open != self.is_open:
            self._was_open = self.is_open
            self.changed.emit()
        for job, then in [one for one in self._jobs if one[0].run.is_done]:
            self._jobs.remove((job, then))
            job.finish()
            then(job)
        session = self._desk.session
        events = tuple(session.take_events()) if session is not None else ()
        self.last = Batch(self.clock(), self.connection, self.device, None, (), events)
        self.batch.emit(self.last)


class Checking:
    """Checks, activates if READY asks for it, and observes the verdict."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._connector, self._naming = _Connector(session.desk), _Naming()
        storage = SimpleNamespace(journal=lambda _target, _module="": NoJournal(), store=None)
        services = SimpleNamespace(connector=self._connector, naming=self._naming, storage=storage)
        self.work = PreflightController(cast("Services", services))
        self.said: list[Standing] = []

    def go_through(self) -> None:
        desk = self._session.desk
        desk.ledger.allow(id(self), [command.set(True) for command in TRIGGERS])
        self.work.check(Statement(is_enabling=True, are_records_reviewed=True))
        self._wait(CHECK_LIMIT_S, until_checked=True)
        if self.work.leads_to_activation:
            desk.ask(Act.ACTIVATE)
            self._wait(0.5)
            desk.go(Act.ACTIVATE)
        read_at_s = desk.clock() + REREAD_EVERY_S
        ends_at_s = desk.clock() + WATCHED_S
        while desk.clock() < ends_at_s and self.work.standing in (Standing.GO, Standing.READY):
            if desk.clock() >= read_at_s:  # the page's timer
                read_at_s += REREAD_EVERY_S
                self.work.read_again()
            self._wait(0.25)
            self._judge()

    def _wait(self, seconds: float, *, until_checked: bool = False) -> None:
        ends_at_s = self._session.desk.clock() + seconds
        while self._session.desk.clock() < ends_at_s:
            self._session.wait(0.02)
            self._connector.turn()
            if until_checked and self.work.standing is not Standing.CHECKING:
                return

    def _judge(self) -> None:
        session, work = self._session, self.work
        if work.standing not in (Standing.GO, Standing.READY) or work.assessment is None:
            return
        self.said.append(work.standing)
        evidence, truth, now_s = work.assessment.case.evidence, session.desk.truth, session.desk.clock()
        said = {key: evidence.values.get(key) for key in (*settings_keys(), "boot_count")}
        said |= {"active": work.standing is Standing.GO, "triggered": False}
        limit_s = SEEN_WITHIN_S + LOOKS_IN_A_ROW * session.latency_s
        for key, value in said.items():
            changed_at = truth.changed_at(key)
            is_news = changed_at is not None and now_s - changed_at <= limit_s
            if truth.value(key, truth.now) != value and not is_news:
                holds = truth.value(key, truth.now)
                text = f"{work.standing.value} stands: {key} = {value}, and it is {holds}"
                session.findings.append(Finding(Breach.FALSE_VERDICT, text))


def check(session: Session) -> None:
    session.connect()
    checking = Checking(session)
    checking.go_through()
    session.said += [standing.value for standing in dict.fromkeys(checking.said)]
