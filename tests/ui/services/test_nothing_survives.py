"""No page, notice or label shows anything of a former module: every page of the program, every job, every change.

The window is the program's own, on ports without threads. It shows of B what it shows where B was the first module.
"""

import re
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, Final

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QLineEdit, QPlainTextEdit, QTabBar, QWidget
from pytestqt.qtbot import QtBot

from app.engine.identity import NO_EXPECTATION, Identity, Trust
from app.engine.procedure import Cancelled, LinkView, Pause, Procedure
from app.engine.snapshots import Snapshot
from app.engine.target import Target
from app.engine.worker import Batch, Job
from app.firing.judge import TriggerLimits
from app.guided.results import GuidedKind, GuidedResult
from app.procedures.history import History
from app.records.filing import Filed
from app.records.trigger_filing import PossiblyOther, TriggersReading
from app.safety.acts import Act
from app.settings.profiles import Profile
from app.store.database import StoreFault, StoreTrouble
from app.trigger_records.history import Judgement
from protocol.catalogue import BY_NAME
from protocol.events import Counters, Sent
from protocol.fields import Value
from tests.support.patience import PATIENCE_S
from tests.support.records.preflight_rig import check
from tests.support.thorough import some
from tests.support.window.fake_ports import VALUES, FakePorts, FakeWorker, stand
from tests.support.window.fakes_ui import close_window
from tests.support.window.spoken import texts_of
from ui.core.preferences import Preferences
from ui.help.help_actions import explain
from ui.main import PAGES, Assembly, WindowOptions, assemble
from ui.services.job_notice import JobNotice
from ui.services.port import Ports
from ui.services.storage import Storage
from ui.style.theme import Meaning

NAME_A: Final = "ALPHA"
PORT_A, PORT_B = Target("/dev/ttyONE", 115200), Target("/dev/ttyTWO", 115200)
A: Final[dict[str, Value]] = {
    "tilt_deg": 47, "acceleration_g": 1.7, "cell_voltage_v": 3.79, "light_v": 4.7, "boot_count": 147,
    "light_threshold_v": 7.9, "attitude_threshold_deg": 79, "freefall_acceleration_g": 0.9, "freefall_time_s": 1.79,
}  # fmt: skip
B: Final[dict[str, Value]] = {
    "tilt_deg": 2, "acceleration_g": 1.0, "cell_voltage_v": 4.02, "light_v": 0.2, "boot_count": 22,
    "light_threshold_v": 2.2, "attitude_threshold_deg": 62, "freefall_acceleration_g": 0.2, "freefall_time_s": 1.22,
}  # fmt: skip
OF_A: Final = re.compile(
    rf"{NAME_A}|(?<![\d.,])(?:47\s?°|1\.7\s?g|3\.79|4\.7\s?V|147|7\.9|79|0\.9\s?g|1\.79|9,518|Said of it)(?![\d])"
)
OF_B: Final = ("2.2 V", "62°", "1.22 s", "4.02 V")
APART: Final = re.compile(r"passing_message|fleet: (?:notice_|fleet_(?:said|summary))")
"""What is said of the window, or of all modules on the board."""


