"""Window and simulated module of the tour."""

from typing import TYPE_CHECKING, Final, TypeVar, cast

from PySide6.QtWidgets import QWidget

from app.diagnosis.link_state import Phase
from app.engine.device import Known
from app.engine.target import Target
from app.simulator import bench as benches
from app.simulator.bench import SimulatedBench
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.core.connector import Connector
from ui.services.tour_port import TOUR_NAME, TOUR_PORT, is_tour

if TYPE_CHECKING:
    from ui.pages.live.page import LivePage
    from ui.shell.main_window import MainWindow

TIPPED_DEG: Final = 70
_BEGINS: Final = {"lifelike": True, "noise": 1.0, "history": 2}
"""How the module begins: it wobbles a little, and it has fired twice."""
Page = TypeVar("Page", bound=QWidget)


class TourSetup:
    """Everything that a step may look at or do. It touches no module but the tour's own."""

    def __init__(self, window: "MainWindow", connector: Connector) -> None:
        self.window, self.connector = window, connector
        benches.module(TOUR_NAME, _BEGINS)
        self.has_been_active = False
        self.has_been_pulled = False
        self.has_been_tipped = False

    # What is known

    @property
    def phase(self) -> Phase:
        return self.connector.state.phase

    @property
    def is_ours(self) -> bool:
        """The tour's module is what is, or is to be, connected."""
        return self.connector.is_wanted and is_tour(self.connector.target)

    @property
    def is_online(self) -> bool:
        return self.is_ours and self.phase is Phase.ONLINE

    @property
    def other_port(self) -> str:
        """What is connected instead; empty where nothing is."""
        target = self.connector.target
        return target.device if self.connector.is_wanted and target is not None and not self.is_ours else ""

    def known(self, key: str) -> Known | None:
        return self.connector.device.known(key, self.connector.clock())

    def page(self, kind: type[Page]) -> Page:
        """A page of the window. Raises `LookupError` where it has none of this kind."""
        found = cast("Page | None", self.window.findChild(kind))
        if found is None:
            raise LookupError(f"no {kind.__name__}")
        return found

    @property
    def live(self) -> "LivePage":
        from ui.pages.live.page import (
            LivePage,  # takes the plots with it, which the window fetches after its first paint
        )

        return self.page(LivePage)

    def leave_recording(self) -> bool:
        """What the Live page shows in the tour is the tour's module; whether a recording was looked at instead."""
        was_open = self.live.recording is not None
        self.live.back_to_live()
        return was_open

    # What a person would do to a module on the bench

    @property
    def bench(self) -> SimulatedBench:
        return benches.module(TOUR_NAME)

    def connect(self) -> None:
        """Only where nothing else is connected; it never takes a port away from anything."""
        if not self.other_port:
            self.window.connect_to(Target(TOUR_PORT, DEFAULT_BAUD_RATE))

    def silence(self, *, is_mute: bool) -> None:
        self.bench.change(mute=is_mute)

    def tip(self, tilt_deg: float) -> None:
        self.bench.set_lifelike(is_lifelike=False)
        self.bench.set_tilt(tilt_deg)

    def set_down(self) -> None:
        """Level and at rest, as before a flight."""
        self.tip(0)
        self.bench.set_noise(0)

    def activate(self) -> None:
        """At the bench, not over the line: the tour itself sends nothing that could arm."""
        self.set_down()
        self._activate(is_active=True)

    def calm(self) -> None:
        """Leave no step's module behind in a state that the next step does not expect."""
        bench = self.bench
        if not bench.is_plugged_in:
            bench.plug()
        bench.change(mute=False)
        self._activate(is_active=False)
        self.tip(0)

    def _activate(self, *, is_active: bool) -> None:
        bench = self.bench
        with bench.changed:
            bench.module.activate(is_active=is_active)

    def forget(self) -> None:
        benches.forget(TOUR_NAME)
