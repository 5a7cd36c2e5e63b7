"""What the window knows of a page, and the services that a page is given."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtCore import QObject, Signal

from app.limits.limits import LimitsInUse
from app.procedures.act import Armed
from app.system.logs import Log
from ui.core.preferences import Preferences
from ui.services.storage import Storage
from ui.session.ports import LockControl, Ports
from ui.style.appearance import Appearance
from ui.style.icons import Icon

if TYPE_CHECKING:
    from ui.services.page import Page


class DraftExchange(QObject):
    """The ways in which one page hands something to another; any of them may be missing."""

    used = Signal(object)  # Values by the setting's key, to become drafts in Settings, unsent
    limits_used = Signal()  # `LimitsInUse` are those of another profile
    measured = Signal()  # The light threshold is to be measured in Settings
    review_wanted = Signal()  # The trigger records that nobody has reviewed are to be looked at in Triggers

    def __init__(self) -> None:
        super().__init__()
        # Whether Settings takes drafts: there is a module to write to.
        self.can_use: Callable[[], bool] = bool


@dataclass(frozen=True, slots=True)
class Services:
    """The services that the pages share."""

    ports: Ports
    appearance: Appearance
    preferences: Preferences = field(default_factory=Preferences)
    # What is armed in this window; the procedures ask it too.
    armed: Armed = field(default_factory=Armed)
    log: Log | None = None
    # What measured values are compared with, wherever they are shown.
    in_use: LimitsInUse = field(default_factory=LimitsInUse)
    exchange: DraftExchange = field(default_factory=DraftExchange)

    @property
    def lock(self) -> LockControl:
        return self.ports.lock

    @property
    def storage(self) -> Storage:
        return self.ports.storage


class PageEntry(NamedTuple):
    """One line of the navigation. `title` is English, marked. `load` imports what `make` needs, a step of its own as
    either takes long."""

    key: str
    title: str
    icon: Icon
    make: "Callable[[Services], Page]"
    # Its chapter of the guide, in English as the guide has it.
    chapter: str = ""
    # While it is in sight the module streams its status.
    wants_stream: bool = False
    load: Callable[[], object] = bool
