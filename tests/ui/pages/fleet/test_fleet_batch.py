"""A batch of new modules on the Fleet page, with a real store and a simulated port, on a clock of the test."""

import csv
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.identity import Identity, Trust
from app.engine.target import Target
from app.engine.worker import Batch
from app.records.check_store import CheckStore
from app.safety.acts import Act
from app.store.database import StoreFault, StoreTrouble
from app.store.facts import FactKind
from app.store.store import Store
from protocol.catalogue import SERIAL_OUTPUT, Hazard
from tests.support.window.fake_ports import VALUES, FakeWorker
from tests.support.window.fakes_ui import page_entries, store_of
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import given, notice_text
from ui.pages.fleet.batch_panel import BatchPanel
from ui.pages.fleet.batch_turns import Stage
from ui.pages.fleet.page import FleetPage

SETTINGS = "attitude_threshold_deg = 65\nfreefall_time_s = 1.4\n"
WRITES = ["attitude_threshold", "freefall_time", "attitude_trigger", "freefall_trigger"]


class Bench(Rig):
    """The window with the Fleet page, its batch form filled in."""

    @property
    def fleet(self) -> FleetPage:
        return self.find(FleetPage)

    @property
    def panel(self) -> BatchPanel:
        return self.fleet.batch

    @property
    def stage(self) -> Stage:
        return self.fleet.turns.stage

    @property
    def store(self) -> Store:
        return store_of(self.assembly.storage)

    @property
    def sets(self) -> list[str]:
        sets = [request for request in self.requests if request.hazard is not Hazard.NONE or not request.is_repeatable]
        return [one.command.name for one in sets if one.command is not SERIAL_OUTPUT]

    def asks_beside(self) -> bool:
        """Whether the window asks which module it is."""
        notice = self.assembly.window.notice_bar.notice
        return notice is not None and any(choice.key == "identity_new" for choice in notice.choices)

    def fill(self, folder: Path, settings: str = SETTINGS, names: str = "M-001..M-002") -> None:
        profile = folder / "p.toml"
        profile.write_text(f"format = 1\nname = 'Survey'\n[settings]\n{settings}", encoding="utf-8")
        self.fleet.start_batch.trigger()
        form = self.panel.form
        form.show_profile(profile)
        form.names.setText(names)
        form.enables.setChecked(True)
        form.reviewed.setChecked(True)

    def begin(self, folder: Path, settings: str = SETTINGS) -> None:
        self.fill(folder, settings)
        self.click(self.panel.form.start)
        self.until(lambda: self.stage is not Stage.DONE)

    def plug_in(self, boots: int) -> None:
        """Another module, as it comes from the vendor."""
        self.bench.module.memory.boot_count = boots - 1
        self.bench.module.memory.reset_settings()
        before = self.assembly.connector.current.device.restarts
        self.bench.restart()
        self.until(lambda: self.assembly.connector.current.device.restarts > before)
        self.until(lambda: self.stage is Stage.ASK)

    def scan(self, name: str) -> None:
        """As a USB scanner types it."""
        QTest.keyClicks(self.panel.label, name)
        QTest.keyClick(self.panel.label, Qt.Key.Key_Return)

    def begin_turn(self, name: str, requests: int = 0) -> None:
        """Up to so many requests of its work."""
        self.until(lambda: self.stage is Stage.ASK)
        self.wait(0.6)
        self.scan(name)
        assert self.stage in (Stage.WORKING, Stage.STOPPED)
        begun = len(self.requests)
        self.until(lambda: len(self.requests) >= begun + requests)

    def end_turn(self) -> str:
        """The sentence of its outcome."""
        self.until(lambda: self.stage is not Stage.WORKING)
        self.wait(0.3)
        return self.panel.hint.text().partition("\n")[0]

    def take_turn(self, name: str) -> str:
        self.begin_turn(name)
        return self.end_turn()


@pytest.fixture
def bench(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Bench]:
    with on_fake_time(Bench, qtbot, qapp, tmp_path / "data", "fleet-batch", page_entries("live", "fleet")) as one:
        one.assembly.window.resize(1024, 600)
        one.until(lambda: one.root.findChildren(FleetPage))
        one.connect()
        one.assembly.window.panel.hide()
        one.assembly.window.go_to("fleet")
        yield one
        one.assembly.storage.close()


def _verdicts(bench: Bench, module: str | None) -> list[str]:
    return [check.verdict for check in CheckStore(bench.store.database).checks(module)]


