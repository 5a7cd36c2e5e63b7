"""A stream left on by a killed program is switched off by the next session."""

import time
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import closing
from pathlib import Path

import pytest

from app.procedures.stream import LISTEN_S, StreamSwitch, watch
from app.store.acts import StreamMemory
from app.store.fact_store import Store
from protocol.catalogue import SERIAL_OUTPUT, Request
from tests.support.line.sim_line import Rig
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import open_store

ON, OFF = SERIAL_OUTPUT.set(True), SERIAL_OUTPUT.set(False)
ADAPTER = "10c4:ea60:0001"


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path / "data")) as made:
        yield made


def watched(memory: StreamMemory, *, is_wanted: bool = True, **options: object) -> Rig:
    """In its first conversation."""
    switch = StreamSwitch(is_wanted=is_wanted)
    return Rig({"uptime": 60, "noise": 0} | options, background=lambda: watch(switch, memory=memory)).begin()


def end_watch(rig: Rig) -> None:
    """As at the end of a session."""
    background = rig.session._background
    assert background is not None
    background.cancel()
    rig.step_until(lambda: background.has_ended, limit_s=5)


def changes(rig: Rig) -> list[Request]:
    return [request for request in rig.line.requests if not request.is_repeatable]


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


class Slow(StreamMemory):
    """A slow disk."""

    def __init__(self) -> None:
        super().__init__()
        self.done: Future[None] = Future()

    def note_on(self, boot_count: int | None) -> Future[None]:
        return self.done


@pytest.mark.promise("c")
def test_the_intent_is_on_disk_before_the_stream_is_switched_on() -> None:
    memory = Slow()
    rig = watched(memory)
    rig.step_for(LISTEN_S + 5)
    assert changes(rig) == []
    memory.done.set_result(None)
    rig.step_for(1)
    assert changes(rig) == [ON]


@pytest.mark.parametrize(("boots", "is_wanted"), [(37, True), (None, False)])
@pytest.mark.promise("c")
def test_a_stream_left_on_is_switched_off(store: Store, boots: int | None, is_wanted: bool) -> None:
    store.set_state(f"stream:{ADAPTER}", {"boot_count": boots}).result(PATIENCE_S)
    memory = remembered(store)
    rig = watched(memory, is_wanted=is_wanted, stream_at_boot="yes")
    rig.step_for(LISTEN_S + 3)
    assert memory.is_taken_over
    assert changes(rig) == ([] if is_wanted else [OFF])
    end_watch(rig)
    assert changes(rig) == [OFF]
    assert not rig.bench.module.is_streaming
    wait_stored(store, is_on=False)
    assert memory.left_on is None


@pytest.mark.promise("c")
def test_another_module_on_the_same_adapter_is_left_as_it_was_found(store: Store) -> None:
    store.set_state(f"stream:{ADAPTER}", {"boot_count": 37}).result(PATIENCE_S)
    memory = remembered(store)
    rig = watched(memory, is_wanted=False, boots=38, stream_at_boot="yes")
    rig.step_for(LISTEN_S + 30)
    end_watch(rig)
    assert not memory.is_taken_over
    assert changes(rig) == []
    assert rig.bench.module.is_streaming
    wait_stored(store, is_on=False)
