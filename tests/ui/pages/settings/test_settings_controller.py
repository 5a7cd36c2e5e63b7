"""What the controller of the Settings page makes of the ends of its jobs, over fake ports: no procedure runs."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from app.engine.identity import Identity, Trust
from PySide6.QtWidgets import QApplication
from ui.pages.settings.controller import SettingsController

from app.engine.conversation import How, Known, StaleReason
from app.engine.procedure import Cancelled, PortLost
from app.engine.snapshots import Snapshot
from app.engine.target import Target
from app.procedures.read import Everything
from app.procedures.write import SetReply, SettingChange, WriteContext, WriteFault, WriteReport, Written
from app.safety.interlocks import Interlock, Refusal
from app.settings.form import FormRow, RowState
from app.text.messages import UserMessage
from protocol.catalogue import BY_NAME
from protocol.events import Unanswered
from protocol.fields import Value
from tests.support.window.fake_ports import FakePorts, FakeWorker, fake_services
from tests.support.window.steps import given
from ui.pages.settings import controller
from ui.services.storage import Storage
from ui.style.theme import Meaning

TILT, TIME, LIGHT = (BY_NAME[name] for name in ("attitude_threshold", "freefall_time", "light_threshold"))
FOUND: dict[str, Value] = {TILT.key: 60, TIME.key: 1.6, LIGHT.key: 1.8}
AS_FOUND = Snapshot(settings=FOUND)
WANTED: dict[str, Value] = {TILT.key: 70, TIME.key: 1.2}
CUT, UNREAD = "{} was sent: interrupted while writing; the value is unknown", "70° was sent: not read again"
TILT_HEARD = Written(command=TILT, target=70, heard=SetReply.ECHO, read_back=70, verified=True)
TIME_HEARD = Written(command=TIME, target=1.2, heard=SetReply.ECHO, read_back=1.2, verified=True)


@dataclass
class Desk:
    ports: FakePorts
    work: SettingsController
    leaves: list[WriteContext] = field(default_factory=list)

    @property
    def worker(self) -> FakeWorker:
        return self.ports.workers[0]

    def write(self) -> WriteContext:
        """Begins to write what is wanted, as `write_all` does."""
        self.work.edit(lambda: self.work.form.fill(WANTED))
        self.work.write()
        leave = self.leaves[-1]
        if leave.store_snapshot is not None:
            leave.store_snapshot(AS_FOUND)
        return leave

    def end(self, result: object, **values: Value) -> None:
        """Ends the job that was begun last, with an error or a result; the module then reads `values`."""
        job = self.worker.jobs[-1][0]
        if isinstance(result, Exception):
            job.run.error = result
        else:
            job.run.result = result
        self.worker.say(**values)
        self.worker.hand_over(finished=(job,))
        QApplication.processEvents()

    @property
    def rows(self) -> list[FormRow]:
        """Of tilt and time."""
        port = self.ports.ports.current
        return [row for row in self.work.form.rows(port.device, port.clock()) if row.command.key in WANTED]

    @property
    def states(self) -> list[RowState]:
        return [row.state for row in self.rows]

    @property
    def says(self) -> str:
        notice = self.work.notice()
        return "" if notice is None else notice.text


@pytest.fixture
def desk(qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    with fake_services(qapp, Storage(tmp_path)) as (ports, services):
        made = Desk(ports, SettingsController(services))

        def begin(_changes: Sequence[SettingChange], leave: WriteContext) -> Any:
            made.leaves.append(leave)
            return iter(())

        monkeypatch.setattr(controller, "write_all", begin)
        ports.plug_in("/dev/port0", **FOUND)
        QApplication.processEvents()
        yield made


@pytest.mark.parametrize("error", [PortLost(), Cancelled()], ids=["lost", "cancelled"])
@pytest.mark.parametrize(
    ("begun", "heard", "states", "reasons"),
    [
        ((), (), [RowState.EDITED, RowState.EDITED], []),
        ((TILT,), (), [RowState.FAILED, RowState.EDITED], [CUT.format("70°")]),
        ((TILT,), (TILT_HEARD,), [RowState.FAILED, RowState.EDITED], [UNREAD]),
        ((TILT, TIME), (TILT_HEARD,), [RowState.FAILED, RowState.FAILED], [UNREAD, CUT.format("1.20 s")]),
    ],
    ids=["nothing", "begun", "heard", "heard_and_begun"],
)
@pytest.mark.promise("l")
def test_what_an_interrupted_write_began_is_in_doubt_until_it_reads_as_wanted(
    desk: Desk, error: Exception, begun: Any, heard: Any, states: list[RowState], reasons: list[str]
) -> None:
    leave = desk.write()
    assert leave.on_begun is not None
    assert leave.on_written is not None
    for command in begun:
        leave.on_begun(command)
    for written in heard:
        leave.on_written(written)
    notice = given(desk.work.notice())
    if isinstance(error, Cancelled):
        notice.choices[0].act()
    assert desk.worker.jobs[-1][0].run.is_cancelled is isinstance(error, Cancelled)
    desk.end(error)
    assert [row.reason.rstrip(".") for row in desk.rows if row.reason] == reasons
    assert (desk.states, desk.work.count_unsent()) == (states, 2)
    assert desk.work.job.is_running is isinstance(error, Cancelled), "what a cancelled write left is read at once"
    desk.work.read_all()
    desk.end(Everything({}, {}, is_silent=False, began_at=0.0), **FOUND)
    assert (desk.states, desk.work.count_unsent()) == (states, 2), "a reading of the old values clears nothing"
    assert desk.says == ("Cancelled." if isinstance(error, Cancelled) else ""), "all was read again since"
    desk.work.read_all()
    desk.end(Everything({}, {}, is_silent=False, began_at=0.0), **WANTED)
    assert (desk.states, desk.work.count_unsent()) == ([RowState.READ, RowState.READ], 0)


@pytest.mark.parametrize(
    ("values", "restarts", "states", "says"),
    [
        (WANTED, 0, [RowState.VERIFIED, RowState.VERIFIED], "Read back as written: 2."),
        (WANTED, 1, [RowState.READ, RowState.READ], "Not verified, but read as set since: 2."),
        (
            {TIME.key: 0.2, TILT.key: 70}, 0, [RowState.VERIFIED, RowState.CHANGED],
            "Read back as written: 1. Changed without being written: Free-fall time.",
        ),
        ({}, 1, [RowState.STALE, RowState.STALE], "In doubt since: 2; see the rows."),
    ],
    ids=["verified", "read_after_a_restart", "changed_since", "restarted"],
)  # fmt: skip
def test_only_what_is_verified_now_is_called_verified(
    desk: Desk, values: dict[str, Value], restarts: int, states: list[RowState], says: str
) -> None:
    """The window may see the end of a write late: the module was read again, or restarted, since."""
    desk.write()
    desk.worker.restarts = restarts
    if not values:
        desk.worker.values = {
            key: known._replace(value=WANTED.get(key, known.value), stale_reason=StaleReason.RESTARTED)
            for key, known in desk.worker.values.items()
        }
    desk.end(WriteReport(results=(TILT_HEARD, TIME_HEARD)), **values)
    assert (desk.states, desk.says) == (states, says)
    desk.worker.identity = Identity(Trust.UNPROVEN)
    desk.worker.say()
    QApplication.processEvents()
    assert desk.says == "", "another module may answer"


@pytest.mark.parametrize("is_begun", [False, True])
def test_nothing_was_written_is_said_only_where_nothing_was_sent(desk: Desk, is_begun: bool) -> None:
    """It became active, or may be another module, after the first setting."""
    refused = Refusal(Interlock.MAY_WRITE, UserMessage("ACTIVE."))
    tilt, time = (
        Written(command=command, target=WANTED[command.key], heard=SetReply.NOT_SENT, fault=WriteFault.NOT_ALLOWED)
        for command in (TILT, TIME)
    )
    desk.write()
    results = (TILT_HEARD if is_begun else tilt, time)
    desk.end(WriteReport(results=results, refusals=(refused,)), **{TILT.key: 70 if is_begun else 60})
    assert desk.says == f"{'Read back as written: 1.' if is_begun else 'Nothing was written.'} ACTIVE."
    assert desk.work.count_unsent() == (1 if is_begun else 2)


@pytest.mark.parametrize(
    "change",
    [
        lambda ports: ports.ports.choose(ports.plug_in("/dev/port1", **FOUND)[0]),
        lambda ports: ports.ports.current.treat_as_new(),
        lambda ports: ports.ports.connect_to(Target("/dev/port1", 115200)),
    ],
    ids=["another_port", "another_module", "another_connection"],
)
def test_nothing_of_one_module_is_kept_for_another(desk: Desk, change: Callable[[FakePorts], None]) -> None:
    leave, work = desk.write(), desk.work
    failed = Written(command=TIME, target=1.2, heard=SetReply.ECHO, read_back=1.6, fault=WriteFault.NOT_RETAINED)
    desk.end(WriteReport(results=(TILT_HEARD, failed)), **FOUND)
    assert (work.initial, work.count_unsent()) == (AS_FOUND, 1)
    assert desk.write().store_snapshot is None, "the values found are those before the first write"
    desk.end(PortLost())
    change(desk.ports)
    desk.worker.say(**FOUND)
    QApplication.processEvents()
    given(leave.store_snapshot)(AS_FOUND)  # the worker of the former module was slow
    assert work.initial is None
    work.restore_initial()
    assert (work.count_unsent(), work.form.has_drafts, desk.says) == (0, False, "")
    assert work.form.watch is desk.ports.ports.current.kept.watch


def test_a_write_is_allowed_only_what_a_person_allowed(desk: Desk) -> None:
    leave = desk.write()
    assert (leave.is_unlocked, leave.accepted_risks) == (False, frozenset())


@pytest.mark.parametrize("trust", [Trust.UNPROVEN, Trust.REFUTED])
def test_to_a_module_that_may_be_another_nothing_is_written_or_restored(desk: Desk, trust: Trust) -> None:
    desk.write()
    desk.end(PortLost())
    desk.worker.identity = Identity(trust)
    desk.worker.say(**FOUND)
    QApplication.processEvents()
    jobs = len(desk.worker.jobs)
    desk.work.write()
    assert len(desk.worker.jobs) == jobs
    assert desk.says.startswith("Nothing was written.")
    desk.work.restore_initial()
    assert (desk.work.initial, desk.work.form.edited) == (None, WANTED)


@pytest.mark.parametrize("is_written", [False, True])
def test_what_could_not_be_read_is_said_until_it_is_read(desk: Desk, is_written: bool) -> None:
    now = desk.ports.ports.clock() + 1.0
    if is_written:
        desk.write()
        desk.end(WriteReport(results=(TILT_HEARD,), unread=(LIGHT,), read_at=now), **{TILT.key: 70})
    else:
        desk.work.read_all()
        desk.end(Everything({}, {LIGHT.key: Unanswered(LIGHT.query(), 1, 0.5, now)}, is_silent=False, began_at=now))
    assert "Light threshold" in desk.says
    desk.worker.values[LIGHT.key] = Known(1.8, How.READ, now)
    desk.worker.say()
    QApplication.processEvents()
    assert "Light threshold" not in desk.says


def test_what_is_only_acknowledged_is_not_shown_as_good(desk: Desk) -> None:
    desk.write()
    written = Written(command=BY_NAME["attitude_trigger"], target=True, heard=SetReply.ECHO, verified=None)
    desk.end(WriteReport(results=(written,)), attitude_trigger=True)
    notice = given(desk.work.notice())
    assert (notice.text, notice.meaning) == ("Acknowledged, cannot be read: 1.", Meaning.INFORMATION)
