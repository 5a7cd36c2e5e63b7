"""A module left ACTIVE is said at the next start until that is settled."""

import os
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from app.engine.identity import NO_EXPECTATION, Identity, Trust
from app.store.left_active import KnownAs
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot
from ui.connect.left_active import LeftActiveWatch

from app.engine.procedure import Pause, Procedure
from app.engine.target import Target
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.safety.last_known import keep_away
from app.store.fact_store import Store
from app.store.store_journal import note_locked
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import begin, left_in, open_store, settle
from tests.support.window.fake_ports import FakePorts, ports_alone
from tests.support.window.fakes_ui import page_entries, window
from tests.support.window.steps import given, press, show_page
from ui.pages.diagnosis.page import DiagnosisPage
from ui.services.storage import Storage

USB = "/dev/ttyUSB0"


def activate(store: Store, module: str) -> None:
    """As before a `kill -9` in the tilt test: activated, and never locked."""
    known_as = KnownAs(module, "before")
    entry = begin(store, Act.ACTIVATE, REQUESTS[Act.ACTIVATE].encode(), {}, port=USB, known_as=known_as)
    settle(store, entry, Outcome.CONFIRMED, {})


@pytest.mark.promise("l")
def test_it_stands_first_at_the_next_start(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    store = open_store()
    activate(store, "M-07")
    store.close()
    with window(qapp, tmp_path, entries=()) as assembly:
        bar = assembly.window.notice_bar
        qtbot.waitUntil(lambda: bar.notice is not None and bar.notice.text.startswith("M-07 was left ACTIVE on "))
        assert bar.notice is not None
        assert keep_away() in bar.notice.text
        assert assembly.window.panel.isVisible()  # the list of ports is no reason to be silent about it
        press(qtbot, bar.button("left_active_locked"))
        qtbot.waitUntil(lambda: bar.notice is None or "ACTIVE" not in bar.notice.text)
    store = open_store()
    assert left_in(store) == ()
    store.close()


class Bench:
    """Fake ports, and a store in which M-07 was left ACTIVE."""

    def __init__(self, folder: Path) -> None:
        self.storage = Storage(folder)
        self.ports = ports_alone(self.storage)
        store = self.storage.open_store()
        assert isinstance(store, Store)
        self.store = store
        activate(store, "M-07")
        self.watch = LeftActiveWatch(self.ports.ports)
        self.watch.load()
        self.left()
        QApplication.processEvents()

    def left(self) -> list[str]:
        self.store.write(lambda _facts: None).result(PATIENCE_S)
        self.store.write(lambda _facts: None).result(PATIENCE_S)
        return [one.known_as.name for one in left_in(self.store)]


@pytest.fixture
def bench(qapp: QApplication, tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path)
    yield made
    made.ports.stop()
    made.storage.close()


@pytest.mark.promise("l")
def test_only_that_module_ends_it_by_reporting_locked(qtbot: QtBot, bench: Bench) -> None:
    _connection, module = bench.ports.plug_in(USB, active=False)
    qtbot.wait(50)
    assert bench.watch.notice() is not None, "nobody has said which module this is"
    bench.ports.ports.current.module.choose("M-08")
    module.say(active=False)
    qtbot.wait(50)
    assert bench.watch.notice() is not None
    assert bench.left() == ["M-07"]
    bench.ports.ports.current.module.choose("M-07")
    module.say(active=True)
    qtbot.waitUntil(lambda: bench.watch.notice() is None)  # the top bar says it
    module.unplug()
    qtbot.wait(50)
    assert bench.watch.notice() is None, "that the link is lost says it"
    bench.ports.ports.connect_to(Target("/dev/ttyUSB1", 115200))
    qtbot.waitUntil(lambda: bench.watch.notice() is not None)
    bench.ports.ports.connect_to(Target(USB, 115200))
    bench.ports.ports.current.module.choose("M-07")
    module.say(active=False)
    qtbot.waitUntil(lambda: bench.left() == [])
    qtbot.waitUntil(lambda: bench.watch.notice() is None)


def test_what_was_activated_by_its_switch_is_logged_too(qtbot: QtBot, bench: Bench) -> None:
    _connection, module = bench.ports.plug_in(USB, active=False)
    bench.ports.ports.current.module.choose("M-09")
    module.say(active=True)
    qtbot.waitUntil(lambda: "M-09" in bench.left())
    module.say(active=False)
    qtbot.waitUntil(lambda: bench.left() == ["M-07"])


def test_one_that_gets_its_name_while_it_is_active_is_left_under_it(qtbot: QtBot, bench: Bench) -> None:
    """Where it is met again by that name, its report ends it."""
    port, module = bench.ports.plug_in(USB, active=True)
    qtbot.waitUntil(lambda: "" in bench.left())
    port.module.choose("M-09")
    module.say(active=True)
    qtbot.waitUntil(lambda: sorted(bench.left()) == ["M-07", "M-09"])
    port.connect_to(Target("/dev/ttyUSB1", 115200))
    port.module.choose("M-09")
    module.say(active=False)
    qtbot.waitUntil(lambda: bench.left() == ["M-07"])


@pytest.mark.parametrize(("name", "is_active"), [("M-07", True), ("M-07", False), ("", True)])
@pytest.mark.promise("l")
def test_a_person_can_say_that_it_is_the_connected_one(qtbot: QtBot, bench: Bench, name: str, is_active: bool) -> None:
    """Left ACTIVE on purpose, it is met again: nobody has to claim that it is locked."""
    if not name:
        bench.store.write(lambda facts: note_locked(facts, bench.storage.left_active[0], "window")).result(PATIENCE_S)
        activate(bench.store, "")
        bench.watch.load()
    qtbot.waitUntil(lambda: [one.known_as.name for one in bench.storage.left_active] == [name])
    _connection, module = bench.ports.plug_in(USB, active=is_active)
    keys = ["left_active_here", "left_active_locked"]
    qtbot.waitUntil(
        lambda: (said := bench.watch.notice()) is not None and [choice.key for choice in said.choices] == keys,
    )
    said = given(bench.watch.notice())
    assert said.choices[0].text == ("It is M-07" if name else "Same module")
    said.choices[0].act()
    module.say(active=is_active)
    qtbot.waitUntil(lambda: (name in bench.left()) is is_active)
    qtbot.waitUntil(lambda: bench.watch.notice() is None)  # the top bar says it
    module.say(active=False)
    qtbot.waitUntil(lambda: bench.left() == [])


NEW = Identity(Trust.UNPROVEN)


@pytest.mark.parametrize("name", ["", "M-09"])
@pytest.mark.promise("l")
def test_that_the_first_was_active_outlives_new_module(qtbot: QtBot, bench: Bench, name: str) -> None:
    """LOCK of the first was not confirmed; on the same adapter another one answers, which is locked."""
    connection, module = bench.ports.plug_in(USB, active=False)
    bench.ports.ports.current.module.choose(name)
    module.say(active=True)
    qtbot.waitUntil(lambda: name in bench.left())
    journal = connection.journal()
    journal.settle(journal.begin(Act.LOCK, b"", {}), Outcome.UNKNOWN, {})
    module.unplug()
    module.identity = NEW
    module.say(active=False)
    qtbot.waitUntil(lambda: connection.identity.is_for_a_person)
    in_doubt = connection.journal()
    in_doubt.settle(in_doubt.begin(Act.LOCK, b"", {}), Outcome.CONFIRMED, {})
    assert name in bench.left()
    bench.ports.ports.current.module.treat_as_new()
    module.identity = NO_EXPECTATION
    for _ in range(3):
        module.say(active=False)
        qtbot.wait(20)
    assert sorted(bench.left()) == sorted([name, "M-07"]), "what another one reports ends nothing"
    unproven = f"{name or 'The module at /dev/ttyUSB0'}: LOCK not confirmed on "
    qtbot.waitUntil(lambda: (said := bench.watch.notice()) is not None and said.text.startswith(unproven))
    notice = given(bench.watch.notice())
    notice.choices[0].act()
    qtbot.waitUntil(lambda: bench.left() == ["M-07"])


def test_a_person_who_says_that_it_is_the_same_lets_its_report_count(qtbot: QtBot, bench: Bench) -> None:
    connection, module = bench.ports.plug_in(USB, active=True)
    qtbot.waitUntil(lambda: "" in bench.left())
    module.unplug()
    module.identity = NEW
    module.say(active=False)
    qtbot.waitUntil(lambda: connection.identity.is_for_a_person)
    assert "" in bench.left()
    module.identity = Identity(Trust.PROVEN)
    module.say(active=False)
    qtbot.waitUntil(lambda: bench.left() == ["M-07"])


@pytest.mark.parametrize("between", ["a break", "a restart", "nothing"])
def test_an_active_module_without_a_name_is_not_called_locked_by_what_answers_after_a_break(
    qtbot: QtBot, bench: Bench, between: str
) -> None:
    """Within a second it may have been exchanged, and a module does not lock itself."""
    _connection, module = bench.ports.plug_in(USB, active=True)
    qtbot.waitUntil(lambda: "" in bench.left())
    module.breaks += between != "nothing"
    module.restarts += between == "a restart"
    module.say(active=False)
    if between != "a break":
        qtbot.waitUntil(lambda: bench.left() == ["M-07"])
        return
    qtbot.waitUntil(lambda: (said := bench.watch.notice()) is not None and USB in said.text)
    assert sorted(bench.left()) == ["", "M-07"]
    said = given(bench.watch.notice())
    assert [choice.text for choice in said.choices] == ["Same module", "It is locked"]
    said.choices[0].act()
    module.say(active=False)
    qtbot.waitUntil(lambda: bench.left() == ["M-07"])


def test_that_it_reports_locked_after_a_doubt_ends_an_unconfirmed_lock(qtbot: QtBot, bench: Bench) -> None:
    """Of a module without a name, which was locked before, too, so that nothing had changed."""
    connection, module = bench.ports.plug_in(USB, active=False)
    qtbot.waitUntil(lambda: connection in bench.watch._seen)
    journal = connection.journal()
    journal.settle(journal.begin(Act.LOCK, b"", {}), Outcome.UNKNOWN, {})
    assert sorted(bench.left()) == ["", "M-07"]
    for trust in (Trust.UNPROVEN, Trust.PROVEN):
        module.identity = Identity(trust)
        module.say(active=False)
        qtbot.waitUntil(lambda trust=trust: connection.identity.trust is trust)  # type: ignore[misc]
    qtbot.waitUntil(lambda: bench.left() == ["M-07"])


@pytest.mark.promise("l")
def test_why_it_is_silent_sends_nobody_to_what_was_left_active(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    store = open_store()
    activate(store, "M-07")
    store.close()
    with ExitStack() as files, window(qapp, tmp_path, entries=page_entries("diagnosis")) as assembly:
        silent, port = os.openpty()
        for file in (silent, port):
            files.callback(os.close, file)
        qtbot.waitUntil(lambda: bool(assembly.storage.left_active))
        assembly.ports.connect_to(Target(os.ttyname(port), 115200))
        page = show_page(qtbot, assembly.window, "diagnosis", DiagnosisPage)
        qtbot.waitUntil(lambda: page.why.next_step.text().startswith(keep_away()))


@pytest.fixture
def ports(qtbot: QtBot) -> Iterator[FakePorts]:
    fake = ports_alone()
    yield fake
    fake.stop()


def test_a_rate_is_looked_for_at_the_port_that_was_asked_for(qtbot: QtBot, ports: FakePorts) -> None:
    """Also where it is open for Fleet, and the shown one is still busy: nothing is asked there."""

    def forever() -> Procedure[None]:
        while True:
            yield Pause(1.0)

    first, worker = ports.plug_in("/dev/one")
    second, other = ports.plug_in("/dev/two")
    connector = ports.ports
    qtbot.waitUntil(lambda: second.is_open and first.is_open)
    connector.run(forever(), lambda _job: None)
    before = len(worker.jobs), len(other.jobs)
    connector.connect_to(Target("/dev/two", 115200, finds_rate=True))
    assert (len(worker.jobs), len(other.jobs)) == before
    worker.end_jobs()
    qtbot.waitUntil(lambda: connector.current is second)
    assert len(other.jobs) == before[1] + 1
