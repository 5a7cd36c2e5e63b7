"""What the window knows of a page, and the services that a page is given."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from PySide6.QtCore import QObject, Signal

from app.limits.limits import LimitsInUse
from app.procedures.act import Armed
from app.system.logs import Log
from ui.core.preferences import Preferences
from ui.services.page import Page
from ui.services.storage import Storage
from ui.session.ports import LockControl, Ports
from ui.style.appearance import Appearance
from ui.style.icons import Icon


class DraftExchange(QObject):
    """Shared by the pages; any of them may be missing."""

    used = Signal(object)
    """Values by the setting's key, to become drafts in Settings, unsent."""
    limits_used = Signal()
    """`LimitsInUse` are those of another profile."""
    measured = Signal()
    """The light threshold is to be measured in Settings."""

    review_wanted = Signal()
    """The trigger records that nobody has reviewed are to be looked at in Triggers."""

    def __init__(self) -> None:
        super().__init__()
        self.can_use: Callable[[], bool] = bool
        """Whether Settings takes drafts: there is a module to write to."""


@dataclass(frozen=True, slots=True)
class Services:
    """What the pages share."""

    ports: Ports
    appearance: Appearance
    preferences: Preferences = field(default_factory=Preferences)
    armed: Armed = field(default_factory=Armed)
    """What is armed in this window; the procedures ask it too."""
    log: Log | None = None
    in_use: LimitsInUse = field(default_factory=LimitsInUse)
    """What measured values are compared with, wherever they are shown."""
    exchange: DraftExchange = field(default_factory=DraftExchange)
    """What one page hands to another."""

    @property
    def lock(self) -> LockControl:
        return self.ports.lock

    @property
    def storage(self) -> Storage:
        return self.ports.storage


class PageEntry(NamedTuple):
    """One line of the navigation. `make` is called when the page is first wanted, or when the window is idle."""

    key: str
    title: str
    """English, marked."""
    icon: Icon
    make: Callable[[Services], Page]
    chapter: str = ""
    """Its chapter of the guide, in English as the guide has it; else that of the same title."""
    wants_stream: bool = False
    """While it is in sight the module streams its status."""
