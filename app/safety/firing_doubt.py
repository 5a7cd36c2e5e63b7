"""Whether a module may have fired before it restarted: its voltage may break down while it fires.

It reports NOT TRIGGERED after the restart then, and only its trigger records tell. So until they were read, and a
person has closed the notice about it, "may have fired before the restart" stands in the place of NOT TRIGGERED, and no
check comes to READY.
"""

import logging

from app.engine.conversation import ConversationView
from protocol.catalogue import BOOTS
from protocol.events import EndReason

_log = logging.getLogger(__name__)


class FiringDoubt:
    """Of one port. For one thread."""

    def __init__(self) -> None:
        self._is_raised = False
        self._has_read_records = False
        self._is_notice_closed = False
        # Of a module that may have fired in the silence that ended its conversation.
        self._boot_count_before: int | None = None

    @property
    def is_open(self) -> bool:
        return self._is_raised and not (self._has_read_records and self._is_notice_closed)

    @property
    def is_to_be_told(self) -> bool:
        """No person has closed the notice about it yet."""
        return self._is_raised and not self._is_notice_closed

    def note_ended(self, conversation: ConversationView, *, was_active: bool = False) -> None:
        """To be called once with each conversation that has ended. `was_active`: it was ACTIVE a moment before, and was
        not locked from here: a module that restarted reports LOCKED before its boot count tells of the restart."""
        self._boot_count_before = None
        if conversation.ended is None or not (was_active or _may_fire(conversation)):
            return
        if conversation.ended.reason is EndReason.RESTARTED:
            self._raise()
        else:
            self._boot_count_before = conversation.boot_count

    def note_begun(self, conversation: ConversationView) -> None:
        """To be called with each conversation once it has begun. One start more is this module again; after a silence
        without a restart it still reports itself that it has fired."""
        before, self._boot_count_before = self._boot_count_before, None
        if before is not None and conversation.boot_count == (before + 1) % BOOTS:
            self._raise()

    def note_records_read(self) -> None:
        """The trigger records were read in the conversation after the restart."""
        self._has_read_records = True

    def note_closed(self) -> None:
        """A person has closed the notice."""
        self._is_notice_closed = True

    def _raise(self) -> None:
        _log.debug("the module may have fired before it restarted")
        self._is_raised = True
        self._has_read_records = self._is_notice_closed = False


def _may_fire(conversation: ConversationView) -> bool:
    """Whether it was ACTIVE, or an act of which nothing was reported may have made it so."""
    active = conversation.values.get("active")
    if active is None:
        return "tilt_deg" in conversation.values
    return active.value is True
