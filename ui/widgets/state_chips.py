"""State chips for activation and trigger, the same on every page."""

from app.diagnosis.link_state import duration
from app.engine.device import Known
from app.safety.last_known import Activation, SeenActivation
from app.text.i18n import tr
from ui.style.icons import Icon
from ui.style.theme import Meaning
from ui.widgets.readout import StateChip


def show_activation(chip: StateChip, seen: SeenActivation, now: float) -> None:
    """A lost ACTIVE keeps its colour, hatched: nobody has seen it locked."""
    age = "" if seen.at is None else tr("{time} ago", time=duration(now - seen.at))
    match seen.state:
        case Activation.UNKNOWN:
            chip.show_unknown()
        case Activation.ACTIVE:
            chip.show_state(tr("ACTIVE"), Icon.ACTIVE, Meaning.ATTENTION)
        case Activation.WAS_ACTIVE:
            chip.show_state(tr("was ACTIVE"), Icon.ACTIVE, Meaning.ATTENTION, stale_age=age, keeps_colour=True)
        case Activation.LOCKED:
            chip.show_state(tr("LOCKED"), Icon.LOCK)
        case Activation.WAS_LOCKED:
            chip.show_state(tr("LOCKED"), Icon.LOCK, stale_age=age)


def show_trigger(chip: StateChip, *, is_triggered: bool | None, age: str = "") -> None:
    """`is_triggered` as the module reported it, None while that is not known."""
    if is_triggered is None:
        chip.show_unknown()
    elif is_triggered:
        chip.show_state(tr("TRIGGERED"), Icon.PARACHUTE, Meaning.DANGER, stale_age=age, keeps_colour=True)
    else:
        chip.show_state(tr("NOT TRIGGERED"), Icon.NOT_TRIGGERED, stale_age=age)


def show_known_trigger(chip: StateChip, known: Known | None, now: float) -> None:
    """The same of what is known of a module."""
    is_triggered = None if known is None else known.value is True
    show_trigger(chip, is_triggered=is_triggered, age="" if known is None else age_of(known, now))


def age_of(known: Known, now: float) -> str:
    """Empty while nothing casts doubt on the value."""
    return tr("{time} ago", time=duration(now - known.at)) if known.is_stale else ""
