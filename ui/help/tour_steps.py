"""Steps of the tour: what to look at, what to do next, and where.

A step remembers nothing: it is asked ten times a second, so that whatever the person does by hand counts as well.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

from PySide6.QtWidgets import QWidget

from app.settings.form import RowState
from app.text.i18n import tr
from protocol.translatable import marked
from ui.help.tour_setup import TIPPED_DEG, TourSetup
from ui.pages.preflight.controller import Standing, Statement
from ui.pages.preflight.page import PreflightPage
from ui.pages.settings.page import SettingsPage
from ui.pages.triggers.page import TriggersPage

_FALL_KEY: Final = "freefall_time_s"
_FALLS_WANTED: Final = ("1.20", "1.60")
"""The second where the first one stands already."""
_FIRES_DEG: Final = 45
"""Of what the tilt has to reach before the step counts as done."""


@dataclass(frozen=True, slots=True)
class Scene:
    """One moment of a step, in the language in use. `act` is what the main button says and `do` what it does; without
    them the main button goes on. `spots`: the widgets to look at."""

    text: str
    spots: tuple[QWidget, ...]
    act: str = ""
    do: Callable[[], object] | None = None
    is_done: bool = False


@dataclass(frozen=True, slots=True)
class TourStep:
    """`enter` and `leave` are called once each time; `may_skip`: going on does not need the step to be done."""

    page: str
    title: str
    look: Callable[[TourSetup], Scene]
    enter: Callable[[TourSetup], object] = bool
    leave: Callable[[TourSetup], object] = TourSetup.calm
    may_skip: bool = True


def _connect(desk: TourSetup) -> Scene:
    spots = (desk.window.top_bar.port,)
    if desk.is_online:
        text = tr(
            "Connected: this button says which port is open and how the link stands, on every page. Your own module is "
            "chosen here too (Ctrl+K)."
        )
        return Scene(text, spots, is_done=True)
    if desk.other_port:
        text = tr(
            "{port} is connected. The tour works on a simulated module of its own and never touches a real one: "
            "disconnect first. The module stays as it is.",
            port=desk.other_port,
        )
        return Scene(text, spots, tr("Disconnect"), desk.window.disconnect_port)
    if desk.is_ours:
        return Scene(tr("Connecting the simulated module…"), spots)
    text = tr(
        "Here you choose the port of your module. For the tour there is a simulated one: nothing to plug in, and "
        "no parachute."
    )
    return Scene(text, spots, tr("Connect the simulated module"), desk.connect)


def _values(desk: TourSetup) -> Scene:
    spots = (desk.live.panel,)
    if desk.bench.state().values["mute"]:
        text = tr(
            "Nothing comes any more. Watch the numbers: each says how old it is as soon as it is not fresh, here and "
            "at the top. An old value is never shown as a new one."
        )
        return Scene(text, spots, tr("Let it speak again"), partial(desk.silence, is_mute=False), is_done=True)
    text = tr(
        "What the module says now. Dimmed with an age means stale; hatched and “unknown” means that this module never "
        "said it. Nothing is guessed."
    )
    return Scene(text, spots, tr("Let it fall silent"), partial(desk.silence, is_mute=True), is_done=True)


def _tip(desk: TourSetup) -> Scene:
    spots = (desk.live.panel.gauge, desk.live.plots_card)
    tilt = desk.known("tilt_deg")
    if tilt is not None and not tilt.is_stale and float(tilt.value) >= _FIRES_DEG:
        desk.has_been_tipped = True
        text = tr(
            "It lies at {tilt:.0f}°. Beyond the red mark an ACTIVE module fires its parachute; this one is LOCKED and "
            "stays quiet.",
            tilt=float(tilt.value),
        )
        return Scene(text, spots, tr("Set it level"), partial(desk.tip, 0), is_done=True)
    if desk.has_been_tipped:
        text = tr("Level again. The blue mark, 10° below the red one, is where it rearms.")
        return Scene(text, spots, is_done=True)
    text = tr("Gauge and plots follow every movement; the limits are drawn in as the module itself said them.")
    return Scene(text, spots, tr("Tip it to {tilt}°", tilt=TIPPED_DEG), partial(desk.tip, TIPPED_DEG))


def _settings(desk: TourSetup) -> Scene:
    page = desk.page(SettingsPage)
    row, work = page.rows[_FALL_KEY].row, page.work
    spots: tuple[QWidget, ...] = (page.rows[_FALL_KEY],)
    state = None if row is None else row.state
    match state:
        case RowState.EDITED:
            text = tr("Edited, not sent: the module still holds the old value. The line below says what it means.")
            return Scene(text, (*spots, page.write), tr("Write it"), page.write.click)
        case RowState.UNFIT:
            return Scene(tr("The module cannot hold that value; the row says why."), spots)
        case RowState.WRITING:
            return Scene(tr("Sent once; now it is asked for."), spots)
        case RowState.VERIFIED:
            text = tr(
                "Verified: written, asked for again, and equal. Anything else would stay red and say why. Against the "
                "vendor's advice you would have been asked for a second click."
            )
            return Scene(text, spots, is_done=True)
        case RowState.FAILED:
            return Scene(tr("It does not stand, and the row says why."), spots, tr("Write it again"), page.write.click)
        case _:
            pass
    text = tr("One row a setting: value on the module, new value, and what it means in the air.")
    holds_first = row is not None and row.stands is not None and row.stands.value == float(_FALLS_WANTED[0])
    wanted = _FALLS_WANTED[1] if holds_first else _FALLS_WANTED[0]
    want = partial(work.edit, partial(work.form.type_text, _FALL_KEY, wanted))
    return Scene(text, spots, tr("Set to {value} s", value=wanted) if work.job.can_run else "", want)


def _show_settings(desk: TourSetup) -> None:
    page = desk.page(SettingsPage)
    page.show_form()
    page.scroll_area.ensureWidgetVisible(page.rows[_FALL_KEY])


def _leave_settings(desk: TourSetup) -> None:
    work = desk.page(SettingsPage).work
    work.edit(work.form.revert)


def _triggers(desk: TourSetup) -> Scene:
    page = desk.page(TriggersPage)
    if page.work.is_busy:
        return Scene(tr("Asking until two readings agree…"), (page.table, page.read))
    if page.work.reading is not None:
        text = tr(
            "Why it fired, when, and what was set and measured at that moment. Choose a record to say what it was: "
            "bench test, real or false."
        )
        return Scene(text, (page.table,), is_done=True)
    text = tr("The module remembers its last nine triggers. Reading them deletes nothing.")
    return Scene(text, (page.read,), tr("Read the records"), page.read.click)


def _preflight(desk: TourSetup) -> Scene:
    page = desk.page(PreflightPage)
    match page.work.standing:
        case Standing.CHECKING:
            return Scene(tr("Questions only, for a few seconds. The module must lie still."), (page.banner,))
        case Standing.READY | Standing.GO:
            text = tr(
                "READY: all checks hold and the module is locked. Activated, it becomes GO. A restart, a lost link or "
                "any change makes it void by itself, and so do fifteen minutes."
            )
            return Scene(text, (page.banner,), is_done=True)
        case Standing.NO_GO:
            return _no_go(page)
        case _:
            pass
    text = tr(
        "One verdict before each flight. After each start the module cannot say whether its two triggers are enabled: "
        "this button enables them and checks everything."
    )
    statement = Statement(is_enabling=True)
    return Scene(text, (page.buttons.enable,), tr("Enable triggers and check"), partial(page.check, statement))


def _no_go(page: PreflightPage) -> Scene:
    assessment = page.work.assessment
    against = () if assessment is None else assessment.against
    if against == ("trigger_records",):
        text = tr("NO-GO, because two trigger records are not reviewed. You have just read them: say so in that row.")
        statement = Statement(are_records_looked_at=True)
        return Scene(text, (page.list.rows["trigger_records"],), tr("Mark reviewed"), partial(page.check, statement))
    text = tr("NO-GO names everything that stands against it. Each row below says why it matters and what to do.")
    again = Statement(is_enabling=True, are_records_looked_at="trigger_records" not in against)
    return Scene(text, (page.banner,), tr("Check again"), partial(page.check, again))


def _show_preflight(desk: TourSetup) -> None:
    desk.set_down()
    desk.page(PreflightPage).show_check()


def _lock(desk: TourSetup) -> Scene:
    spots = (desk.window.top_bar.lock, desk.window.top_bar.activation)
    active = desk.known("active")
    if active is not None and active.value is True:
        desk.has_been_active = True
        text = tr(
            "ACTIVE: from now on it would fire by its thresholds. LOCK is on every page, one click or Ctrl+L, and goes "
            "before everything else. Press it."
        )
        return Scene(text, spots, tr("Press LOCK"), desk.window.top_bar.lock.click)
    if desk.has_been_active:
        text = tr("LOCKED, because the module itself says so; a sent command alone would not be called that.")
        return Scene(text, spots, is_done=True)
    text = tr(
        "Only an active module fires; a locked one stays in standby, in flight too. On a real module activating is on "
        "the Commands page, with a second click."
    )
    return Scene(text, spots, tr("Make it active"), desk.activate)


def _diagnosis(desk: TourSetup) -> Scene:
    from ui.pages.diagnosis.page import DiagnosisPage

    spots = (desk.page(DiagnosisPage).why.card,)
    if not desk.bench.is_plugged_in:
        text = tr(
            "One cause and one next step. The values at the top have become stale and say how old they are. Now put "
            "the cable back."
        )
        return Scene(text, spots, tr("Plug it in"), desk.bench.plug)
    if not desk.has_been_pulled:
        text = tr("When nothing answers, look here: it says why, and what to do next.")
        return Scene(text, spots, tr("Pull the cable"), partial(_pull, desk))
    if not desk.is_online:
        return Scene(tr("It reconnects automatically, and only to the same adapter."), spots)
    text = tr(
        "Back again, and everything was read again. That was the tour: plug your module in, choose its port, compare "
        "the settings with the advice, and check before each flight."
    )
    return Scene(text, (desk.window.top_bar.port,), is_done=True)


def _pull(desk: TourSetup) -> None:
    desk.has_been_pulled = True
    desk.bench.unplug()


def _show_diagnosis(desk: TourSetup) -> None:
    from ui.pages.diagnosis.page import DiagnosisPage

    desk.page(DiagnosisPage).go_to("why")


STEPS: Final[tuple[TourStep, ...]] = (
    TourStep("live", marked("Connect"), _connect, may_skip=False),
    TourStep("live", marked("What it says now"), _values),
    TourStep("live", marked("Tip it"), _tip),
    TourStep("settings", marked("Edit, write, verify"), _settings, _show_settings, _leave_settings),
    TourStep("triggers", marked("Why did it fire?"), _triggers),
    TourStep("preflight", marked("READY, GO or NO-GO"), _preflight, _show_preflight),
    TourStep("live", marked("LOCK"), _lock),
    TourStep("diagnosis", marked("When it does not connect"), _diagnosis, _show_diagnosis),
)
