"""Nothing of a former module, port or connection is taken for the next one's."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pytestqt.qtbot import QtBot

from app.engine.device import DeviceView
from app.engine.identity import Trust
from app.engine.procedure import Pause, Procedure
from app.engine.target import Target
from app.engine.worker import Batch, Job, PortState
from app.procedures.lock import Locked
from app.safety.journal import Outcome
from app.safety.last_known import Activation
from protocol.catalogue import BY_NAME
from protocol.events import Sent
from tests.support.window.fake_ports import FakePorts
from ui.services.port import Ports
from ui.services.running_job import RunningJob
from ui.style.theme import Meaning

LIGHT = BY_NAME["light_threshold"]
ONE, TWO = Target("/dev/one", 115200), Target("/dev/two", 115200)


@pytest.fixture
def ports(qtbot: QtBot) -> Iterator[FakePorts]:
    fake = FakePorts()
    yield fake
    fake.stop()


def forever() -> Procedure[None]:
    while True:
        yield Pause(1.0)


def open_first(qtbot: QtBot, ports: FakePorts) -> Ports:
    first, _ = ports.plug_in(ONE.device, tilt_deg=11)
    qtbot.waitUntil(lambda: first.is_open)
    return ports.connector


def to_another_port(ports: FakePorts) -> None:
    ports.connector.connect_to(TWO)


def to_the_same_port(ports: FakePorts) -> None:
    ports.connector.connect_to(ONE)


def to_a_port_that_is_open(ports: FakePorts) -> None:
    ports.connector.choose(ports.connector.connections[1])


def by_a_persons_word(ports: FakePorts) -> None:
    ports.connector.current.treat_as_new()


CHANGES = (to_another_port, to_the_same_port, to_a_port_that_is_open, by_a_persons_word)


@pytest.mark.parametrize("change", [to_another_port, to_the_same_port])
def test_a_report_that_was_under_way_is_not_the_next_modules(
    qtbot: QtBot, ports: FakePorts, change: Callable[[FakePorts], None]
) -> None:
    connector = open_first(qtbot, ports)
    ports.workers[0].say(tilt_deg=12)  # read by the thread, not yet by the window
    change(ports)
    seen: list[Batch] = []
    connector.batch.connect(seen.append)
    assert (connector.current.device, connector.current.connection.state) == (DeviceView(), PortState.OPENING)
    qtbot.wait(50)
    assert seen == []
    assert connector.current.device == DeviceView()
    assert not connector.current.is_open
    assert connector.current.identity.trust is Trust.OPEN
    ports.workers[0].values.clear()
    ports.workers[0].say(tilt_deg=33)
    qtbot.waitUntil(lambda: connector.current.device.fresh("tilt_deg", ports.now_s) == 33)


@pytest.mark.parametrize("change", CHANGES)
def test_pages_are_told_before_anything_of_the_next_module(
    qtbot: QtBot, ports: FakePorts, change: Callable[[FakePorts], None]
) -> None:
    connector = open_first(qtbot, ports)
    second, _ = ports.plug_in("/dev/three", tilt_deg=22)
    qtbot.waitUntil(lambda: second.is_open)
    told: list[str] = []
    before = connector.current.kept
    connector.chosen.connect(lambda: told.append("chosen"))
    connector.changed.connect(lambda: told.append("changed"))
    connector.batch.connect(lambda _batch: told.append("batch"))
    connector.invalidated.connect(lambda: told.append("over"))
    connector.invalidated.connect(lambda: told.append("kept" if connector.current.kept is before else "new"))
    change(ports)
    assert told[:2] == ["over", "new"]
    assert told.count("over") == 1


@pytest.mark.parametrize("change", CHANGES)
def test_a_job_that_outlives_the_change_reports_to_nobody(
    qtbot: QtBot, ports: FakePorts, change: Callable[[FakePorts], None]
) -> None:
    connector = open_first(qtbot, ports)
    second, _ = ports.plug_in("/dev/three")
    qtbot.waitUntil(lambda: second.is_open)
    ended: list[Job[Any]] = []
    running = RunningJob(connector)
    running.run(forever(), ended.append)
    running.notify(Meaning.GOOD, lambda: "Read back as written.")
    connector.run(forever(), ended.append)
    jobs = [job for job, _ in ports.workers[0].jobs][-2:]
    change(ports)
    qtbot.waitUntil(lambda: not running.is_running)  # a switch waits a second for them
    assert running.result_notice() is None
    assert not connector.is_busy
    ports.workers[0].end_jobs()
    qtbot.waitUntil(lambda: all(job.is_done for job in jobs))
    qtbot.wait(50)
    assert ended == []


def test_an_unconfirmed_activation_outlives_a_new_connection_of_the_same_port(qtbot: QtBot, ports: FakePorts) -> None:
    """What may fire is not forgotten because somebody pressed "Connect again"."""
    connector = open_first(qtbot, ports)
    ports.workers[0].say(active=True)
    qtbot.waitUntil(lambda: connector.current.activation.state is Activation.ACTIVE)
    to_the_same_port(ports)
    assert connector.current.activation.state is Activation.WAS_ACTIVE
    to_another_port(ports)
    assert connector.current.activation.state is Activation.UNKNOWN


def test_what_any_page_wrote_is_known_to_the_port(qtbot: QtBot, ports: FakePorts) -> None:
    open_first(qtbot, ports)
    second, worker = ports.plug_in("/dev/three", light_threshold_v=1.8)
    qtbot.waitUntil(lambda: second.is_open)
    watch = second.kept.watch
    watch.observe(second.device, ports.now_s)
    request = LIGHT.set(2.0)
    ports.now_s += 1.0
    worker.hand_over(events=(Sent(request.encode(), request, 1, ports.now_s),))
    qtbot.wait(20)
    watch.observe(second.device, ports.now_s)  # still the reading before the write
    ports.now_s += 1.0
    worker.say(light_threshold_v=2.0)
    qtbot.waitUntil(lambda: second.device.fresh("light_threshold_v", ports.now_s) == 2.0)
    watch.observe(second.device, ports.now_s)
    assert watch.changed == {}
    ports.now_s += 1.0
    worker.say(light_threshold_v=0.4)  # nobody here wrote that
    qtbot.waitUntil(lambda: second.device.fresh("light_threshold_v", ports.now_s) == 0.4)
    watch.observe(second.device, ports.now_s)
    assert {one.after for one in watch.changed.values()} == {0.4}


@pytest.mark.parametrize("end", ["another connection", "silence"])
def test_locked_is_said_only_while_the_module_reports_it(qtbot: QtBot, ports: FakePorts, end: str) -> None:
    connector = open_first(qtbot, ports)
    lock = connector.current.lock
    lock.press()
    lock._finish(Locked(outcome=Outcome.CONFIRMED, sent=1))
    ports.now_s += 1.0
    ports.workers[0].say(active=False)
    qtbot.wait(20)
    assert lock.is_reported
    if end == "silence":
        ports.now_s += 20.0
        ports.workers[0].hand_over()
    else:
        to_the_same_port(ports)
    qtbot.waitUntil(lambda: not lock.is_reported)
    ports.workers[0].say(active=False)
    qtbot.wait(20)
    assert lock.is_reported is (end == "silence")
