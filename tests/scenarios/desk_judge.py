"""Compares what the window shows with what the module holds."""

from collections.abc import Iterable
from typing import Final

from app.engine.device import How, StaleReason
from app.procedures.act import Performed
from app.procedures.lock import Locked
from app.procedures.power_cycle import PowerCycleResult, Retention
from app.procedures.write_all import WriteReport
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.settings.form import FormRow, RowState
from app.settings.profiles import Match, Profile, compare
from protocol.catalogue import BY_NAME, Command
from protocol.fields import Value
from protocol.link_states import Presence
from protocol.messages import Source
from tests.scenarios.desk import Desk
from tests.scenarios.desk_ledger import Truth

READABLE: Final = ("light_threshold", "attitude_threshold", "freefall_acceleration", "freefall_time")
FLAGS: Final = {
    "attitude_trigger": "attitude_is_enabled",
    "freefall_trigger": "freefall_is_enabled",
    "serial_output": "serial_output_is_on",
}
"""E8: written and never read; maps the name to the simulated module's."""
KEYS: Final = {BY_NAME[name].key: BY_NAME[name] for name in (*READABLE, *FLAGS)}
_FORGETTABLE: Final = (*KEYS, "active")
_SURE: Final = (RowState.READ, RowState.ACKNOWLEDGED, RowState.VERIFIED)
ANSWER_S: Final = 1.05
"""The vendor's 1 s, and the time step in which it ends."""
_MEANWHILE_S: Final = 10.0
"""Longer than an act and the reading after it take."""


def value_of(command: Command, raw: int) -> Value:
    """Return a value in the field's unit; flags use the lowest bit."""
    assert command.write is not None
    return command.write.decode(raw if command.name in READABLE else raw & 1)


class Judge:
    """Checks the window's claims about writes and acts as they are made."""

    def __init__(self, desk: Desk) -> None:
        self.truth = Truth()
        self._desk = desk
        desk.on_write, desk.on_survive = self._judge_write, self._judge_survival
        desk.on_perform, desk.on_lock = self._judge_act, self._judge_lock

    # What happened to the module

    def restarted(self) -> None:
        """Note a power cycle, after which the module has forgotten what it does not keep."""
        self.truth.change(_FORGETTABLE, self._desk.clock(), is_audible=self._desk.is_listening)

    def somebody_activated(self) -> None:
        self.truth.change(("active",), self._desk.clock(), is_audible=False)

    # What is said

    def rows(self) -> None:
        desk = self._desk
        for row in desk.rows():
            self._judge_row(row)
        profile = Profile(name="P", settings={key: value_of(command, 1) for key, command in KEYS.items()})
        for one in compare(profile, desk.view, desk.clock()):
            if one.match is Match.SAME and one.wanted is not None and one.stands is not None:
                self._judge_claim(one.command, one.wanted, one.stands.how, one.stands.at)

    def _judge_row(self, row: FormRow) -> None:
        desk, stands = self._desk, row.module_value
        if row.state is RowState.WRITING:
            assert desk.is_busy, f"{row.command.name} is being written by nobody"
        if stands is None:
            assert row.state not in _SURE
            assert row.state is not RowState.STALE
            return
        if row.command.name in FLAGS:
            assert stands.stale_reason is not StaleReason.RESTARTED, (
                f"{row.command.name} cannot be known after a restart"
            )
        if not desk.is_open or desk.view.presence is Presence.OFFLINE:
            assert stands.is_stale, f"{row.command.name} is shown as certain without a link"
        if not stands.is_stale:
            self._judge_claim(row.command, stands.value, stands.how, stands.at)
        if row.state in _SURE:
            assert not stands.is_stale
        if row.state is RowState.VERIFIED:
            assert stands.how is How.READ
            self._judge_proof(row.command, stands.value)

    def _judge_proof(self, command: Command, value: Value) -> None:
        """Assert that it was set once, to this, since the port was opened, and then read at least twice."""
        last = self._desk.ledger.last_set(command.code)
        assert last is not None
        at, request = last
        assert at >= self._desk.opened_at, f"{command.name} was proven before the port was lost"
        if not self.truth.is_excused(command.key, at, self._desk.clock()):
            assert at >= self.truth.changed_at(command.key), f"{command.name} was proven before the restart"
        assert request == command.set(value)
        assert command.reads_back
        assert self._desk.ledger.sent_since(command.query(), at) >= 2

    def _judge_claim(self, command: Command, value: Value, how: How, at: float) -> None:
        desk, module = self._desk, self._desk.bench.module
        now = desk.clock()
        if self.truth.is_excused(command.key, at, now) or self._is_set_under_way(command, at, now):
            return
        said = f"{command.name} is said to be {value} ({how.value} {now - at:.3f} s ago)"
        assert at >= self.truth.changed_at(command.key), f"{said}, but the module has restarted since"
        if command.name in READABLE:
            holds = value_of(command, getattr(module.memory, command.name))
            assert how is not How.READ or holds == value, f"{said}, and it holds {holds}"
        elif module.quirks.keeps and (how is How.ACKNOWLEDGED or self.truth.is_calm(now)):
            holds = getattr(module.state, FLAGS[command.name])
            assert holds == value, f"{said}, and it is {holds}"

    def _is_set_under_way(self, command: Command, at: float, now: float) -> bool:
        """Return whether a set of it is pending, so that the last known value still counts."""
        last = self._desk.ledger.last_set(command.code)
        return last is not None and at <= last[0] and now - last[0] <= ANSWER_S

    def _judge_write(self, report: WriteReport) -> None:
        for written in report.results:
            if written.verified:
                assert written.command.reads_back
                self._judge_claim(written.command, written.wanted, How.READ, self._desk.clock())
                self._judge_proof(written.command, written.wanted)

    def _judge_survival(self, survival: PowerCycleResult) -> None:
        for key, stamp in survival.stamps.items():
            if stamp.result is Retention.RETAINED:
                self._judge_claim(KEYS[key], stamp.wanted, How.READ, self._desk.clock())

    def _judge_lock(self, locked: Locked) -> None:
        if locked.is_locked:
            self._judge_active(is_expected=False)

    def _judge_act(self, done: Performed) -> None:
        desk, module = self._desk, self._desk.bench.module
        now = desk.clock()
        if done.outcome is not Outcome.CONFIRMED:
            return
        match done.act:
            case Act.ACTIVATE:
                self._judge_active(is_expected=True)
            case Act.SHUTDOWN:
                assert not module.is_on or self.truth.is_excused("active", now, now)
            case Act.FORBID_DEPLOY:
                if not self._has_changed_since(now - _MEANWHILE_S):
                    assert module.state.is_forbidden
            case Act.DEPLOY:
                assert any(Source.SERIAL.value & record[3] for record in module.memory.records)
            case _:
                pass

    def _judge_active(self, *, is_expected: bool) -> None:
        now = self._desk.clock()
        if not self.truth.is_excused("active", now, now):
            assert self._desk.bench.module.state.is_active is is_expected

    def _has_changed_since(self, at: float) -> bool:
        """Return whether the module was restarted, activated or locked since `at`."""
        ledger = self._desk.ledger
        others: Iterable[Act] = (Act.LOCK, Act.ACTIVATE, Act.DEPLOY)
        return self.truth.changed_at("active") >= at or any(ledger.sent_since(REQUESTS[act], at) for act in others)
