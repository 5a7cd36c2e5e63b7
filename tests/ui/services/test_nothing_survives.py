"""No page, notice or label shows anything of a former module: every page of the program, every job, every change.

The window is the program's own, on ports without threads. It shows of B what it shows where B was the first module.
"""

import re
from collections.abc import Callable
from functools import partial
from itertools import product
from typing import Final

import pytest
from app.engine.identity import NO_EXPECTATION, Identity, Trust

from app.engine.procedure import Cancelled, Pause, Procedure
from app.engine.target import Target
from app.engine.worker import Batch
from app.flights.judge import TriggerLimits
from app.records.filing import Filed, local_now
from app.records.record import make_record
from app.safety.acts import Act
from app.settings.profiles import Profile
from tests.support.records.preflight_rig import check
from tests.support.thorough import some
from tests.support.two_modules import NAME_A, PORT_A, PORT_B, A, B, Rig
from tests.support.window.fake_ports import VALUES, stand
from ui.main import PAGES
from ui.services.job_notice import JobNotice
from ui.style.theme import Meaning

OF_A: Final = re.compile(
    rf"{NAME_A}|(?<![\d.,])(?:47\s?°|1\.7\s?g|3\.79|4\.7\s?V|147|7\.9|79|0\.9\s?g|1\.79|9,518|Said of it)(?![\d])"
)
OF_B: Final = ("2.2 V", "62°", "1.22 s", "4.02 V")
APART: Final = re.compile(r"passing_message|fleet: (?:notice_|fleet_(?:said|summary))")
"""What is said of the window, or of all modules on the board."""

Begin = Callable[[Rig], object]


def _edited(rig: Rig) -> None:
    work = rig.pages["settings"].work
    work.edit(lambda: work.form.choose("light_threshold_v", 7.9))


def _writing(rig: Rig) -> None:
    work = rig.pages["settings"].work
    work.edit(lambda: work.form.choose("light_threshold_v", 9.7))
    work.job.run(_forever(), lambda _job: work.job.notify(Meaning.GOOD, "Said of it"))


def _forever() -> Procedure[None]:
    while True:
        yield Pause(1.0)


def _checked(rig: Rig) -> None:
    assessment = check().assessment
    page = rig.pages["preflight"]
    page.check()
    stand(page.work.last, Filed(assessment, make_record(assessment, at=local_now()), None))


def _guided(rig: Rig) -> None:
    work = rig.pages["tests"].work
    work.state_safe(True)
    work.start()


def _profile(rig: Rig) -> None:
    fleet = rig.pages["fleet"]
    fleet.profile.open(Profile(name="For all", settings={"light_threshold_v": 2.1}))
    fleet.profile.apply(fleet.members.all)


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
    second = next((connection for connection in connector.all if connection is not connector.current), None)
    second = second or connector.add(rig.ports.make)
    second.connect_to(PORT_B)
    worker = rig.ports.workers[connector.all.index(second)]
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
    if rig.connector.current.module.view.values and not seen:
        seen.append([f"{where}: {text}" for where, text in rig._visible() if OF_A.search(text)])


@pytest.mark.promise("l")
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


def test_a_port_that_told_last_some_time_ago_is_drawn_from_then_on(rig: Rig) -> None:
    """More of what it told is on its way, from before it was chosen."""
    live, connector = rig.pages["live"], rig.connector
    rig.show_a()
    second = connector.add(rig.ports.make)
    second.connect_to(PORT_B)
    rig.ports.workers[-1].say(**VALUES | B)
    rig.settle()
    rig.assembly.window.go_to("live")
    rig.ports.now_s += 0.2
    rig.ports.workers[-1].say(cell_voltage_v=4.03)
    rig.ports.now_s += 0.2
    connector.choose(second)
    rig.settle()
    live.refresh()
    assert [round(volts, 2) for volts in live.data.cell.window(0.0, 1e9).value.tolist()] == [4.02, 4.03]


@pytest.mark.promise("l")
def test_nothing_that_was_said_stands_over_a_port_that_is_not_open(rig: Rig) -> None:
    rig.show_a()
    assert any("Said of it" in one for one in _look(rig))
    rig.show_a()
    rig.connector.current.disconnect_port()
    rig.worker.hand_over()
    rig.settle()
    assert [one for one in _look(rig) if "Said of it" in one or "The module answers" in one] == []


@pytest.mark.promise("l")
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
            notice.notify(meaning, "Said of it")
            rig.assembly.window.go_to("live" if page.key != "live" else "settings")
            is_left = notice.result_notice() is not None
            assert is_left is (meaning is Meaning.ATTENTION), (page.key, notice.objectName(), meaning)
            notice.dismiss()