@dataclass
class Rig:
    """The window on fake ports; `worker` is that of the port that A is on."""

    assembly: Assembly
    ports: FakePorts

    def __post_init__(self) -> None:
        self.connector: Ports = self.assembly.connector
        self.pages: dict[str, Any] = self.assembly.window._pages

    @property
    def worker(self) -> FakeWorker:
        return self.ports.workers[self.connector.connections.index(self.connector.current)]

    def settle(self) -> None:
        for _ in range(3):
            QApplication.processEvents()
            self.pages["diagnosis"].bundle._making.wait(PATIENCE_S)  # beside the window

    def answer(self, values: dict[str, Value]) -> None:
        """The module on the current port answers all that it was asked."""
        self.ports.now_s += 1.0
        self.worker.values.clear()
        self.worker.say(**VALUES | values)
        self.settle()

    def show_a(self) -> None:
        """A, with its name, ten thousand requests and a message in every place for messages."""
        self.connector.before_new = lambda begin: begin()  # a person discards the edits
        self.connector.connect_to(PORT_A)
        self.connector._switch()  # what was chosen before is not waited for
        self.answer(A)
        self.assembly.connector.current.module.choose(NAME_A)
        self.worker.hand_over(link=LinkView(Counters(sent=9518), 0.0, 0.0))
        request = BY_NAME["light_threshold"].set(7.9)
        self.worker.hand_over(events=(Sent(request.encode(), request, 1, self.ports.now_s),))
        self.pages["flights"]._try({"attitude_threshold_deg": 79, "attitude_trigger": False}, None)
        self.connector.current.kept.as_found = Snapshot(settings={"light_threshold_v": 7.9})
        for notice in self.assembly.window.findChildren(JobNotice):
            if notice.is_of_module:
                notice.notify(Meaning.DANGER, lambda: "Said of it")
        self.assembly.window.show_message("Said of it")
        self.settle()

    def texts(self, key: str) -> Iterator[tuple[str, str]]:
        """Everything in sight on a page and around it, hidden views of tabs too."""
        window, page = self.assembly.window, self.pages[key]
        window.panel.hide()
        window.go_to(key)
        bars = page.findChildren(QTabBar)
        for number in range(max(1, *(bar.count() for bar in bars)) if bars else 1):
            for bar in bars:
                bar.setCurrentIndex(number)
            self.settle()
            yield from ((f"{key}: {where}", text) for where, text in self._visible())

    def _visible(self) -> Iterator[tuple[str, str]]:
        cards = self.pages["fleet"]._widgets
        others = [card for port, card in cards.items() if port is not self.connector.current]
        if len(self.connector.connections) > 1:
            others.append(self.pages["fleet"].panel)  # a column for each module
        roots = QApplication.topLevelWidgets()
        # Another module's card shows that one's, under its name.
        for widget in [one for root in roots for one in _in_sight(root, others)]:
            where = widget.objectName() or type(widget).__name__
            explain(widget)  # as a person who asks what this is
            for role, text in (*texts_of(widget), *_state(widget)):
                yield f"{where} {role}", text


def _in_sight(widget: QWidget, left_out: list[QWidget]) -> Iterator[QWidget]:
    if widget.isVisible() and widget not in left_out:
        yield widget
        for child in widget.findChildren(QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly):
            if not child.isWindow():
                yield from _in_sight(child, left_out)


def _state(widget: QWidget) -> Iterator[tuple[str, str]]:
    yield "is enabled", str(widget.isEnabled())
    match widget:
        case QAbstractButton():
            yield "is checked", str(widget.isChecked())
        case QComboBox():
            yield "chosen", widget.currentText()
        case QLineEdit():
            yield "typed", widget.text()
        case QPlainTextEdit():
            yield "typed", widget.toPlainText()


