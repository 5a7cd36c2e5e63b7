"""Charger unplugged, plugged and unplugged again: what the module reports each time.

A step is done as soon as the module reports it. Where it does not, the person says that it is done, and what it still
reports a little later is the result.
"""

from typing import NamedTuple

from app.engine.procedure import EngineView, Inspect, Pause, Procedure, Report, ask_value
from app.guided.results import BreakOff, GuidedKind, GuidedResult, MeasuredValue, passed_if
from app.guided.status_watch import (
    AGREEING,
    NOT_READ,
    SILENT_S,
    GuidedSetup,
    PersonSteps,
    require_in_time,
    require_locked,
    require_start,
)
from app.text.messages import message
from protocol.catalogue import BY_NAME
from protocol.messages import HIGHEST_CELL_V
from protocol.translatable import marked

LOWEST_CELL_V = 3.5
"""Below it a lithium cell is nearly empty."""
ASK_EVERY_S = 0.2
SETTLES_S = 1.0
"""Between the report and the reading of the voltage."""
REPORTED_WITHIN_S = 5.0
"""After the person confirmed the step."""
PLUGGED_IN = (False, True, False)
"""In each step."""
STEPS = len(PLUGGED_IN)
UNPLUG, PLUG_IN = marked("Unplug the external power."), marked("Plug the external power in.")
_CHARGING, _VOLTAGE = BY_NAME["charging"], BY_NAME["cell_voltage"]


class _ChargeSeen(NamedTuple):
    is_charging: bool
    voltage_v: float


def measure_charger(setup: GuidedSetup, steps: PersonSteps) -> Procedure[GuidedResult]:
    seen: list[_ChargeSeen] = []
    for number, is_plugged_in in enumerate(PLUGGED_IN):
        yield Report(number, STEPS, PLUG_IN if is_plugged_in else UNPLUG)
        seen.append((yield from _until(setup, steps, is_charging=is_plugged_in)))
    steps.done()
    yield from require_locked()
    return _result(seen)


def _until(setup: GuidedSetup, steps: PersonSteps, *, is_charging: bool) -> Procedure[_ChargeSeen]:
    view: EngineView = yield Inspect()
    began, heard_at, said_at = view.now, view.now, None
    confirmed, agreeing = steps.ask(), 0
    while agreeing < AGREEING:
        reading = yield from ask_value(_CHARGING)
        view = yield Inspect()
        require_start(view, setup.restarts)
        now = view.now
        heard_at = now if reading is not None else heard_at
        agreeing = agreeing + 1 if reading is not None and bool(reading.value) is is_charging else 0
        if confirmed.done():
            said_at = said_at if said_at is not None else now
            if now - said_at > REPORTED_WITHIN_S:
                break
        if now - heard_at > SILENT_S:
            raise BreakOff(NOT_READ, what=message(marked("Charging")))
        require_in_time(began, now)
        yield Pause(ASK_EVERY_S)
    steps.done()
    yield Pause(SETTLES_S)
    charging, voltage = (yield from ask_value(_CHARGING)), (yield from ask_value(_VOLTAGE))
    if charging is None or voltage is None:
        raise BreakOff(NOT_READ, what=message(marked("Charging")))
    return _ChargeSeen(bool(charging.value), float(voltage.value))


def _result(seen: list[_ChargeSeen]) -> GuidedResult:
    measured = [
        MeasuredValue(
            message(marked("Plugged in") if is_plugged_in else marked("Unplugged")),
            message(marked("charging") if one.is_charging else marked("not charging")),
            message(marked("charging") if is_plugged_in else marked("not charging")),
            passed_if(one.is_charging is is_plugged_in),
            float(one.is_charging),
        )
        for one, is_plugged_in in zip(seen, PLUGGED_IN, strict=True)
    ]
    cell = seen[-1].voltage_v
    measured.append(
        MeasuredValue(
            message(marked("Cell voltage")),
            message(f"{cell:.2f} V"),
            message(f"{LOWEST_CELL_V:.2f}–{HIGHEST_CELL_V:.2f} V"),
            passed_if(LOWEST_CELL_V <= cell <= HIGHEST_CELL_V),
            cell,
        )
    )
    return GuidedResult(GuidedKind.CHARGER, tuple(measured))
