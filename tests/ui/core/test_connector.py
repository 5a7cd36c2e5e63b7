"""Several ports, one of which the pages show."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from PySide6.QtWidgets import QPushButton
from pytestqt.qtbot import QtBot

from app.engine.procedure import Pause, Procedure
from app.engine.target import Target
from app.engine.worker import Batch, Job, PortState
from app.safety.last_known import Activation
from tests.support.window.fake_ports import FakePorts
from ui.services.port import SETTLE_MS


@pytest.fixture
def ports(qtbot: QtBot) -> Iterator[FakePorts]:
    fake = FakePorts()
    yield fake
    fake.stop()


def wait_for(qtbot: QtBot, is_so: Callable[[], bool]) -> None:
    qtbot.waitUntil(is_so)


def forever() -> Procedure[None]:
    while True:
        yield Pause(1.0)


def test_the_pages_see_a_chosen_module_as_a_new_connection(qtbot: QtBot, ports: FakePorts) -> None:
    first, worker = ports.plug_in("/dev/one", tilt_deg=11)
    second, other = ports.plug_in("/dev/two", tilt_deg=22)
    wait_for(qtbot, lambda: first.is_open and second.is_open)
    connector, seen, online = ports.connector, list[tuple[str, PortState, object]](), list[Target]()

    def on_batch(batch: Batch) -> None:
        tilt = connector.current.device.fresh("tilt_deg", ports.now_s)
        seen.append((batch.connection.port, connector.current.connection.state, tilt))

    connector.batch.connect(on_batch)
    connector.came_online.connect(online.append)
    other.say(tilt_deg=23)
    wait_for(qtbot, lambda: second.device.fresh("tilt_deg", ports.now_s) == 23)
    assert seen == []  # only the current port is seen
    connector.choose(second)
    assert seen == [("/dev/two", PortState.OPENING, None), ("/dev/two", PortState.OPEN, 23)]
    assert online == [second.target]
    assert (connector.current.adapter_key, connector.current) == ("/dev/two", second)
    assert (worker.opened, other.opened) == (["/dev/one"], ["/dev/two"])  # neither was opened again
    assert first.is_open
    worker.say(tilt_deg=12)
    wait_for(qtbot, lambda: first.device.fresh("tilt_deg", ports.now_s) == 12)
    assert len(seen) == 2
    connector.connect_to(Target("/dev/one", 115200))  # open already
    assert connector.current is first
    assert worker.opened == ["/dev/one"]


def test_activation_is_unknown_while_another_module_comes_into_view(qtbot: QtBot, ports: FakePorts) -> None:
    ports.plug_in("/dev/one")
    second, _ = ports.plug_in("/dev/two", active=True)
    connector, seen = ports.connector, list[Activation]()
    wait_for(qtbot, lambda: second.activation.state is Activation.ACTIVE and connector.current.is_open)
    connector.batch.connect(lambda _batch: seen.append(connector.current.activation.state))
    connector.choose(second)
    assert seen[:2] == [Activation.UNKNOWN, Activation.ACTIVE]


def test_what_a_page_does_ends_before_another_module_is_shown(qtbot: QtBot, ports: FakePorts) -> None:
    _, worker = ports.plug_in("/dev/one")
    second, _ = ports.plug_in("/dev/two")
    connector, ended = ports.connector, list[str]()
    wait_for(qtbot, lambda: second.is_open and connector.current.is_open)

    def end(_job: Job[Any]) -> None:
        ended.append(connector.current.adapter_key)

    connector.run(forever(), end)
    connector.choose(second)
    assert connector.current.adapter_key == "/dev/one"
    worker.end_jobs()
    wait_for(qtbot, lambda: connector.current.adapter_key == "/dev/two")
    assert ended == ["/dev/one"]


def test_a_port_that_hangs_does_not_keep_another_module_from_being_shown(qtbot: QtBot, ports: FakePorts) -> None:
    ports.plug_in("/dev/one")
    second, _ = ports.plug_in("/dev/two")
    connector, ended = ports.connector, list[Job[Any]]()
    wait_for(qtbot, lambda: second.is_open and connector.current.is_open)
    connector.run(forever(), ended.append)
    connector.choose(second)
    wait_for(qtbot, lambda: connector.current is second)
    assert ended == []
    assert SETTLE_MS <= 1000


def test_lock_all_reaches_every_open_port_and_waits_for_none(qtbot: QtBot, ports: FakePorts) -> None:
    for name in ("one", "two", "three"):
        ports.plug_in(f"/dev/{name}", active=True)
    connector = ports.connector
    wait_for(qtbot, lambda: all(one.is_open for one in connector.connections))
    assert connector.is_any_active
    connector.lock.press_all()  # none of the jobs ends: all three hang
    assert [len(one.wanted(is_urgent=True)) for one in ports.workers] == [1, 1, 1]
    assert connector.current.lock.is_repeating
    connector.choose(connector.connections[1])
    assert not any(job.run.is_done for one in ports.workers for job in one.wanted(is_urgent=True))
    ports.workers[0].unplug()
    wait_for(qtbot, lambda: not connector.connections[0].is_open)
    assert connector.connections[0].lock.is_unproven  # it waits for the port
    assert connector.current.lock.failed is None
    assert connector.current.lock.is_repeating


def test_lock_is_possible_as_soon_as_another_module_is_shown(qtbot: QtBot, ports: FakePorts) -> None:
    first, _ = ports.plug_in("/dev/one")
    second, worker = ports.plug_in("/dev/two", active=True)
    wait_for(qtbot, lambda: first.is_open and second.is_open)
    button = QPushButton()
    qtbot.addWidget(button)
    ports.connector.lock.bind(button)
    ports.connector.choose(second)
    button.click()
    assert len(worker.wanted(is_urgent=True)) == 1


def test_a_port_that_is_removed_is_closed_and_another_stays(qtbot: QtBot, ports: FakePorts) -> None:
    first, _ = ports.plug_in("/dev/one")
    second, worker = ports.plug_in("/dev/two")
    connector = ports.connector
    wait_for(qtbot, lambda: first.is_open and second.is_open)
    connector.remove(first)  # the current one is not
    assert connector.connections == (first, second)
    connector.remove(second)
    worker.hand_over()
    wait_for(qtbot, lambda: worker.is_stopped)
    assert connector.connections == (first,)
    assert first.is_open
