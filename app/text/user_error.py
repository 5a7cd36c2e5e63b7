"""The one exception whose text a person reads."""

from enum import StrEnum

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
    UNREADABLE = "unreadable"
    NOT_JUDGED = "not_judged"
    STORE = "store"
    CANCELLED = "cancelled"
    INTERNAL = "internal"

    @property
    def exit_code(self) -> int:
        return _EXIT_CODES.get(self, 1)


_EXIT_CODES = {
    **dict.fromkeys((ErrorCode.USAGE, ErrorCode.UNREADABLE, ErrorCode.NOT_JUDGED), 2),
    **dict.fromkeys((ErrorCode.NO_PORT, ErrorCode.BUSY, ErrorCode.NO_PERMISSION), 3),
    **dict.fromkeys((ErrorCode.NO_LINK, ErrorCode.INTERRUPTED), 3),
    ErrorCode.CANCELLED: 130,
}


class UserError(Exception):
    """Something cannot be had or done. Its text says what, why and, where a person can help it, what to do.

    `text` is `marked` if it is translatable; `values` fill its place-holders. As text the error is English, for logs.
    """

    # Why a command that it ends has no result.
    code = ErrorCode.USAGE
    # What happened, and what to do next, where the two are known apart.
    what = ""
    hint = ""

    def __init__(self, text: str | UserMessage, /, **values: object) -> None:
        self.message = text if isinstance(text, UserMessage) else message(text, **values)
        super().__init__(self.message)  # the only argument, so that it can be pickled

    def __str__(self) -> str:
        return self.message.in_english()

    @property
    def sentence(self) -> str:
        """The text in the language in use now."""
        return self.message.translated()
