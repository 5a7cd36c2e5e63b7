"""A batch at one port, one module after the other: whose turn it is, and what came of it."""

from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Any, NamedTuple

from PySide6.QtCore import QObject, Signal

from app.diagnosis.link_state import Phase
from app.engine.procedure import Report
from app.engine.worker import Batch, Job
from app.fleet.batch import PLUG_IN, UNPLUG, BatchRow, Bench
from app.preflight.evidence import Disturbance, Evidence
from app.procedures.write_all import WriteContext
from app.store.database import StoreTrouble
from app.store.store import Store
from app.store.store_journal import KnownAs
from app.text.messages import UserMessage
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.context import Services
from ui.services.port import Port


class Stage(Enum):
    """The value is what is said in large letters, translatable."""

    PLUG_IN = PLUG_IN
    ASK = marked("LABEL: {module}?")
    """A module answers, and nobody said yet that the next name is on its label."""
    WORKING = marked("{module}: LEAVE IT IN")
    UNPLUG = UNPLUG
    DONE = marked("BATCH DONE")
    STOPPED = marked("STOPPED")
    """The port is gone, or nothing can be kept."""


class Outcome(NamedTuple):
    """Of the last turn; `why` it was set aside, None where it is READY."""

    name: str
    why: UserMessage | None


class _State(NamedTuple):
    rows: tuple[BatchRow, ...]
    left: tuple[str, ...]


@dataclass(eq=False, slots=True)
class _Turn:
    name: str
    port: Port
    evidence: Evidence
    adapter: str
    job: Job[Any] | None = None
    is_broken: bool = False
    """It is another connection or another module by now."""
    report: Report | None = None

    def remember(self, report: Report) -> None:
        """In the worker's thread."""
        self.report = report


