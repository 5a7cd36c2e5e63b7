"""Offers to put the simulated module at rest if it fails a check for that reason."""

from collections.abc import Callable, Sequence
from typing import Final

from app.engine.target import Target
from app.port_urls.protocol_sim import open_bench
from app.text.i18n import tr
from app.text.user_error import UserError
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

_OF_REST: Final = frozenset(("tilt", "tilt_spread", "acceleration", "acceleration_spread"))


def rest_offer(
    target: Target | None, against: Sequence[str], check_again: Callable[[], object]
) -> Callable[[], Notice] | None:
    """Makes the notice; None if the module is real or at rest, or if no check of rest failed."""
    if target is None or not target.is_simulated or not _OF_REST.intersection(against):
        return None
    try:
        bench = open_bench(target.device)
    except UserError:
        return None
    state = bench.state()
    if not state.is_lifelike and not state.tilt_deg:
        return None

    def set_down() -> None:
        bench.set_lifelike(is_lifelike=False)
        bench.set_tilt(0)
        check_again()

    def offer() -> Notice:
        text = tr("The simulated module is not at rest.")
        return Notice(Meaning.INFORMATION, text, (Choice("set_down", tr("Set down, check again"), set_down),))

    return offer
