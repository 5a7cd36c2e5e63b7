"""Whether the two automatic triggers are enabled. A module cannot be asked (E8): it is known only of what was set."""

from typing import NamedTuple

from app.engine.conversation import ConversationView
from app.text.i18n import tr
from protocol.catalogue import BY_NAME
from protocol.translatable import marked

TILT_TRIGGER = BY_NAME["attitude_trigger"].key
FALL_TRIGGER = BY_NAME["freefall_trigger"].key
TRIGGER_OFF = marked("trigger off")
TRIGGER_NOT_KNOWN = marked("trigger not known")


class TriggerFlags(NamedTuple):
    """None where it is not known."""

    tilt: bool | None = None
    fall: bool | None = None

    @property
    def are_on(self) -> bool:
        return self.tilt is True and self.fall is True

    @property
    def is_one_off(self) -> bool:
        return self.tilt is False or self.fall is False

    @property
    def text(self) -> str:
        """In the language in use. One that is off is said even where the other is not known."""
        if self.tilt is False and self.fall is False:
            return tr("both off")
        if self.tilt is False:
            return tr("tilt off")
        if self.fall is False:
            return tr("fall off")
        return tr("both on") if self.are_on else tr("not known")

    @staticmethod
    def texts() -> tuple[str, ...]:
        """All that `text` may be."""
        flags = (True, True), (False, False), (False, None), (None, False), (None, None)
        return tuple(TriggerFlags(tilt, fall).text for tilt, fall in flags)


def trigger_flags(conversation: ConversationView, now: float) -> TriggerFlags:
    tilt = conversation.fresh(TILT_TRIGGER, now)
    fall = conversation.fresh(FALL_TRIGGER, now)
    return TriggerFlags(tilt if isinstance(tilt, bool) else None, fall if isinstance(fall, bool) else None)
