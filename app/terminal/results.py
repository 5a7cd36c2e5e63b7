"""What the results of all commands have in common. `dps-s schema NAME` prints the schema of each.

The structure that a command prints with --json stands beside it. A value that is not known is null. Names have the unit
in them. A field that is only there sometimes is left out where it has nothing to say (`UNSET`).
"""

from typing import Annotated, Any, Self

from msgspec import Meta, Struct

from app.text.messages import ErrorCode
from protocol.catalogue import BY_NAME, SETTINGS

Value = bool | int | float | str | None
Byte = Annotated[int, Meta(ge=0, le=255)]
Count = Annotated[int, Meta(ge=0)]
Hex = Annotated[str, Meta(pattern=r"^([0-9A-F]{2}( [0-9A-F]{2})*)?$")]
Time = Annotated[str, Meta(extra_json_schema={"format": "date-time"})]  # ISO 8601 with an offset
SettingName = Annotated[str, Meta(pattern=f"^({'|'.join(command.key for command in SETTINGS)})$")]
CommandName = Annotated[str, Meta(pattern=f"^({'|'.join(BY_NAME)})$")]


class Result(Struct, forbid_unknown_fields=True):
    """A result has no other fields than those of its structure."""

    @classmethod
    def of(cls, source: object, **values: Any) -> Self:
        """Take the fields that are not among `values` from the attributes of `source`, if there is one."""
        missing = [] if source is None else [name for name in cls.__struct_fields__ if name not in values]
        return cls(**{name: getattr(source, name) for name in missing}, **values)


class FailureJson(Result):
    """Why a command has no result. `hint` is what to do next, or empty."""

    code: ErrorCode
    message: str
    hint: str


class ErrorJson(Result):
    """Printed in the place of a result."""

    error: FailureJson
