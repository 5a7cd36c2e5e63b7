"""The port of the tour's own simulated module: what comes from it is neither kept, recorded nor remembered."""

from typing import Final

from app.engine.target import Target

TOUR_NAME: Final = "tour"
TOUR_PORT: Final = f"sim://{TOUR_NAME}"


def is_tour(target: Target | None) -> bool:
    return target is not None and target.device == TOUR_PORT
