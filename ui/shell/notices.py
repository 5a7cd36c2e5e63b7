"""Texts of the notices about the link and about leaving an ACTIVE module."""

from collections.abc import Callable
from dataclasses import replace

from app.diagnosis.link_state import LinkState, NextStep, Phase, link_text
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.text.i18n import tr
from app.text.sentences import join_sentences
from protocol.translatable import marked
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

_ASKS_WHY = (Phase.SILENT, Phase.LATE, Phase.OFFLINE, Phase.LOST, Phase.FAILED)
_STEP_TEXTS = {
    NextStep.CHOOSE_PORT: marked("Choose a port"),
    NextStep.FIND_RATE: marked("Find the rate"),
    NextStep.CONNECT_AGAIN: marked("Connect again"),
    NextStep.WHY: marked("Why?"),
}


def link_notice(
    state: LinkState, now: float, acts: dict[NextStep, Callable[[], None]], *, is_unlocked: bool = False
) -> Notice | None:
    """The trouble of the link and the step that helps; None while the link is fine. `is_unlocked`: LOCK was not
    confirmed, which another sentence beside this one says."""
    if state.is_fine:
        return None
    said = link_text(state, now)
    is_calm = state.phase in (Phase.CLOSED, Phase.SWITCHED_OFF)
    if is_unlocked or (state.was_active and not is_calm):
        said = replace(said, next_step=keep_away())  # alone, so that nothing of it is elided
    parts = ["" if said.what == said.word else said.what, said.next_step]  # the top bar has the word
    if state.was_active and not is_unlocked and not is_calm:
        parts.insert(0, tr(LAST_HEARD_ACTIVE))
    steps: tuple[NextStep, ...] = () if said.step is None else (said.step,)
    if NextStep.WHY in acts and state.phase in _ASKS_WHY:
        steps = (*steps, NextStep.WHY)
    choices = tuple(
        Choice(step.value, tr(_STEP_TEXTS[step]), acts[step], is_main=step is steps[0] and not is_calm)
        for step in steps
    )
    meaning = Meaning.INFORMATION if is_calm else Meaning.ATTENTION
    return Notice(meaning, join_sentences(parts), choices)


def leaving_notice(
    lock: Callable[[], None],
    leave: Callable[[], None],
    stay: Callable[[], None],
    *,
    is_active: bool,
) -> Notice:
    """Asked before leaving a module that is ACTIVE or does not report LOCKED."""
    return Notice(
        Meaning.ATTENTION,
        tr("The module is ACTIVE: it fires also without this program.")
        if is_active
        else tr("Treat the module as ACTIVE: it does not report LOCKED."),
        (
            Choice("lock_and_leave", tr("LOCK first"), lock, is_main=True),
            Choice("leave_active", tr("Leave it ACTIVE"), leave, is_step=True),
            Choice("stay", tr("Cancel"), stay),
        ),
    )


def unsent_notice(count: int, leave: Callable[[], None], stay: Callable[[], None]) -> Notice:
    """Asked before edits of settings are lost."""
    stays = Choice("stay", tr("Cancel"), stay, is_main=True)
    drops = Choice("drop_edits", tr("Discard edits"), leave, is_step=True)
    return Notice(Meaning.ATTENTION, tr("Settings not written: {count}.", count=count), (stays, drops))
