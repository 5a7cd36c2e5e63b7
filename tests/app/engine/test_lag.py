"""A line that holds everything back, streamed reports included: what is old is never taken for what is so now."""

from collections.abc import Callable
from typing import Any

import pytest

from app.cli.read import Findings, page_of
from app.engine.device import StaleReason
from app.engine.procedure import Procedure
from app.preflight.evidence import FlagState
from app.preflight.run import _enable
from app.procedures.act import perform
from app.procedures.baud import change_baud
from app.procedures.read import read_everything
from app.procedures.who_is_there import who_is_there
from app.procedures.write_all import SettingChange, WriteContext, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from protocol.catalogue import BY_NAME, STATUS
from protocol.events import Received, Role
from protocol.lag import Lag
from protocol.messages import Status
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig, watched
from tests.support.thorough import IS_THOROUGH

LAGS_MS = (300.0, 700.0, 900.0, 1200.0, 2000.0) if IS_THOROUGH else (300.0, 900.0, 2000.0)
HZ = (None, 2.0, 50.0) if IS_THOROUGH else (None, 20.0)
AGES_S = (0.05, 0.4, 0.9, 1.3, 1.9) if IS_THOROUGH else (0.4, 1.3)
"""For how long the module has been active when the act is decided."""


def lagging(lag_ms: float, hz: float | None, **options: Any) -> Rig:
    """The line was quick while the module was connected; then the bridge began to hold things back."""
    stream: dict[str, Any] = {} if hz is None else {"rate": hz, "stream_at_boot": True}
    rig = Rig({"uptime": 60, "noise": 0} | stream | options)
    rig.run(read_everything())
    rig.bench.change(lag_ms=lag_ms)
    rig.step_for(4.0)
    return rig


class Arrivals:
    """When each change arrives at the module, and since when that had been active then."""

    def __init__(self, rig: Rig) -> None:
        self.active_for_s: list[tuple[str, float]] = []
        self._active_at: float | None = None
        self._rig = rig
        self._hear = rig.bench.module.receive
        rig.bench.module.receive = self._watch  # type: ignore[method-assign]

    def activate(self) -> None:
        self._active_at = self._rig.clock()
        self._rig.bench.module.activate(is_active=True)

    def _watch(self, data: bytes, now_s: float) -> Any:
        if self._active_at is not None:
            for name, request in CHANGES.items():
                if data == request:
                    self.active_for_s.append((name, now_s - self._active_at))
        return self._hear(data, now_s)


WANTED = [SettingChange(BY_NAME["freefall_time"], 1.2)]
CHANGES: dict[str, bytes] = {
    "zero": REQUESTS[Act.ZERO].encode(),
    "shutdown": REQUESTS[Act.SHUTDOWN].encode(),
    "activate": REQUESTS[Act.ACTIVATE].encode(),
    "write": BY_NAME["freefall_time"].set(1.2).encode(),
    "baud": BY_NAME["baud_rate"].set(57600).encode(),
    "trigger": BY_NAME["attitude_trigger"].set(True).encode(),
}


def permit(rig: Rig, act: Act) -> Permit:
    return Permit(act, Origin.COMMAND_LINE, rig.clock())


