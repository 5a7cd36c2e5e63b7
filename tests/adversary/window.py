"""The real window on a module that lies: what it shows as certain, and what it says of an act."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from PySide6.QtTest import QTest

from app.preflight.findings import Person
from app.preflight.verdict import REREAD_EVERY_S
from app.procedures.act import Armed, Performed
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.settings.form import FormRow, RowState
from protocol.catalogue import SERIAL_OUTPUT, Command
from protocol.fields import Value
from tests.adversary.judge import LOOKS_IN_A_ROW, Breach, Case, Finding, shown, stands
from tests.adversary.program import Ran
from tests.gestures.gesture_bench import GestureBench
from tests.support.line.truth import settings_keys
from ui.acts.confirm import Confirm
from ui.session.check import Standing

LOOK_EVERY_S: Final = 0.5
NO_TIME_S: Final = 1e-9
"""Less is an error of rounding, for which the clock of the bench does not move."""
SETTLED_IN_S: Final = 4.0
"""Time until it is connected, everything is read, and the stream is on."""
SURE: Final = (RowState.READ, RowState.ACKNOWLEDGED, RowState.VERIFIED)
DRAFTS: Final = {"attitude_threshold_deg": 70, "freefall_time_s": 1.8}
CHECK_LIMIT_S: Final = 60.0
WATCHED_S: Final = 24.0
SEEN_WITHIN_S: Final = REREAD_EVERY_S + 2.0
"""Time within which a change must end the verdict."""


@dataclass
class Session:
    """Somebody sits at the window; `look` compares what is shown as certain with the truth."""

    bench: GestureBench
    latency_s: float
    forges: bool = False
    findings: list[Finding] = field(default_factory=list)
    said: list[str] = field(default_factory=list)
    """Verdicts that held."""
    happens: tuple[float, Callable[[Any], None]] | None = None

    def connect(self, rate: int = 115200) -> None:
        self.bench.connect(rate)
        self.wait(SETTLED_IN_S)

    def wait(self, seconds: float) -> None:
        bench, ends_at_s = self.bench, self.bench.clock() + seconds
        while (left_s := ends_at_s - bench.clock()) > NO_TIME_S:
            if self.happens is not None and self.happens[0] - bench.clock() <= NO_TIME_S:
                (_, happen), self.happens = self.happens, None
                happen(bench.bench)
            until_s = self.happens[0] - bench.clock() if self.happens is not None else LOOK_EVERY_S
            bench.wait(min(left_s, until_s, LOOK_EVERY_S), tick_s=LOOK_EVERY_S)
            self.look()

    @property
    def case(self) -> Case:
        self.bench.truth.end()
        return Case(ran=Ran(), truth=self.bench.truth, acts={}, latency_s=self.latency_s, forges=self.forges)

    def rows(self) -> tuple[FormRow, ...]:
        return self.bench.settings.work.form.rows(self.bench.device, self.bench.clock())

    def look(self) -> None:
        """Compare every value that is shown as certain."""
        case, view, now = self.case, self.bench.device, self.bench.clock()
        is_linked = self.bench.assembly.ports.current.is_open and view.is_going
        for row in self.rows():
            if row.state not in SURE or row.module_value is None:
                continue
            key, value = row.command.key, row.module_value.value
            if not is_linked:
                self.findings.append(Finding(Breach.WRONG_VALUE, f"{key} is shown as certain without a link"))
            elif row.command is not SERIAL_OUTPUT:  # a stream proves it, too
                self.findings += shown(case, key, value)
            if row.state is RowState.VERIFIED:
                self.findings += self._unproven(row.command, value)
        for key in ("active", "triggered", "boot_count"):
            known = view.fresh(key, now)
            if known is not None:
                self.findings += shown(case, key, known)

    def _unproven(self, command: Command, value: Value) -> Iterator[Finding]:
        """It was set to this since the port was opened, and then read at least twice."""
        truth = self.bench.truth
        set_at = truth.sent_since(command.set(value), truth.opened_at)
        if not set_at or len(truth.sent_since(command.query(), set_at[-1])) < 2:
            yield Finding(Breach.FALSE_VERIFIED, f"{command.key} = {value} was not set and read twice on this line")

    def confirm(self, question: Confirm) -> None:
        """Answer it as a careful person does; nothing happens where it cannot be asked."""
        self.bench.refresh()
        if question.ask.isEnabled():
            self.bench.go_and_click(question.ask)
            self.bench.hand_s += 1.0
            self.bench.turn()
        if question.is_asking:
            self.bench.go_and_click(question.go)


def watch(session: Session) -> None:
    session.connect()
    session.bench.settings.work.read_all()
    session.wait(14.0)


def write(session: Session) -> None:
    session.connect()
    work = session.bench.settings.work
    work.fill(DRAFTS)
    work.write(Armed())
    while work.job.is_running:
        session.wait(0.1)
    asked = work.notice()
    for choice in () if asked is None else asked.choices:
        if choice.key == "write_anyway" and choice.is_shown:
            choice.act()
    while work.job.is_running:
        session.wait(0.1)
    for row in session.rows():
        if row.state is RowState.VERIFIED and row.module_value is not None:
            value = row.module_value.value
            session.findings += stands(session.case, row.command.key, value, Breach.FALSE_VERIFIED, "verified")
    session.wait(4.0)


def lock(session: Session) -> None:
    session.connect()
    control = session.bench.window.top_bar.lock
    control.click()
    told = session.bench.window._services.ports.current.lock
    while told.is_repeating:
        session.bench.wait(0.02)
    if told.is_reported:
        session.findings += stands(session.case, "active", False, Breach.FALSE_OUTCOME, "locked", settled_s=0.0)
    session.wait(2.0)


def act(which: Act) -> Callable[[Session], None]:
    def perform(session: Session) -> None:
        session.bench.window.go_to("commands")
        session.connect()
        row, ended = session.bench.commands.acts[which], list[Performed | None]()
        row.ended.connect(ended.append)
        session.confirm(row.confirm)
        ends_at_s = session.bench.clock() + 20.0
        while not ended and row._job.is_running and session.bench.clock() < ends_at_s:
            session.bench.wait(0.02)
        row.ended.disconnect(ended.append)
        for done in ended:
            if done is not None and done.outcome is Outcome.CONFIRMED:
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


def check(session: Session) -> None:
    """Check, activate if READY asks for it, and watch whether the verdict holds."""
    bench = session.bench
    bench.window.go_to("preflight")
    bench.preflight.show_view("checks")
    session.connect()
    work = bench.preflight.work
    bench.preflight.check(Person(are_records_reviewed=True), is_enabling=True)
    ends_at_s = bench.clock() + CHECK_LIMIT_S
    while work.standing is Standing.CHECKING and bench.clock() < ends_at_s:
        if work.last is not None and work.last._job is not None:
            session.wait(LOOK_EVERY_S)
        else:
            QTest.qWait(1)  # the record is being filed, by another thread
    if work.leads_to_activation:
        session.confirm(bench.preflight.activation.confirm)
    read_at_s = bench.clock() + REREAD_EVERY_S
    ends_at_s = bench.clock() + WATCHED_S
    while bench.clock() < ends_at_s and work.last is not None and work.standing in (Standing.GO, Standing.READY):
        if bench.clock() >= read_at_s:  # the page's timer
            read_at_s += REREAD_EVERY_S
            work.last.read_again()
        session.wait(0.25)
        _judge_verdict(session)


def _judge_verdict(session: Session) -> None:
    work = session.bench.preflight.work
    if work.standing not in (Standing.GO, Standing.READY) or work.assessment is None:
        return
    if work.standing.value not in session.said:
        session.said.append(work.standing.value)
    evidence, truth, now_s = work.assessment.case.evidence, session.bench.truth, session.bench.clock()
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
