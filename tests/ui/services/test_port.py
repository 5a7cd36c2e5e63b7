"""Several ports, one of which the pages show; nothing of a former module, port or connection is taken for the next."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import pytest
from app.engine.device import DeviceView
from app.engine.identity import Trust
from pytestqt.qtbot import QtBot
from ui.services.port import SETTLE_MS, Ports

from app.diagnosis.link_state import Phase
from app.engine.procedure import LinkView, Pause, Procedure, Slept
from app.engine.target import Target
from app.engine.worker import Batch, Job, PortState
from app.limits.out_of_limits import LimitsInUse
from app.procedures.find import RateSearch
from app.procedures.lock import Locked
from app.safety.journal import Outcome
from app.safety.last_known import Activation
from app.store.stream_memory import StreamMemory
from protocol.catalogue import BY_NAME
from protocol.events import Counters, Sent
from tests.support.window.fake_ports import FakePorts, ports_alone
from ui.session.module_field import ModuleField
from ui.session.running_job import RunningJob
from ui.shell.top_bar import TopBar
from ui.style.theme import Meaning


@pytest.fixture
def ports(qtbot: QtBot) -> Iterator[FakePorts]:
    fake = ports_alone()
    yield fake
    fake.stop()


def forever() -> Procedure[None]:
    while True:
        yield Pause(1.0)


@pytest.mark.parametrize(("found", "asked"), [(RateSearch(None, ()), 2), (RateSearch(9600, ()), 1), (Slept(9.0), 2)])
def test_where_no_rate_is_found_the_line_is_asked_for_what_is_on_it(
    qtbot: QtBot, ports: FakePorts, monkeypatch: pytest.MonkeyPatch, found: RateSearch | Slept, asked: int
) -> None:
    port, (worker,) = ports.ports.current, ports.workers
    port.connect_to(Target("/dev/one", 115200, finds_rate=True))
    ((search, _),) = worker.jobs
    worker.say()
    qtbot.waitUntil(lambda: port.state.phase is Phase.FINDING)
    if isinstance(found, Slept):
        worker.end_jobs(found)
    else:
        monkeypatch.setattr(search, "outcome", lambda: found)
        worker.hand_over(finished=(search,))
    qtbot.waitUntil(lambda: port.state.phase is not Phase.FINDING)
    assert len(worker.jobs) == asked


def test_a_lock_that_never_left_is_not_said_to_have_been_sent(qtbot: QtBot, ports: FakePorts) -> None:
    port, worker = ports.plug_in("/dev/one", active=True)
    qtbot.waitUntil(lambda: port.is_open)
    worker.unplug()
    qtbot.waitUntil(lambda: not port.is_open)
    port.lock.ensure_locked()
    assert port.lock.is_repeating
    port.disconnect_port()
    assert port.lock.failed == Locked(outcome=Outcome.NOT_SENT, sent=0, is_port_lost=True)


@pytest.mark.promise("l")
def test_the_pages_see_a_chosen_module_as_a_new_connection(qtbot: QtBot, ports: FakePorts) -> None:
    first, worker = ports.plug_in("/dev/one", tilt_deg=11)
    second, other = ports.plug_in("/dev/two", tilt_deg=22)
    qtbot.waitUntil(lambda: first.is_open and second.is_open)
    connector, seen, online = ports.ports, list[tuple[str, PortState, object]](), list[Target]()

    def on_batch(batch: Batch) -> None:
        tilt = connector.current.module.view.fresh("tilt_deg", ports.now_s)
        seen.append((batch.connection.port, connector.current.connection.state, tilt))

    connector.batch.connect(on_batch)
    connector.came_online.connect(online.append)
    other.say(tilt_deg=23)
    qtbot.waitUntil(lambda: second.device.fresh("tilt_deg", ports.now_s) == 23)
    assert seen == []  # only the current port is seen
    first.stream.is_wanted = True
    connector.choose(second)
    assert (first.stream.is_wanted, second.stream.is_wanted) == (False, True)  # of the one that is shown
    assert other.publish_every_s < worker.publish_every_s
    assert seen == [("/dev/two", PortState.OPENING, None), ("/dev/two", PortState.OPEN, 23)]
    assert online == [second.target]
    assert (connector.current.adapter_key, connector.current) == ("/dev/two", second)
    assert (worker.opened, other.opened) == (["/dev/one"], ["/dev/two"])  # neither was opened again
    assert first.is_open
    worker.say(tilt_deg=12)
    qtbot.waitUntil(lambda: first.device.fresh("tilt_deg", ports.now_s) == 12)
    assert len(seen) == 2
    connector.connect_to(Target("/dev/one", 115200))  # open already
    assert connector.current is first
    assert worker.opened == ["/dev/one"]


def test_one_name_is_of_one_module(qtbot: QtBot, ports: FakePorts) -> None:
    (first, _), (second, _) = ports.plug_in("/dev/one"), ports.plug_in("/dev/two")
    qtbot.waitUntil(lambda: first.is_open and second.is_open)
    for port, names in ((first, ("M-07", "")), (second, ("", "M-07")), (first, ("M-07", ""))):
        port.module.choose("M-07")
        qtbot.wait(50)
        assert (first.module.name, second.module.name) == names
    first.module.choose("")
    second.module.choose("M-08")
    assert (first.module.name, second.module.name) == ("", "M-08")


def test_each_field_shows_the_name_that_another_one_gave(qtbot: QtBot, ports: FakePorts) -> None:
    ports.plug_in("/dev/one")
    field = ModuleField("field", ports.ports)
    qtbot.addWidget(field)
    ports.ports.current.module.choose("M-07")
    assert field.currentText() == "M-07"


def test_a_stream_is_remembered_for_the_target_that_is_opened(
    ports: FakePorts, monkeypatch: pytest.MonkeyPatch
) -> None:
    memories, port = dict[str, StreamMemory](), ports.ports.current
    monkeypatch.setattr(port, "_memory_of", lambda target: memories.setdefault(target.device, StreamMemory()))
    for device in ("/dev/one", "/dev/two"):
        port.connect_to(Target(device, 115200))
        assert port.stream_memory is memories[device]


def test_each_port_counts_its_own_frames(qtbot: QtBot, ports: FakePorts) -> None:
    (first, worker), (second, _) = ports.plug_in("/dev/one"), ports.plug_in("/dev/two")
    qtbot.waitUntil(lambda: first.is_open and second.is_open)
    worker.hand_over(link=LinkView(Counters(sent=7), 0.002, 0.003))
    qtbot.waitUntil(lambda: first.kept.statistics.totals.sent == 7)
    assert second.kept.statistics.totals.sent == 0


def test_that_lock_was_pressed_is_shown_at_once(qtbot: QtBot, ports: FakePorts) -> None:
    port, _ = ports.plug_in("/dev/one", active=True)
    qtbot.waitUntil(lambda: port.lock.is_possible)
    seen: list[bool] = []
    ports.ports.lock_changed.connect(lambda: seen.append(port.lock.is_repeating))
    port.lock.press()
    assert seen == [True]


def test_activation_is_unknown_while_another_module_comes_into_view(qtbot: QtBot, ports: FakePorts) -> None:
    ports.plug_in("/dev/one")
    second, _ = ports.plug_in("/dev/two", active=True)
    connector, seen = ports.ports, list[Activation]()
    qtbot.waitUntil(lambda: second.activation.state is Activation.ACTIVE and connector.current.is_open)
    connector.batch.connect(lambda _batch: seen.append(connector.current.activation.state))
    connector.choose(second)
    assert seen[:2] == [Activation.UNKNOWN, Activation.ACTIVE]


@pytest.mark.promise("l")
def test_what_a_page_does_ends_before_another_module_is_shown(qtbot: QtBot, ports: FakePorts) -> None:
    _, worker = ports.plug_in("/dev/one")
    second, _ = ports.plug_in("/dev/two")
    connector, ended = ports.ports, list[str]()
    qtbot.waitUntil(lambda: second.is_open and connector.current.is_open)

    def end(_job: Job[Any]) -> None:
        ended.append(connector.current.adapter_key)

    connector.run(forever(), end)
    connector.choose(second)
    assert connector.current.adapter_key == "/dev/one"
    worker.end_jobs()
    qtbot.waitUntil(lambda: connector.current.adapter_key == "/dev/two")
    assert ended == ["/dev/one"]


def test_the_last_choice_counts_also_before_the_first_is_shown(qtbot: QtBot, ports: FakePorts) -> None:
    first, worker = ports.plug_in("/dev/one")
    second, _ = ports.plug_in("/dev/two")
    connector, done = ports.ports, list[str]()
    qtbot.waitUntil(lambda: second.is_open and first.is_open)
    job = connector.run(forever(), lambda _job: None)
    connector.choose(second, then=partial(done.append, "second"))
    connector.choose(first)
    worker.end_jobs()
    qtbot.waitUntil(lambda: job.is_done and not connector.is_busy)
    assert (connector.current, done) == (first, [])
    connector.choose(second, then=partial(done.append, "second"))
    assert (connector.current, done) == (second, ["second"])


def test_a_port_that_hangs_does_not_keep_another_module_from_being_shown(qtbot: QtBot, ports: FakePorts) -> None:
    ports.plug_in("/dev/one")
    second, _ = ports.plug_in("/dev/two")
    connector, ended = ports.ports, list[Job[Any]]()
    qtbot.waitUntil(lambda: second.is_open and connector.current.is_open)
    connector.run(forever(), ended.append)
    connector.choose(second)
    qtbot.waitUntil(lambda: connector.current is second)
    assert ended == []
    assert SETTLE_MS <= 1000


@pytest.mark.promise("l")
def test_lock_all_reaches_every_open_port_and_waits_for_none(qtbot: QtBot, ports: FakePorts) -> None:
    for name in ("one", "two", "three"):
        ports.plug_in(f"/dev/{name}", active=True)
    connector = ports.ports
    qtbot.waitUntil(lambda: all(connection.is_open for connection in connector.all))
    assert connector.is_any_active
    connector.lock.press_all()  # none of the jobs ends: all three hang
    assert [len(worker.wanted(is_urgent=True)) for worker in ports.workers] == [1, 1, 1]
    assert connector.current.lock.is_repeating
    connector.choose(connector.all[1])
    assert not any(job.run.is_done for worker in ports.workers for job in worker.wanted(is_urgent=True))
    ports.workers[0].unplug()
    qtbot.waitUntil(lambda: not connector.all[0].is_open)
    assert connector.all[0].lock.is_unproven  # it waits for the port
    assert connector.current.lock.failed is None
    assert connector.current.lock.is_repeating


@pytest.mark.promise("l")
def test_lock_is_possible_as_soon_as_another_module_is_shown(qtbot: QtBot, ports: FakePorts) -> None:
    first, _ = ports.plug_in("/dev/one")
    second, worker = ports.plug_in("/dev/two", active=True)
    qtbot.waitUntil(lambda: first.is_open and second.is_open)
    bar = TopBar(ports.ports, LimitsInUse())
    qtbot.addWidget(bar)
    ports.ports.choose(second)
    bar.lock.click()
    assert len(worker.wanted(is_urgent=True)) == 1


def test_a_port_that_is_removed_is_closed_and_another_stays(qtbot: QtBot, ports: FakePorts) -> None:
    first, _ = ports.plug_in("/dev/one")
    second, worker = ports.plug_in("/dev/two")
    connector = ports.ports
    qtbot.waitUntil(lambda: first.is_open and second.is_open)
    connector.remove(first)  # the current one is not
    assert connector.all == (first, second)
    connector.remove(second)
    worker.hand_over()
    qtbot.waitUntil(lambda: worker.is_stopped)
    assert connector.all == (first,)
    assert first.is_open


LIGHT = BY_NAME["light_threshold"]
ONE, TWO = Target("/dev/one", 115200), Target("/dev/two", 115200)


def open_first(qtbot: QtBot, ports: FakePorts) -> Ports:
    first, _ = ports.plug_in(ONE.device, tilt_deg=11)
    qtbot.waitUntil(lambda: first.is_open)
    return ports.ports


def to_another_port(ports: FakePorts) -> None:
    ports.ports.connect_to(TWO)


def to_the_same_port(ports: FakePorts) -> None:
    ports.ports.connect_to(ONE)


def to_a_port_that_is_open(ports: FakePorts) -> None:
    ports.ports.choose(ports.ports.all[1])


def by_a_persons_word(ports: FakePorts) -> None:
    ports.ports.current.treat_as_new()


CHANGES = (to_another_port, to_the_same_port, to_a_port_that_is_open, by_a_persons_word)


@pytest.mark.parametrize("change", [to_another_port, to_the_same_port])
@pytest.mark.promise("l")
def test_a_report_that_was_under_way_is_not_the_next_modules(
    qtbot: QtBot, ports: FakePorts, change: Callable[[FakePorts], None]
) -> None:
    connector = open_first(qtbot, ports)
    ports.workers[0].say(tilt_deg=12)  # read by the thread, not yet by the window
    change(ports)
    seen: list[Batch] = []
    connector.batch.connect(seen.append)
    assert (connector.current.module.view, connector.current.connection.state) == (DeviceView(), PortState.OPENING)
    qtbot.wait(50)
    assert seen == []
    assert connector.current.module.view == DeviceView()
    assert not connector.current.is_open
    assert connector.current.identity.trust is Trust.OPEN
    ports.workers[0].values.clear()
    ports.workers[0].say(tilt_deg=33)
    qtbot.waitUntil(lambda: connector.current.module.view.fresh("tilt_deg", ports.now_s) == 33)


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.promise("l")
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
@pytest.mark.promise("l")
def test_a_job_that_outlives_the_change_is_cancelled_and_reports_to_nobody(
    qtbot: QtBot, ports: FakePorts, change: Callable[[FakePorts], None]
) -> None:
    connector = open_first(qtbot, ports)
    second, _ = ports.plug_in("/dev/three")
    qtbot.waitUntil(lambda: second.is_open)
    ended: list[Job[Any]] = []
    running = RunningJob(connector)
    running.run(forever(), ended.append)
    running.notify(Meaning.GOOD, "Read back as written.")
    connector.run(forever(), ended.append)
    jobs = [job for job, _ in ports.workers[0].jobs][-2:]
    change(ports)
    qtbot.waitUntil(lambda: not running.is_running)  # a switch waits a second for them
    assert [job.run.is_cancelled for job in jobs] == [True, True], "it would go on with the next module"
    assert running.result_notice() is None
    assert not connector.is_busy
    ports.workers[0].end_jobs()
    qtbot.waitUntil(lambda: all(job.is_done for job in jobs))
    qtbot.wait(50)
    assert ended == []


@pytest.mark.parametrize("is_said_new", [False, True])
@pytest.mark.promise("l")
def test_an_unconfirmed_activation_outlives_a_new_connection_of_the_same_port(
    qtbot: QtBot, ports: FakePorts, is_said_new: bool
) -> None:
    """What may fire is not forgotten because somebody pressed "Connect again"."""
    connector = open_first(qtbot, ports)
    if is_said_new:
        by_a_persons_word(ports)
    ports.workers[0].say(active=True)
    qtbot.waitUntil(lambda: connector.current.activation.state is Activation.ACTIVE)
    to_the_same_port(ports)
    assert connector.current.activation.state is Activation.WAS_ACTIVE
    to_another_port(ports)
    assert connector.current.activation.state is Activation.UNKNOWN


@pytest.mark.promise("l")
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