def test_each_module_has_its_turn_once_its_label_is_confirmed(bench: Bench, tmp_path: Path) -> None:
    bench.begin(tmp_path)
    bench.until(lambda: bench.stage is Stage.ASK)
    assert bench.panel.words.text() == "LABEL: M-001?"
    bench.wait(2.0)
    assert bench.sets == []  # nothing is written before a person has said so
    bench.scan("M-7")
    assert (bench.stage, bench.sets) == (Stage.ASK, [])
    QTest.keyClicks(bench.panel.label, "M-0")
    bench.plug_in(8)
    assert bench.panel.label.text() == ""  # a scanner would go on in the middle of a name
    assert bench.take_turn("M-001") == "M-001: READY"
    port = bench.assembly.connector.current
    assert (bench.stage, port.module.name, bench.sets) == (Stage.UNPLUG, "M-001", WRITES)
    bench.wait(3.0)
    assert bench.stage is Stage.UNPLUG  # as long as it is plugged in
    bench.plug_in(9)
    assert port.module.name == ""
    bench.until(lambda: port.identity.is_for_a_person)
    assert not bench.asks_beside()  # one question at a time
    bench.assembly.window.go_to("live")
    assert bench.asks_beside()
    bench.assembly.window.go_to("fleet")
    bench.wait(0.6)
    assert bench.panel.confirm.text() == "Its label reads M-002"
    bench.click(bench.panel.confirm)
    bench.until(lambda: bench.stage is Stage.DONE)
    assert bench.panel.confirm.isHidden()  # no name is left to confirm
    assert bench.sets == WRITES * 2
    assert (_verdicts(bench, "M-001"), _verdicts(bench, "M-002")) == (["READY"], ["READY"])
    assert bench.store.evidence("M-002").is_complete
    assert all(len(check.content["record"]["frames"]) > 60 for check in bench.store.facts.select(FactKind.CHECK))
    module = given(bench.store.module_named("M-002"))
    assert module.adapter == port.module.adapter  # which the next window asks about here
    runs = {entry.detail["run"] for entry in bench.store.audit(Act.WRITE)[: len(WRITES)]}
    assert runs == {port.kept.run}  # what was sent to one is not logged in the conversation with the other
    bench.panel.print_labels("24", tmp_path / "labels.pdf")
    bench.until((tmp_path / "labels.pdf").exists)


def test_the_list_is_written_as_csv_and_pdf(bench: Bench, tmp_path: Path) -> None:
    bench.begin(tmp_path)
    bench.take_turn("M-002")  # in any order
    bench.panel.export_list(tmp_path / "list.pdf")
    said = bench.fleet.notice_bar
    bench.until(lambda: notice_text(said) == f"Saved to {tmp_path / 'list.pdf'}, {tmp_path / 'list.csv'}.")
    rows = list(csv.DictReader((tmp_path / "list.csv").read_text(encoding="utf-8").splitlines()))
    assert [(row["name"], row["result"]) for row in rows] == [("M-001", "open"), ("M-002", "ready")]


def test_it_goes_on_with_the_names_that_are_left(bench: Bench, tmp_path: Path) -> None:
    bench.begin(tmp_path)
    bench.take_turn("M-001")
    bench.click(bench.panel.close_button)
    assert bench.fleet.turns.bench is None
    bench.click(bench.panel.form.start)
    bench.until(lambda: bench.fleet.turns.name == "M-002")
    assert [row.result for row in bench.fleet.turns.rows] == ["READY", "open"]
    said = bench.take_turn("M-002")  # it was never unplugged
    assert said.startswith("SET ASIDE: It may be M-001: boot count and settings fit.")
    assert bench.sets == WRITES
    assert bench.store.module_named("M-002") is None
    assert bench.assembly.connector.current.module.name == ""


def test_an_active_module_is_set_aside_and_lock_works(bench: Bench, tmp_path: Path) -> None:
    bench.begin(tmp_path)
    bench.bench.module.activate(is_active=True)
    assert "The module is ACTIVE" in bench.take_turn("M-001")
    assert bench.sets == []
    bench.assembly.connector.lock.press()
    bench.until(lambda: bench.assembly.connector.current.device.fresh("active", bench.clock()) is False)


@pytest.mark.parametrize("is_exchanged", [False, True])
def test_a_name_that_stayed_free_expects_nothing_of_the_module_that_was_set_aside(
    bench: Bench, tmp_path: Path, is_exchanged: bool
) -> None:
    bench.begin(tmp_path)
    bench.bench.set_bay(is_open=True)
    if is_exchanged:
        bench.begin_turn("M-001", 90)
        bench.bench.restart()
        bench.end_turn()
    else:
        assert bench.take_turn("M-001").startswith("SET ASIDE: ")
    bench.bench.set_bay(is_open=False)
    bench.plug_in(2)  # with other settings, and started less often
    assert bench.take_turn("M-001") == "M-001: READY"


