"""What the background keeps fresh in each conversation, and that the stream is left as it was found."""

import time
from collections.abc import Iterator
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import pytest

from app.engine.procedure import Cancelled
from app.procedures.stream import LISTEN_S, StreamSwitch, watch
from app.store.acts import StreamMemory
from app.store.fact_store import Store
from protocol.catalogue import SERIAL_OUTPUT, Request
from protocol.events import Sent
from tests.module.options import Options
from tests.support.line.module_line import ModuleRig
from tests.support.line.sim_line import AnyRig, Rig
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import open_store

ON, OFF = SERIAL_OUTPUT.set(True), SERIAL_OUTPUT.set(False)
BRIEF_S = 0.2
ADAPTER = "10c4:ea60:0001"


def watched(
    switch: StreamSwitch | None = None,
    memory: StreamMemory | None = None,
    listen_s: float = LISTEN_S,
    is_streaming: bool = False,
    **options: object,
) -> Rig:
    """In its first conversation; each one gets the same switch and memory."""
    used, kept = switch or StreamSwitch(), memory or StreamMemory()
    background = lambda: watch(used, memory=kept, listen_s=listen_s)  # noqa: E731
    rig = Rig({"rate": 50} | options, background=background)
    if is_streaming:
        rig.bench.module.start_stream(rig.clock())
    return rig.begin()


def sets(rig: Rig) -> list[Request]:
    return [request for request in rig.line.requests if request.command is SERIAL_OUTPUT]


def end(rig: AnyRig) -> None:
    background = rig.session._background
    assert background is not None
    background.cancel()
    rig.step_until(lambda: background.has_ended, limit_s=5)
    assert isinstance(background.error, Cancelled)


@pytest.mark.parametrize("rate", [20, 50, 200, 1440])
@pytest.mark.parametrize("listen_s", [LISTEN_S, BRIEF_S])
@pytest.mark.promise("c")
def test_a_stream_is_switched_on_after_listening_and_off_at_the_end(rate: int, listen_s: float) -> None:
    rig = watched(rate=rate, listen_s=listen_s)
    rig.step_for(listen_s - 0.1)
    assert sets(rig) == []
    rig.step_for(0.3)
    assert sets(rig) == [ON]
    rig.session.samples.clear()
    rig.step_for(2.0)
    assert len(rig.session.samples) == pytest.approx(2 * rate, rel=0.01, abs=2)
    end(rig)
    assert sets(rig) == [ON, OFF]
    assert not rig.bench.module.is_streaming


@pytest.mark.parametrize("options", [Options(stream_hz=0), Options(stream_hz=0, lost_sets={0x13: -1})])
def test_a_module_that_does_not_stream_is_polled(options: Options) -> None:
    rig = ModuleRig(options, background=lambda: watch(StreamSwitch())).begin()
    rig.step_for(6)
    before = len(rig.module.log.got(0x32))
    rig.step_for(2)
    assert len(rig.module.log.got(0x32)) - before > 15
    assert [entry.frame for entry in rig.module.log.sets()].count(ON.encode()) == 1


@pytest.mark.promise("c")
def test_a_stream_that_may_be_on_without_an_acknowledgement_is_switched_off() -> None:
    rig = ModuleRig(Options(lost_answers={0x13: 1}), background=lambda: watch(StreamSwitch())).begin()
    rig.step_until(lambda: rig.module.log.sets(0x13))
    rig.step_for(1.0)
    end(rig)
    assert [entry.frame for entry in rig.module.log.sets()] == [ON.encode(), OFF.encode()]


def test_everything_is_read_first_and_kept_fresh() -> None:
    rig = watched()
    rig.step_for(0.5)
    assert {"light_threshold_v", "attitude_threshold_deg", "cell_voltage_v"} <= rig.conversation.values.keys()
    rig.session.events.clear()
    rig.step_for(25.0)
    asked: dict[str, list[float]] = {}
    for event in rig.session.events:
        if isinstance(event, Sent):
            asked.setdefault(event.request.command.name, []).append(event.at)
    for name, every_s in (("cell_voltage", 1.0), ("light", 1.0), ("attitude_threshold", 10.0), ("boot_count", 1.0)):
        assert max(later - sooner for sooner, later in pairwise(asked[name])) < 1.2 * every_s, name


def test_on_a_slow_line_the_status_does_not_starve_the_others() -> None:
    rig = watched(StreamSwitch(is_wanted=False), lag_ms=400.0)
    rig.step_for(20.0)
    before = len(rig.line.requests)
    rig.step_for(30.0)
    asked = {request.command.name for request in rig.line.requests[before:]}
    assert {"status", "cell_voltage", "light", "charging", "attitude_threshold"} <= asked


# A stream that an earlier conversation, or a killed program, left on


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path / "data")) as made:
        yield made


def remembered(store: Store) -> StreamMemory:
    """Once it was read: the store's thread does one thing after the other, and the fake clock does not wait for it."""
    memory = StreamMemory(store, ADAPTER)
    store.write(lambda facts: None).result(PATIENCE_S)
    return memory


def wait_stored(store: Store, is_on: bool) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while (store.state(f"stream:{ADAPTER}") is not None) is not is_on:
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.mark.parametrize(("boots", "is_wanted"), [(37, True), (None, False)])
@pytest.mark.promise("c")
def test_a_stream_left_on_is_switched_off(store: Store, boots: int | None, is_wanted: bool) -> None:
    store.set_state(f"stream:{ADAPTER}", {"boot_count": boots}).result(PATIENCE_S)
    memory = remembered(store)
    rig = watched(StreamSwitch(is_wanted=is_wanted), memory, is_streaming=True)
    rig.step_for(LISTEN_S + 3)
    assert sets(rig) == ([] if is_wanted else [OFF])
    end(rig)
    assert sets(rig) == [OFF]
    assert not rig.bench.module.is_streaming
    wait_stored(store, is_on=False)
    assert memory.left_on is None


@pytest.mark.promise("c")
def test_another_module_on_the_same_adapter_is_left_as_it_was_found(store: Store) -> None:
    store.set_state(f"stream:{ADAPTER}", {"boot_count": 37}).result(PATIENCE_S)
    memory = remembered(store)
    rig = watched(StreamSwitch(is_wanted=False), memory, boots=38, is_streaming=True)
    rig.step_for(LISTEN_S + 30)
    end(rig)
    assert sets(rig) == []
    assert rig.bench.module.is_streaming
    wait_stored(store, is_on=False)
