"""The window's work on a module without widgets: the same form, procedures and session, on one clock."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from app.procedures.act import Performed
from app.procedures.lock import Locked
from app.procedures.write_all import WriteReport
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.settings.form import RowState
from tests.adversary.judge import Breach, Case, Finding, shown, stands
from tests.adversary.program import Ran
from tests.adversary.truth import Truth, settings_keys
from tests.scenarios.desk import Desk
from tests.scenarios.desk_port import WatchedLine

LOOK_EVERY_S: Final = 0.5
SETTLED_IN_S: Final = 4.0
"""Time until it is connected, everything is read, and the stream is on."""
SURE: Final = (RowState.READ, RowState.VERIFIED)
DRAFTS: Final = {"attitude_threshold_deg": 70, "freefall_time_s": 1.8}


class _Line(WatchedLine):
    """Reports what is sent and received to the record of the truth."""

    truth: Truth

    def read(self, longest_s: float, gather_s: float) -> bytes:
        data = super().read(longest_s, gather_s)
        self.truth.note()
        self.truth.take_arrived(data)
        return data

    def write(self, data: bytes) -> None:
        super().write(data)
        self.truth.take_sent(data)


class WindowDesk(Desk):
    """Records claims as they are made."""

    def __init__(self, options: Mapping[str, Any]) -> None:
        super().__init__(options, is_watching=True)
        self.truth = Truth(self.bench, self.clock)
        self.written: list[WriteReport] = []
        self.performed: list[Performed] = []
        self.locked: list[Locked] = []
        self.on_write, self.on_perform, self.on_lock = self.written.append, self.performed.append, self.locked.append

    def make_line(self, baud_rate: int) -> WatchedLine:
        line = _Line(self.clock, self.bench, self.ledger, baud_rate)
        line.truth = self.truth
        return line


@dataclass
class Session:
    """One session at the window; `look` compares what is shown with the truth."""

    desk: WindowDesk
    latency_s: float
    forges: bool
    findings: list[Finding] = field(default_factory=list)
    said: list[str] = field(default_factory=list)
    """Verdicts that held."""
    happens: tuple[float, Callable[[Any], None]] | None = None

    def connect(self) -> None:
        self.desk.connect()
        self.wait(SETTLED_IN_S)

    def wait(self, seconds: float) -> None:
        ends_at_s = self.desk.clock() + seconds
        next_s = self.desk.clock() + LOOK_EVERY_S
        while self.desk.clock() < ends_at_s:
            if self.happens is not None and self.desk.clock() >= self.happens[0]:
                (_, happen), self.happens = self.happens, None
                happen(self.desk.bench)
            self.desk.turn()
            if self.desk.clock() >= next_s:
                next_s += LOOK_EVERY_S
                self.poll()

    @property
    def case(self) -> Case:
        self.desk.truth.end()
        return Case(ran=Ran(), truth=self.desk.truth, acts={}, latency_s=self.latency_s, forges=self.forges)

    def poll(self) -> None:
        """Compare every value that is shown as certain."""
        case, view, now = self.case, self.desk.view, self.desk.clock()
        for row in self.desk.rows():
            if row.command.key in settings_keys() and row.state in SURE and row.module_value is not None:
                self.findings += shown(case, row.command.key, row.module_value.value)
        for key in ("active", "triggered", "boot_count"):
            value = view.fresh(key, now)
            if value is not None:
                self.findings += shown(case, key, value)

    def end(self) -> list[Finding]:
        """Return the findings on what was claimed and sent."""
        for text in self.desk.ledger.complaints:
            is_mishap = "a procedure ended with" in text
            self.findings.append(Finding(Breach.MISHAP if is_mishap else Breach.DANGEROUS_FRAME, text))
        return self.findings


def watch(session: Session) -> None:
    session.connect()
    session.desk.read_all()
    session.wait(14.0)


def write(session: Session) -> None:
    session.connect()
    desk = session.desk
    desk.edit(lambda: desk.form.fill(DRAFTS))
    desk.write()
    while desk.is_busy and not desk.written:
        session.wait(0.02)
    for report in desk.written:
        for written in report.results:
            if written.verified:
                key = written.command.key
                session.findings += stands(session.case, key, written.wanted, Breach.FALSE_VERIFIED, "verified")
    session.wait(4.0)


def lock(session: Session) -> None:
    session.connect()
    session.desk.lock()
    while not session.desk.locked and session.desk.is_open and session.desk.clock() < 1060.0:
        session.wait(0.02)
    if session.desk.locked and session.desk.locked[0].is_locked:
        session.findings += stands(session.case, "active", False, Breach.FALSE_OUTCOME, "locked", settled_s=0.0)
    session.wait(2.0)


def act(which: Act) -> Callable[[Session], None]:
    def perform(session: Session) -> None:
        session.connect()
        desk = session.desk
        desk.ask(which)
        session.wait(0.2)
        desk.go(which)
        ends_at_s = desk.clock() + 20.0
        while not desk.performed and desk.is_open and desk.clock() < ends_at_s:
            session.wait(0.02)
        for done in desk.performed:
            if done.outcome is Outcome.CONFIRMED:
                session.findings += _judge_act(session.case, which, done)
        session.wait(2.0)

    return perform


def _judge_act(case: Case, which: Act, done: Performed) -> Iterator[Finding]:
    now = case.truth.now
    if which is Act.ACTIVATE:
        yield from stands(case, "active", True, Breach.FALSE_OUTCOME, "confirmed", settled_s=0.0)
    if which is Act.ZERO and now.tilt_deg and done.is_level:
        yield Finding(Breach.FALSE_OUTCOME, f"confirmed, and the tilt is still {now.tilt_deg}°")
    if which is Act.SHUTDOWN and now.is_on:
        yield Finding(Breach.FALSE_OUTCOME, "confirmed, and the module is still on")