def test_a_module_that_is_exchanged_in_its_turn_is_set_aside(bench: Bench, tmp_path: Path) -> None:
    bench.begin(tmp_path)
    for boots, after in enumerate((1, 40, 90, 140), start=2):
        bench.begin_turn("M-001", after)
        bench.bench.module.memory.reset_settings()
        bench.bench.restart()
        assert bench.end_turn().startswith("SET ASIDE: "), after
        assert (_verdicts(bench, "M-001"), bench.store.modules()) == ([], ()), after
        bench.plug_in(boots)


@pytest.mark.parametrize("is_adapter", [False, True])
def test_a_module_that_is_unplugged_in_its_turn_is_set_aside(bench: Bench, tmp_path: Path, is_adapter: bool) -> None:
    """Alone, or with its adapter."""
    bench.begin(tmp_path)
    bench.begin_turn("M-001", 10)
    bench.bench.unplug() if is_adapter else bench.bench.power_off()
    bench.end_turn()
    bench.until(lambda: bench.stage is Stage.PLUG_IN)
    assert bench.panel.words.text() == "PLUG IN: M-001"
    assert bench.store.modules() == ()


@pytest.mark.parametrize("work", ["provision", "keep"])
def test_where_nothing_can_be_kept_the_module_has_no_name(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, work: str
) -> None:
    bench.begin(tmp_path)

    def full(*_args: object) -> None:
        raise StoreTrouble(StoreFault.FULL, tmp_path)

    monkeypatch.setattr(f"app.fleet.batch.Bench.{work}", full)
    assert bench.take_turn("M-001").startswith("The disk is full")
    assert bench.stage is Stage.STOPPED
    assert bench.assembly.connector.current.module.name == ""


def test_another_module_by_a_persons_word_ends_the_turn(bench: Bench, tmp_path: Path) -> None:
    bench.begin(tmp_path)
    bench.begin_turn("M-001", 10)
    bench.assembly.connector.current.module.treat_as_new()
    assert bench.end_turn().startswith("SET ASIDE: ")
    assert bench.store.modules() == ()


def test_about_the_module_of_another_port_the_window_asks_on_another_page(bench: Bench, tmp_path: Path) -> None:
    bench.begin(tmp_path)
    bench.until(lambda: bench.stage is Stage.ASK)
    connector, workers = bench.assembly.connector, list[FakeWorker]()

    def make(callback: Callable[[Batch], None]) -> FakeWorker:
        workers.append(FakeWorker(callback, bench.clock))
        return workers[-1]

    other = connector.add(make)  # type: ignore[arg-type]
    other.connect_to(Target("/dev/other", 115200))
    workers[0].identity = Identity(Trust.UNPROVEN)
    workers[0].say(**VALUES)
    connector.choose(other)
    bench.until(lambda: connector.current is other and other.identity.is_for_a_person)
    assert not bench.asks_beside()
    bench.assembly.window.go_to("live")
    assert bench.asks_beside()
    bench.assembly.window.go_to("fleet")
    bench.click(bench.panel.close_button)
    assert bench.asks_beside()


def test_protection_is_taken_away_only_by_write_anyway(bench: Bench, tmp_path: Path) -> None:
    bench.fill(tmp_path, "attitude_threshold_deg = 179\n")
    bench.click(bench.panel.form.start)
    assert bench.fleet.turns.bench is None
    notice = given(bench.fleet.result.result_notice())
    assert [choice.text for choice in notice.choices] == ["Cancel", "Write anyway"]
    notice.choices[1].act()
    bench.until(lambda: bench.fleet.turns.bench is not None)


def test_where_no_module_can_pass_it_does_not_begin(bench: Bench, tmp_path: Path) -> None:
    for more, said in (
        ("baud_rate = 9600\n", "A batch does not change the baud rate: take it out of the profile."),
        ("[tests]\ntilt = 180\n", "The profile demands manual checks or guided tests, which a batch does not"),
    ):
        bench.fill(tmp_path, SETTINGS + more)
        bench.click(bench.panel.form.start)
        notice = given(bench.fleet.result.result_notice())
        assert notice.text.startswith(said)
        assert bench.fleet.turns.bench is None
