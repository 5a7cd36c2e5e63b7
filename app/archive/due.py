"""What a module may need."""

from enum import StrEnum


class DueKind(StrEnum):
    """The value is the word in JSON."""

    NO_CHECK = "no_check"
    NO_GO = "no_go"
    OLD_CHECK = "old_check"
    TRIGGER_RECORDS = "trigger_records"
    TEST = "test"
    OLD_TEST = "old_test"
    SERVICE = "service"
    TWO_MODULES = "two_modules"
