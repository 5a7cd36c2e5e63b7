"""The one exception whose text a person reads."""

from app.text.messages import UserMessage, message


class UserError(Exception):
    """Something cannot be had or done; the text says what, why and, where a person can help it, what to do.

    `text` is `marked` if it is translatable; `values` fill its places. As text the error is English, for logs.
    """

    exit_code = 2
    """Of a command that it ends."""

    def __init__(self, text: str | UserMessage, /, **values: object) -> None:
        self.message = text if isinstance(text, UserMessage) else message(text, **values)
        super().__init__(self.message)  # the only argument, so that it can be pickled

    def __str__(self) -> str:
        return self.message.in_english()

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        return self.message.translated()
