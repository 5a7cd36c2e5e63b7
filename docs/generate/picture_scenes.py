"""Scenes of the user guide's pictures, with the real program on a simulated module.

A scene brings the window into its state, waits until that is reached, and takes its pictures. All scenes of one
language run in one window, in the order of `SCENES`.
"""

import math
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Final

from picture_studio import Stuck, Studio
from PySide6.QtCore import QSize, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QLabel, QLineEdit, QScrollArea

from app.diagnosis.link_state import Phase
from app.engine.ports import PortInfo
from app.flights.judging import FlightGroup
from app.preflight.checks import Person
from app.preflight.verdict import Standing
from app.simulator import bench
from app.simulator.setup import Setup
from app.text.i18n import CHINESE, ENGLISH, tr
from ui.acts.ritual_widget import RitualWidget
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.main import WindowOptions, assemble, start
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.live.page import LivePage
from ui.pages.logs.page import LogsPage
from ui.pages.preflight.page import PreflightPage
from ui.pages.settings.page import SettingsPage
from ui.pages.triggers.page import TriggersPage
from ui.services.storage import Storage
from ui.style.theme import Choice

SIZE: Final = QSize(1024, 600)
"""The smallest supported screen."""
NAME, OTHER_NAME = "guide", "other"
PORT, OTHER_PORT = f"sim://{NAME}", f"sim://{OTHER_NAME}"
SETUP: Final = Setup(history=4, cell=4.0, lifelike=True)
OTHER_SETUP: Final = Setup(baud=57600)
MODULE, WHO, AIRCRAFT = "M-07", "Lin Wei", "H6"
ADAPTER: Final = PortInfo("/dev/ttyUSB0", "CP2102 USB to UART", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-1")
README: Final = {ENGLISH: ("live-en.png", Choice.LIGHT), CHINESE: ("live-zh_CN.png", Choice.DARK)}
README_IMAGES: Final = Path(__file__).resolve().parents[1] / "images"
GUIDE_IMAGES: Final = Path(__file__).resolve().parents[2] / "ui" / "help" / "guide" / "images"
MAX_CHECKS: Final = 6
"""Attempts: on a busy machine the check may rightly find a slow line."""

# Scenes


def connect(studio: Studio) -> None:
    window = studio.assembly.window
    studio.until(lambda: window.panel.isVisible() and studio.assembly.watcher.has_listed, "the ports are not listed")
    studio.run(0.3)
    studio.take("connect", window.panel)


def live(studio: Studio) -> None:
    """Tilted, levelled, dropped."""
    studio.connect(PORT)
    studio.until(lambda: studio.assembly.ports.current.state.phase is Phase.ONLINE, "it is not online")
    for key in ("freefall_time_s", "boot_count"):
        studio.until(partial(studio.is_known, key), f"{key} is not known")
    page = studio.page("live", LivePage)
    studio.until(lambda: page.data.has_samples, "no samples came")
    name_it(studio)
    studio.page("live", LivePage)
    studio.run(22.0)
    for tilt_deg, seconds in ((28, 1.5), (47, 2.5), (33, 1.5), (12, 3.0)):
        studio.module.set_world(tilt_deg=tilt_deg)
        studio.run(seconds)
    studio.module.drop(3)
    studio.run(3.0)
    studio.module.set_world(tilt_deg=4)
    studio.run(9.0)


def readme(studio: Studio) -> None:
    """For the guide, and for the README: one language in the light, the other in the dark theme."""
    studio.take("live")
    name, theme = README[studio.language]
    appearance = studio.assembly.appearance
    appearance.choose(theme)
    studio.run(0.3)
    studio.taken.append((studio.grab(), studio.readme_folder / name))
    appearance.choose(Choice.LIGHT)
    studio.run(0.3)


def name_it(studio: Studio) -> None:
    """Done once for each module."""
    studio.assembly.window.go_to("preflight")
    edit = studio.find(QLineEdit, "preflight_module_edit")
    edit.setFocus()
    edit.selectAll()
    QTest.keyClicks(edit, MODULE)
    QTest.keyClick(edit, Qt.Key.Key_Return)
    studio.run(0.3)


def ages(studio: Studio) -> None:
    studio.module.change(mute=True)
    ports = studio.assembly.ports
    studio.until(lambda: ports.current.state.phase is not Phase.ONLINE, "it is still online")
    studio.run(4.0)
    studio.take("ages")
    studio.module.change(mute=False)
    studio.until(lambda: ports.current.state.phase is Phase.ONLINE, "it did not come back")
    studio.until(lambda: ports.module.is_read, "it was not read again")
    ports.module.say_name(MODULE)
    studio.run(0.3)


def settings(studio: Studio) -> None:
    """One setting written and verified, one edited."""
    page = studio.page("settings", SettingsPage)
    work = page.work
    studio.until(lambda: work.can_edit and work.job.can_run, "nothing can be edited")
    work.fill({"attitude_threshold_deg": 65})
    page.write.click()
    studio.until(lambda: not work.job.is_running, "it is still writing")
    work.fill({"freefall_acceleration_g": 0.6})
    studio.until(lambda: work.job.can_run, "nothing can be sent")
    work.job.dismiss()
    page.refresh()
    studio.run(0.3)
    studio.take("settings", page)
    work.revert()


def triggers(studio: Studio) -> None:
    page = studio.page("triggers", TriggersPage)
    page.read.click()
    studio.until(lambda: page.work.reading is not None and not page.work.is_busy, "the records were not read")
    page.table.selectRow(0)
    studio.run(0.5)
    studio.take("triggers", page)


def preflight(studio: Studio) -> None:
    """A NO-GO for unreviewed records, then READY once a person has looked at them and called them reviewed."""
    page = studio.page("preflight", PreflightPage)
    studio.module.set_world(is_lifelike=False, tilt_deg=0)
    studio.run(1.0)
    page.form.aircraft.setText(AIRCRAFT)
    check_until(studio, page, Standing.NO_GO, "trigger_records")
    studio.take("no-go", page)
    page.lead_to("triggers", page.exchange.review_wanted.emit)
    records = studio.find(TriggersPage)
    studio.until(lambda: records.work.reading is not None and not records.work.is_busy, "nothing was read")
    studio.run(0.5)
    studio.page("preflight", PreflightPage)
    check_until(studio, page, Standing.READY)
    page.list.verticalScrollBar().setValue(0)
    studio.run(0.3)
    studio.take("go", page)


def check_until(studio: Studio, page: PreflightPage, wanted: Standing, *against: str) -> None:
    """Check until this verdict stands, for these checks alone. On a busy machine a check may rightly find a slow line,
    or be interrupted."""
    for _ in range(MAX_CHECKS):
        studio.until(page.enable.isEnabled, "nothing can be checked")
        if not studio.assembly.ports.module.name:
            studio.until(lambda: studio.assembly.ports.module.is_read, "it was not read again")
            studio.assembly.ports.module.say_name(MODULE)
            page.form.aircraft.setText(AIRCRAFT)
        said = Person(are_records_reviewed=wanted is Standing.READY)
        page.check(said, is_enabling=True)
        studio.until(lambda: page.state.standing is not Standing.CHECKING, "no verdict")
        studio.run(1.0)
        assessment = page.state.assessment
        if page.state.standing is wanted and assessment is not None and assessment.open_checks == against:
            return
    raise Stuck(f"it never said {wanted.value}")


def deploy(studio: Studio) -> None:
    """The ritual, armed."""
    studio.assembly.window.go_to("commands")
    studio.window.activateWindow()
    ports = studio.assembly.ports
    studio.module.module.activate(is_active=True)
    studio.until(lambda: ports.current.is_active, "it is not active")
    ritual = studio.find(RitualWidget)
    for step in (ritual.choose, ritual.arm):
        studio.until(partial(getattr, step, "is_live"), "a step is dead")
        step.click()
    studio.until(lambda: ritual.ritual.is_armed, "it is not armed")
    studio.run(1.0)
    bar = studio.find(QScrollArea, "commands_scroll").verticalScrollBar()
    bar.setValue(bar.maximum())
    studio.take("deploy", ritual)
    studio.press("ritual_cancel")
    studio.press("lock_button")
    studio.until(lambda: not ports.current.is_active, "it is still active")
    bar.setValue(0)


def logs(studio: Studio) -> None:
    """Recordings, survey flights with steep turns, and two crashes, sorted."""
    with tempfile.TemporaryDirectory() as folder:
        surveys = [write_flight(Path(folder) / f"survey-{one}.csv", peak_deg=30 + 4 * one) for one in range(1, 6)]
        crashes = [write_flight(Path(folder) / f"crash-{one}.csv", lost_s=30.0 + one) for one in range(1, 3)]
        page = studio.page("logs", LogsPage)
        page.open_files([*surveys, *crashes])
        studio.until(lambda: not page.result.is_busy, "the logs were not read")
        page.work.move([str(one) for one in surveys], FlightGroup.MUST_NOT)
        page.work.move([str(one) for one in crashes], FlightGroup.MUST)
        studio.until(lambda: not page.work.proposing.is_running, "nothing was proposed")
        studio.run(2.0)
        studio.take("logs", page)
        crash = next(row for row in page.work.rows() if row.name == str(crashes[0]))
        page.open_row(crash)
        studio.until(lambda: page.view.plot is not None, "it is not shown")
        studio.run(0.3)
        studio.take("log", page)
        page.view.close_log()


def write_flight(path: Path, *, peak_deg: float = 20.0, lost_s: float = math.inf) -> Path:
    """A minute of flight with one turn; from `lost_s` on it tumbles and falls."""
    rows = ["time_s,tilt_deg,acceleration_g"]
    for number in range(60 * 50):
        at_s = number / 50
        since_s = max(0.0, at_s - lost_s)
        tilt = 6 * abs(math.sin(at_s / 3)) + peak_deg * math.exp(-(((at_s - 20) / 1.5) ** 2)) + 90 * since_s
        falls = 0.1 < since_s < 3.0 or 40.0 < at_s < 40.0 + peak_deg / 100
        force = 8.0 if 3.0 <= since_s < 3.1 else 0.3 if falls else 1.0
        rows.append(f"{at_s:.2f},{min(tilt, 175):.1f},{force}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def why(studio: Studio) -> None:
    """A module at another baud rate, just powered up."""
    other = bench.module(OTHER_NAME, OTHER_SETUP)
    studio.assembly.ports.current.disconnect_port()
    studio.run(0.5)
    page = studio.page("diagnosis", DiagnosisPage)
    page.go_to("why")
    studio.connect(OTHER_PORT)
    studio.until(lambda: studio.assembly.ports.current.state.phase is Phase.SILENT, "it is not silent")
    other.restart()
    act = studio.find(QAbstractButton, "why_act")
    studio.until(lambda: not act.isHidden() and tr("Find the baud rate") in act.text(), "no cause was found")
    studio.run(1.0)
    studio.take("why", page, last=studio.find(QLabel, "why_noise"))
    bench.remove_bench(OTHER_NAME)


SCENES: Final[tuple[Callable[[Studio], None], ...]] = (
    connect,
    live,
    readme,
    ages,
    settings,
    triggers,
    preflight,
    deploy,
    logs,
    why,
)


@contextmanager
def opened(language: str, home: Path) -> Iterator[Studio]:
    """A window with new preferences. `home`: an empty folder for its data."""
    app = QApplication(sys.argv[:1])
    preferences = Preferences(home / "window.ini")
    preferences.theme = Choice.LIGHT.value
    preferences.who = WHO
    options = WindowOptions(language=language)
    module = bench.module(NAME, SETUP)
    assembly = assemble(
        app, options, preferences=preferences, storage=Storage(home), watcher=PortWatcher(lambda _deadline_s: [ADAPTER])
    )
    try:
        assembly.window.resize(SIZE)
        start(assembly, options)
        studio = Studio(assembly, module, GUIDE_IMAGES, README_IMAGES, language)
        studio.until(lambda: assembly.window.findChild(DiagnosisPage), "the pages are not made")  # it is the last
        yield studio
    finally:
        assembly.window.close_now()
        app.processEvents()


def main(language: str, home: str) -> None:
    """Raises `Stuck` if a state is not reached."""
    with opened(language, Path(home)) as studio:
        for scene in SCENES:
            scene(studio)
            print(language, scene.__name__, flush=True)
        studio.save_all()


if __name__ == "__main__":
    main(*sys.argv[1:])
