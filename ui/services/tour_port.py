"""Port of the tour's simulated module; nothing from it is stored, recorded or remembered."""

from typing import Final

from app.engine.target import Target

TOUR_NAME: Final = "tour"
TOUR_PORT: Final = f"sim://{TOUR_NAME}"


def is_tour(target: Target | None) -> bool:
    return target is not None and target.device == TOUR_PORT
