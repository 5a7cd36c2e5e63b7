"""Shows activation and trigger in state chips."""

from app.engine.device import Known
from app.safety.last_known import Activation, SeenActivation
from app.text.durations import duration
from app.text.i18n import tr
from ui.style.icons import Icon
from ui.style.theme import Meaning
from ui.widgets.readout import StateChip


def show_activation(chip: StateChip, seen: SeenActivation, now: float) -> None:
    """A stale ACTIVE keeps its colour, hatched, since nobody has seen the module locked."""
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
    """`is_triggered` as reported by the module, None if unknown."""
    if is_triggered is None:
        chip.show_unknown()
    elif is_triggered:
        chip.show_state(tr("TRIGGERED"), Icon.PARACHUTE, Meaning.DANGER, stale_age=age, keeps_colour=True)
    else:
        chip.show_state(tr("NOT TRIGGERED"), Icon.NOT_TRIGGERED, stale_age=age)


def show_known_trigger(chip: StateChip, known: Known | None, now: float) -> None:
    """Like `show_trigger`, from a known value."""
    is_triggered = None if known is None else known.value is True
    show_trigger(chip, is_triggered=is_triggered, age="" if known is None else age_of(known, now))


def age_of(known: Known, now: float) -> str:
    """The age of a stale value, else ""."""
    return tr("{time} ago", time=duration(now - known.at)) if known.is_stale else ""