WAYS: dict[str, Callable[[Rig], Procedure[Any]]] = {
    "zero": lambda rig: perform(Act.ZERO, FakeJournal(), permit=permit(rig, Act.ZERO)),
    "shutdown": lambda rig: perform(Act.SHUTDOWN, FakeJournal(), permit=permit(rig, Act.SHUTDOWN)),
    "activate": lambda rig: perform(Act.ACTIVATE, FakeJournal(), permit=permit(rig, Act.ACTIVATE)),
    "write": lambda _rig: write_all(WANTED, WriteContext(journal=FakeJournal())),
    "baud": lambda rig: change_baud(57600, FakeJournal(), permit=permit(rig, Act.CHANGE_BAUD)),
    "trigger": lambda _rig: _enable(BY_NAME["attitude_trigger"], WriteContext(journal=FakeJournal())),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.promise("h")
def test_nothing_is_sent_to_a_module_that_has_been_active_for_longer_than_a_second(way: str) -> None:
    for lag_ms in LAGS_MS:
        for hz in HZ:
            for age_s in AGES_S:
                rig = lagging(lag_ms, hz)
                arrivals = Arrivals(rig)
                arrivals.activate()
                rig.step_for(age_s)
                rig.run(WAYS[way](rig), limit_s=200)
                where = (lag_ms, hz, age_s)
                assert all(age < 1.0 for _name, age in arrivals.active_for_s), where
                if lag_ms > 1000:
                    assert arrivals.active_for_s == [], where


@pytest.mark.parametrize("hz", HZ)
@pytest.mark.parametrize("lag_ms", LAGS_MS)
@pytest.mark.promise("h")
def test_a_module_that_lies_at_80_degrees_is_not_activated(lag_ms: float, hz: float | None) -> None:
    for age_s in (1.0, 1.5, 2.0):
        rig = lagging(lag_ms, hz)
        rig.bench.set_world(tilt_deg=80.0)
        rig.step_for(age_s)
        done = rig.run(WAYS["activate"](rig))
        assert done.outcome is Outcome.NOT_SENT
        assert not rig.bench.module.state.is_active


@pytest.mark.parametrize("hz", HZ)
@pytest.mark.parametrize("lag_ms", [1200.0, 2000.0])
def test_beyond_a_second_acts_are_refused_with_the_reason(lag_ms: float, hz: float | None) -> None:
    rig = lagging(lag_ms, hz)
    done = rig.run(WAYS["zero"](rig))
    assert done.outcome is Outcome.NOT_SENT
    assert Interlock.FRESH_STATUS in [refusal.condition for refusal in done.refusals]
    if hz is not None:
        assert any("late" in refusal.sentence for refusal in done.refusals), [
            refusal.sentence for refusal in done.refusals
        ]


@pytest.mark.parametrize("hz", HZ)
@pytest.mark.parametrize("lag_ms", [0.0, 100.0, 200.0])
@pytest.mark.parametrize("way", ["zero", "shutdown", "activate", "write"])
def test_on_a_line_with_quick_answers_everything_works(way: str, lag_ms: float, hz: float | None) -> None:
    rig = lagging(lag_ms, hz)
    done = rig.run(WAYS[way](rig))
    if way == "write":
        assert [written.verified for written in done.results] == [True]
    else:
        assert done.outcome is Outcome.CONFIRMED


@pytest.mark.parametrize("way", ["zero", "shutdown", "activate", "write"])
def test_where_asking_who_is_there_takes_longer_than_a_second_nothing_is_sent(way: str) -> None:
    rig = lagging(700.0, None)
    rig.run(WAYS[way](rig), limit_s=200)
    assert CHANGES[way] not in rig.line.sent


def test_the_trigger_is_enabled_only_where_the_status_is_proven() -> None:
    for lag_ms, fate in ((100.0, FlagState.ENABLED), (2000.0, FlagState.NOT_SENT)):
        rig = lagging(lag_ms, 50.0)
        assert rig.run(WAYS["trigger"](rig)).state is fate
        assert (CHANGES["trigger"] in rig.line.sent) is (fate is FlagState.ENABLED)


@pytest.mark.parametrize("hz", HZ)
@pytest.mark.parametrize("lag_ms", [1200.0, 2000.0, 4000.0, 8000.0])
@pytest.mark.promise("h")
def test_a_long_lag_is_measured_and_makes_the_status_stale(lag_ms: float, hz: float | None) -> None:
    rig = lagging(0.0, hz)
    watched(rig)
    rig.step_for(4.0)
    now = rig.clock()
    view = rig.session.device.view(now)
    assert view.lag_s is not None
    assert view.lag_s < 0.1
    assert view.fresh("tilt_deg", now) is not None
    rig.bench.change(lag_ms=lag_ms)
    rig.step_for(15.0)
    for _ in range(100):
        rig.step_for(0.1)
        now = rig.clock()
        view = rig.session.device.view(now)
        assert view.fresh("tilt_deg", now) is None
        if hz in (20.0, 50.0):
            known = view.known("tilt_deg", now)
            assert known is not None
            assert known.stale_reason in (StaleReason.LATE, StaleReason.LINK_LOST)
    rig.bench.change(lag_ms=0.0)
    rig.step_for(2 * lag_ms / 1000 + 15.0)
    now = rig.clock()
    assert rig.session.device.view(now).fresh("tilt_deg", now) is not None


def test_the_lag_includes_what_queues_on_the_line() -> None:
    rig = lagging(400.0, 50.0)
    watched(rig)
    rig.step_for(3.0)
    lag_s = rig.session.link_view().lag_s
    assert lag_s is not None
    assert 0.4 <= lag_s < 0.6


def test_a_line_that_loses_a_fifth_is_not_taken_for_a_late_one() -> None:
    rig = Rig({"drop": 0.2, "rate": 50, "stream_at_boot": True, "seed": 3})
    watched(rig)
    late = 0
    rig.step_for(5.0)
    for _ in range(300):
        rig.step_for(0.1)
        late += rig.session.device.view(rig.clock()).is_late
    assert late <= 15


def test_what_a_restart_says_unasked_proves_nothing() -> None:
    """Its heartbeats were taken for the answer to one that was asked, with old reports behind them."""
    rig = lagging(0.0, 50.0)
    lag = rig.session._link.lag
    rig.run(who_is_there())
    before = lag.sent_after
    lag.ask(BY_NAME["heartbeat"].query(), rig.clock())
    lag.answer(BY_NAME["heartbeat"].query(), rig.clock() + 0.01)
    assert lag.sent_after == before


def test_an_answer_that_may_be_an_earlier_ones_proves_only_the_earlier_moment() -> None:
    boot_count = BY_NAME["boot_count"].query()
    lag = Lag(0.0)
    lag.ask(boot_count, 1.0)
    lag.ask(boot_count, 2.0)
    lag.answer(boot_count, 2.1)
    assert lag.sent_after == 1.0
    assert lag.seconds(2.1) == pytest.approx(1.1)
    lag.ask(BY_NAME["charging"].query(), 3.0)
    lag.answer(BY_NAME["charging"].query(), 3.1)
    assert lag.sent_after == 3.0
    assert lag.seconds(3.1) == pytest.approx(0.1)


@pytest.mark.promise("h")
def test_every_status_is_at_least_as_new_as_it_is_said_to_be() -> None:
    """Against the module's own memory of when it said what."""
    proven = 0
    for lag_ms in (0.0, 250.0, 800.0, 1500.0):
        for hz in HZ:
            rig = lagging(lag_ms, hz)
            watched(rig)
            said: dict[bytes, float] = {}
            module = rig.bench.module
            for turn in range(200):
                module.world.tilt_deg = float(turn % 180)
                said[bytes(module.status(rig.clock()))] = rig.clock() + 0.05
                rig.step_for(0.05)
                for event in rig.session.take_events():
                    if not isinstance(event, Received) or not isinstance(event.message, Status):
                        continue
                    if event.role in (Role.ANSWER, Role.STREAMED) and event.frame.raw in said:
                        assert said[event.frame.raw] >= event.sent_after, (lag_ms, hz, turn)
                        proven += event.sent_after > 0
    assert proven > 1000


def test_a_status_is_asked_for_behind_another_question() -> None:
    rig = lagging(0.0, 50.0)
    rig.line.sent.clear()
    rig.run(who_is_there())
    assert [request.command.name for request in rig.line.requests] == [
        "boot_count",
        "active",
        "triggered",
        STATUS.name,
        "boot_count",
    ]


@pytest.mark.parametrize("hz", [None, 2.0, 50.0])
@pytest.mark.promise("h")
def test_a_reading_over_a_long_lag_does_not_say_that_the_module_answers_quickly(hz: float | None) -> None:
    """A streamed report that passes for the answer to a question is no round trip."""
    stream: dict[str, Any] = {} if hz is None else {"rate": hz, "stream_at_boot": True}
    rig = Rig({"uptime": 60, "noise": 0} | stream)
    rig.bench.change(lag_ms=1500.0)
    rig.step_for(2.0)
    rig.run(read_everything())
    link = rig.session.link_view()
    assert link.round_trip_median_s is None or link.round_trip_median_s >= 1.5
    assert link.lag_s == pytest.approx(1.5, abs=0.1)
    head = page_of(Findings("p", 115200, link.round_trip_median_s, {}, {}, lag_s=link.lag_s))[0]
    assert head.startswith("p, 115200 baud, 1.5 s")


def test_a_streaming_module_on_a_quick_line_still_has_its_round_trips() -> None:
    rig = Rig({"uptime": 60, "noise": 0, "rate": 50.0, "stream_at_boot": True})
    rig.run(read_everything())
    assert (rig.session.link_view().round_trip_median_s or 1.0) < 0.05