class BatchTurns(QObject):
    """At the port that was shown when it began. A module has its turn once a person has confirmed its label on this
    connection, keeps the name only if it is READY and nothing broke meanwhile, and is then to be unplugged."""

    changed = Signal()

    def __init__(self, services: Services, parent: QObject) -> None:
        super().__init__(parent)
        self._services = services
        self.bench: Bench | None = None
        self.port: Port | None = None
        self.rows: tuple[BatchRow, ...] = ()
        self.outcome: Outcome | None = None
        self.trouble: StoreTrouble | None = None
        """Why nothing can be kept."""
        self._left: tuple[str, ...] = ()
        self._turn: _Turn | None = None
        self._had_its_turn: object = None
        """The module that is to be unplugged."""
        self._keeping: BackgroundTask[UserMessage | None] = BackgroundTask("dps-s batch", self)
        self._reading: BackgroundTask[_State] = BackgroundTask("dps-s batch list", self)
        self.changed.connect(self._claim_question)
        services.connector.removed.connect(self._on_removed)

    @property
    def stage(self) -> Stage:
        if self._turn is not None:
            return Stage.WORKING
        if self.trouble is not None or self.port is None:
            return Stage.STOPPED
        if not self._left:
            return Stage.DONE
        if self._had_its_turn is not None:
            return Stage.UNPLUG
        return Stage.ASK if self._is_answering else Stage.PLUG_IN

    @property
    def is_working(self) -> bool:
        return self._turn is not None

    @property
    def name(self) -> str:
        """That the module in its turn has, or the next one gets."""
        return self._turn.name if self._turn is not None else self._left[0] if self._left else ""

    @property
    def report(self) -> Report | None:
        return None if self._turn is None else self._turn.report

    def start(self, bench: Bench, store: Store) -> None:
        """Begin at the shown port; goes on where the same batch was left."""
        self.stop()
        self.bench, self._store = bench, store
        self.port = port = self._services.connector.current
        port.changed.connect(self._on_changed)
        port.batch.connect(self._listen)
        port.invalidated.connect(self._on_another_module)
        self._read()

    def stop(self) -> None:
        """Leave it; what is kept stays."""
        if self._turn is not None:
            return
        self._leave_port()
        self.bench, self.rows, self._left, self.outcome, self.trouble = None, (), (), None, None
        self.changed.emit()

    def cancel(self) -> None:
        """The module in its turn is set aside."""
        if self._turn is not None and self._turn.job is not None:
            self._turn.job.cancel()

    def confirm(self, name: str) -> bool:
        """A person read this name on the label of the module that answers; whether its turn begins."""
        port, bench = self.port, self.bench
        if self.stage is not Stage.ASK or port is None or bench is None or name not in self._left:
            return False
        target, opening = port.target, port.view.opening
        port.module.treat_as_new(name=name)
        if port.view.opening == opening:
            return False  # a person is asked about edits first
        evidence = Evidence(port=port.connection.port)
        journal = self._services.storage.journal(target, KnownAs(run=port.kept.run))
        try:
            procedure = bench.provision(evidence, WriteContext(journal=journal, armed=self._services.armed))
        except StoreTrouble as trouble:
            port.module.treat_as_new()  # which does not get the name
            self._fail(trouble)
            return False
        turn = self._turn = _Turn(name, port, evidence, "" if target is None else target.identity)
        turn.job = port.run(procedure, partial(self._end, turn), on_progress=turn.remember)
        self.outcome = None
        self.changed.emit()
        return True

    # What happens

    @property
    def _is_answering(self) -> bool:
        return self.port is not None and self.port.is_open and self.port.state.phase is Phase.ONLINE

    @property
    def module(self) -> object:
        """Another value once it may be another module."""
        return None if self.port is None else (self.port.view.opening, self.port.device.restarts)

    def _on_changed(self) -> None:
        if self._had_its_turn is not None and not (self._is_answering and self.module == self._had_its_turn):
            self._had_its_turn = None
        self.changed.emit()

    def _claim_question(self) -> None:
        """While there are names left the window does not ask beside it which module it is."""
        connector = self._services.connector
        asked_on = None if self.stage in (Stage.DONE, Stage.STOPPED) else "fleet"
        if asked_on != connector.asked_on:
            connector.asked_on = asked_on
            connector.any_changed.emit()

    def _listen(self, batch: Batch) -> None:
        if self._turn is not None:
            self._turn.evidence.listen(batch.events)

    def _on_another_module(self) -> None:
        turn = self._turn
        if turn is not None and turn.job is not None:
            turn.is_broken = True
            turn.job.cancel()

    def _end(self, turn: _Turn, job: Job[Any]) -> None:
        bench = self.bench
        if turn is not self._turn or bench is None:
            return
        evidence, is_whole = turn.evidence, job.run.error is None and not turn.is_broken
        evidence.listen(turn.port.last.events)
        evidence.note_error(job.run.error)
        if turn.is_broken:
            evidence.disturbance = evidence.disturbance or Disturbance.DISCONNECTED
        done = job.outcome() if is_whole else None
        keep = partial(bench.keep, turn.name, evidence, done, turn.adapter)
        self._keeping.run_in(self._store.queue, keep, partial(self._end_turn, turn), self._fail)

    def _end_turn(self, turn: _Turn, why: UserMessage | None) -> None:
        self._turn, self.outcome = None, Outcome(turn.name, why)
        if why is None:
            turn.port.module.remember_adapter()
        else:
            turn.port.module.take_back(turn.name)
        self._had_its_turn = self.module
        self._on_changed()
        self._read()

    def _read(self) -> None:
        bench = self.bench
        if bench is not None:
            self._reading.run_in(self._store.queue, partial(_read, bench), self._show, self._fail)

    def _show(self, state: _State) -> None:
        self.rows, self._left = state
        self.changed.emit()

    def _fail(self, trouble: StoreTrouble) -> None:
        turn, self._turn, self.trouble = self._turn, None, trouble
        if turn is not None:
            turn.port.module.take_back(turn.name)
        self.changed.emit()

    def _on_removed(self, port: Port) -> None:
        if port is self.port:
            self._leave_port()
            self.changed.emit()

    def _leave_port(self) -> None:
        port, self.port, self._had_its_turn = self.port, None, None
        if port is not None:
            port.changed.disconnect(self._on_changed)
            port.batch.disconnect(self._listen)
            port.invalidated.disconnect(self._on_another_module)


def _read(bench: Bench) -> _State:
    return _State(tuple(bench.rows()), tuple(bench.left()[0]))
