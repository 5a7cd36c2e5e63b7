"""The one exception whose text a person reads."""

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType

from app.text.messages import UserMessage, message


class ErrorCode(StrEnum):
    """Why a command has no result: the closed list of the command line's contract."""

    USAGE = "usage"
    NO_PORT = "no_port"
    BUSY = "busy"
    NO_PERMISSION = "no_permission"
    NO_LINK = "no_link"
    INTERRUPTED = "interrupted"
    REFUSED = "refused"
    NOT_CONFIRMED = "not_confirmed"
    NOT_VERIFIED = "not_verified"
    UNREADABLE = "unreadable"
    NOT_JUDGED = "not_judged"
    STORE = "store"
    CANCELLED = "cancelled"
    INTERNAL = "internal"

    @property
    def exit_code(self) -> int:
        return EXIT_CODES[self]


EXIT_CODES: Mapping[ErrorCode, int] = MappingProxyType(
    {
        ErrorCode.USAGE: 2,
        ErrorCode.UNREADABLE: 2,
        ErrorCode.NOT_JUDGED: 2,
        ErrorCode.NO_PORT: 3,
        ErrorCode.BUSY: 3,
        ErrorCode.NO_PERMISSION: 3,
        ErrorCode.NO_LINK: 3,
        ErrorCode.INTERRUPTED: 3,
        ErrorCode.REFUSED: 1,
        ErrorCode.NOT_CONFIRMED: 1,
        ErrorCode.NOT_VERIFIED: 1,
        ErrorCode.STORE: 1,
        ErrorCode.INTERNAL: 1,
        ErrorCode.CANCELLED: 130,
    }
)


class UserError(Exception):
    """Something cannot be had or done; the text says what, why and, where a person can help it, what to do.

    `text` is `marked` if it is translatable; `values` fill its places. As text the error is English, for logs.
    """

    code = ErrorCode.USAGE
    """Of a command that it ends."""
    what = ""
    hint = ""
    """The two parts of the sentence, what happened and what to do next, where they are known apart."""

    def __init__(self, text: str | UserMessage, /, **values: object) -> None:
        self.message = text if isinstance(text, UserMessage) else message(text, **values)
        super().__init__(self.message)  # the only argument, so that it can be pickled

    def __str__(self) -> str:
        return self.message.in_english()

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        return self.message.translated()