@pytest.fixture
def rig(qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    ports = FakePorts()
    ports.connector.stop(1.0)
    ports.connector.deleteLater()  # its connections would keep the window alive through the workers
    ports.workers.clear()

    def make(watcher: Any, storage: Storage) -> Ports:
        return Ports(watcher, storage, make_worker=ports.make, clock=lambda: ports.now_s)

    monkeypatch.setattr("ui.main.Ports", make)
    assembly = assemble(
        qapp, WindowOptions(language="en"), preferences=Preferences(tmp_path / "window.ini"), ports=ports.watcher
    )
    assembly.window.make_pages()
    assembly.window.show()
    assembly.window.setUpdatesEnabled(False)  # texts are asked for, and painting takes most of the time
    qtbot.waitUntil(lambda: len(assembly.window._pages) == len(PAGES) and assembly.window._maker.is_done)
    made = Rig(assembly, ports)
    try:
        yield made
    finally:
        close_window(assembly)


Begin = Callable[[Rig], object]


def _edited(rig: Rig) -> None:
    work = rig.pages["settings"].work
    work.edit(lambda: work.form.choose("light_threshold_v", 7.9))


def _writing(rig: Rig) -> None:
    work = rig.pages["settings"].work
    work.edit(lambda: work.form.choose("light_threshold_v", 9.7))
    work.job.run(_forever(), lambda _job: work.job.notify(Meaning.GOOD, lambda: "Said of it"))


def _forever() -> Procedure[None]:
    while True:
        yield Pause(1.0)


def _checked(rig: Rig) -> None:
    assessment = check().assessment
    page = rig.pages["preflight"]
    page.check()
    stand(page.work.last, Filed(assessment, {}))


def _guided(rig: Rig) -> None:
    work = rig.pages["tests"].work
    work.state_safe(True)
    work.start()


def _profile(rig: Rig) -> None:
    fleet = rig.pages["fleet"]
    fleet.profile.open(Profile(name="For all", settings={"light_threshold_v": 2.1}))
    fleet.profile.apply(fleet.members.connections)


MOMENTS: Final[dict[str, Begin]] = {
    "idle": lambda _rig: None,
    "edited": _edited,
    "writing": _writing,
    "reading": lambda rig: rig.pages["settings"].work.read_all(),
    "calibrating": lambda rig: rig.pages["settings"].calibration._measure("closed"),
    "checking": lambda rig: rig.pages["preflight"].check(),
    "checked": _checked,
    "records": lambda rig: rig.pages["triggers"].work.read(),
    "guided test": _guided,
    "activating": lambda rig: rig.pages["commands"].acts[Act.ACTIVATE]._perform(),
    "check of all": lambda rig: rig.pages["fleet"]._check(),
    "profile for all": _profile,
}


def _to_another_port(rig: Rig) -> None:
    rig.connector.connect_to(PORT_B)


def _by_a_persons_word(rig: Rig) -> None:
    """B was plugged in behind A's port, and a person says so."""
    rig.worker.values.clear()
    rig.worker.identity = Identity(Trust.REFUTED)
    rig.worker.say(**VALUES | B)
    rig.settle()
    rig.connector.current.module.treat_as_new()
    rig.worker.identity = NO_EXPECTATION


def _behind_its_port(rig: Rig) -> None:
    rig.connector.connect_to(PORT_A)
    _by_a_persons_word(rig)


def _on_the_board(rig: Rig) -> None:
    connector = rig.connector
    second = next((connection for connection in connector.connections if connection is not connector.current), None)
    second = second or connector.add(rig.ports.make)
    second.connect_to(PORT_B)
    worker = rig.ports.workers[connector.connections.index(second)]
    worker.values.clear()
    worker.say(**VALUES | B)
    rig.settle()
    connector.choose(second)
    connector._switch()  # where a job outlives the second that it is given


def _after_nothing(rig: Rig) -> None:
    rig.connector.current.disconnect_port()
    rig.worker.hand_over()
    rig.settle()
    rig.connector.connect_to(PORT_B)


CHANGES: Final[dict[str, Begin]] = {
    "another port": _to_another_port,
    "behind its port": _behind_its_port,
    "a person's word": _by_a_persons_word,
    "after a disconnection": _after_nothing,
    "the board": _on_the_board,
}
"""With the board last, since the ports that it adds stay."""


def _look(rig: Rig) -> set[str]:
    """All that is in sight on any page, but what is said of all modules."""
    seen = (f"{where}: {text}" for entry in PAGES for where, text in rig.texts(entry.key))
    return {line for line in seen if not APART.search(line)}


def _look_at_once(rig: Rig, seen: list[list[str]], _batch: Batch) -> None:
    if rig.connector.current.device.values and not seen:
        seen.append([f"{where}: {text}" for where, text in rig._visible() if OF_A.search(text)])


def test_nothing_of_the_former_module_is_in_sight(rig: Rig) -> None:
    """One window for all changes, since it takes a second to make; each moment at two changes at least."""
    fresh: dict[Target | None, set[str]] = {}
    for target in (PORT_A, PORT_B):
        rig.connector.connect_to(target)
        for _ in range(2):
            rig.answer(B)
        fresh[target] = _look(rig)
        assert [value for value in OF_B if value not in " ".join(fresh[target])] == []
    for first, change in enumerate(CHANGES):
        for number, moment in enumerate(some(MOMENTS, one_in=2, first=first)):
            _change_at(rig, change, moment, ("settings", "live", "preflight", "commands")[number % 4])
            assert sorted(_look(rig) ^ fresh[rig.connector.current.target]) == [], (change, moment)


def _change_at(rig: Rig, change: str, moment: str, page: str) -> None:
    rig.show_a()
    MOMENTS[moment](rig)
    rig.settle()
    workers = [worker for worker in rig.ports.workers if worker.wanted(is_urgent=False)]
    seen: list[list[str]] = []
    rig.assembly.window.go_to(page)
    CHANGES[change](rig)
    connection = rig.connector.batch.connect(partial(_look_at_once, rig, seen))
    rig.answer(B)
    rig.connector.batch.disconnect(connection)
    assert seen == [[]], (change, moment, "as the first value was drawn")
    for worker in workers:
        worker.end_jobs()
    rig.settle()
    rig.answer(B)
    rig.pages["fleet"].panel.closed.emit()
    work = rig.pages["settings"].work
    left = work.initial, work.form.watch.changed, rig.pages["flights"].work.limits
    assert left == (None, {}, TriggerLimits()), (change, moment)


def test_nothing_that_was_said_stands_over_a_port_that_is_not_open(rig: Rig) -> None:
    rig.show_a()
    assert any("Said of it" in one for one in _look(rig))
    rig.show_a()
    rig.connector.current.disconnect_port()
    rig.worker.hand_over()
    rig.settle()
    assert [one for one in _look(rig) if "Said of it" in one or "The module answers" in one] == []


def test_nothing_that_ends_after_a_disconnection_is_said(rig: Rig) -> None:
    """A job that was under way is cancelled by it, and says so only then."""
    said: list[tuple[str, str]] = []
    for moment, begin in MOMENTS.items():
        rig.connector.connect_to(PORT_A)
        rig.answer(A)
        for notice in rig.assembly.window.findChildren(JobNotice):
            notice.dismiss()
        begin(rig)
        rig.settle()
        rig.connector.current.disconnect_port()
        rig.worker.end_jobs(Cancelled())
        rig.settle()
        shown = [notice.result_notice() for page in rig.pages.values() for notice in page.notices()]
        said += [(moment, notice.text) for notice in shown if notice is not None]
    assert said == []


def test_good_news_end_with_their_page_and_trouble_does_not(rig: Rig) -> None:
    rig.connector.connect_to(PORT_A)
    rig.answer(A)
    for page in rig.pages.values():
        for notice, meaning in product(page.notices(), (Meaning.GOOD, Meaning.ATTENTION)):
            rig.assembly.window.go_to(page.key)
            notice.notify(meaning, lambda: "Said of it")
            rig.assembly.window.go_to("live" if page.key != "live" else "settings")
            is_left = notice.result_notice() is not None
            assert is_left is (meaning is Meaning.ATTENTION), (page.key, notice.objectName(), meaning)
            notice.dismiss()


def test_what_a_slow_store_did_not_keep_is_said_of_its_module(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise StoreTrouble(StoreFault.FULL, Path("store.db"))

    monkeypatch.setattr("ui.pages.tests.controller.keep_test", fail)
    monkeypatch.setattr("ui.pages.triggers.controller.say_new", fail)
    monkeypatch.setattr("app.records.check_store.CheckStore.judge", fail)
    store: Any = rig.assembly.storage.store
    guided, triggers = rig.pages["tests"], rig.pages["triggers"].work
    for act in (
        lambda: guided.work._store_result(GuidedResult(GuidedKind.BAY, ())),
        lambda: triggers.judge(7, Judgement.REVIEWED, ""),
        lambda: triggers._say_new(NAME_A),
    ):
        rig.show_a()
        gate = threading.Event()
        store.queue.submit(gate.wait)
        act()
        rig.connector.connect_to(PORT_B)
        rig.answer(B)
        gate.set()
        store.queue.submit(int).result(PATIENCE_S)
        rig.settle()
        said = [notice.text for notice in (guided._notice(), triggers.notice()) if notice is not None]
        assert [text for text in said if "Not kept." in text and text.startswith(f"{NAME_A}: ")] == said != []


@pytest.mark.parametrize("is_broken", [False, True])
def test_records_read_before_a_break_get_no_name_that_was_given_after_it(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, is_broken: bool
) -> None:
    """A module without a name may be exchanged within a second, and nothing tells."""
    filed: list[str] = []

    def file(_store: Any, _reading: TriggersReading, name: str, **_: Any) -> PossiblyOther:
        filed.append(name)
        return PossiblyOther()

    def read() -> Procedure[TriggersReading]:
        yield Pause(0.0)
        return TriggersReading(History(is_answered=True, is_confirmed=True), 147)

    monkeypatch.setattr("ui.pages.triggers.controller.file_triggers", file)
    rig.connector.connect_to(PORT_A)
    rig.answer(A)
    job = Job(read())
    job.run.start(0.0)
    job.run.tick(1.0)
    rig.pages["triggers"].work._end(job)
    rig.worker.breaks += is_broken
    rig.answer(A)
    rig.connector.current.module.choose("BETA")
    rig.settle()
    store: Any = rig.assembly.storage.store
    store.queue.submit(int).result(PATIENCE_S)
    assert filed == ([] if is_broken else ["BETA"])


def test_records_of_one_module_are_never_filed_under_the_name_of_the_next(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    filed: list[str] = []

    def file(_store: Any, _reading: TriggersReading, name: str, **_: Any) -> PossiblyOther:
        filed.append(name)
        return PossiblyOther()

    monkeypatch.setattr("ui.pages.triggers.controller.file_triggers", file)
    rig.show_a()
    work = rig.pages["triggers"].work
    work.reading = TriggersReading(History(is_answered=True, is_confirmed=True), 147)
    work._store_reading()
    second = rig.connector.add(rig.ports.make)
    second.connect_to(PORT_B)
    rig.ports.workers[-1].say(**VALUES | B)
    rig.settle()
    second.module.choose("BETA")
    rig.connector.choose(second)
    rig.connector._switch()
    rig.settle()
    assert rig.connector.current.module.name == "BETA"
    store: Any = rig.assembly.storage.store
    store.queue.submit(int).result(PATIENCE_S)
    assert filed == [NAME_A]
