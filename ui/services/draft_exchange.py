"""Exchanges drafts between the Settings page and "Would it have fired?". Nothing is sent."""

from collections.abc import Callable, Mapping

from PySide6.QtCore import QObject, Signal

from protocol.fields import Value


class DraftExchange(QObject):
    """Shared by the two pages; either may be missing."""

    used = Signal(object)
    """Values by the setting's key, to become drafts in Settings, unsent."""
    tried = Signal(object)
    """Values by the setting's key, to be tried on what was measured."""
    measured = Signal()
    """The light threshold is to be measured in Settings."""

    def __init__(self) -> None:
        super().__init__()
        self.find_drafts: Callable[[], Mapping[str, Value]] = dict
        """What Settings wants now and has not sent."""
        self.can_use: Callable[[], bool] = bool
        """Whether Settings takes drafts: there is a module to write to."""
