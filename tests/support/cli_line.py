"""Helpers for tests of the command line: what is printed, and what was sent."""

from collections.abc import Callable, Sequence

import pytest

import app.__main__ as program
from protocol.messages import decode_request


class Printed:
    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self.out, self.err = capsys.readouterr()


def run_here(capsys: pytest.CaptureFixture[str], words: Sequence[str], code: int = 0) -> Printed:
    """Run `dps-s` in this process, and check its exit code."""
    found, printed = program.main(words), Printed(capsys)
    assert found == code, printed.err
    return printed


def faults(name: str, value: object) -> list[str]:
    """Where JSON is not as the published schema of this name says."""
    from jsonschema import Draft202012Validator  # 4 MB, only where it is used

    from app.cli.schema import schema_of

    if isinstance(value, dict) and value.keys() == {"error"}:
        name = "error"
    validator = Draft202012Validator(schema_of(name), format_checker=Draft202012Validator.FORMAT_CHECKER)
    return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(value)]


def sets(wire: Sequence[bytes]) -> list[str]:
    """What was sent besides questions, in order."""
    return [request.command.name for request in map(decode_request, wire) if not request.is_repeatable]


Program = Callable[..., Printed]
"""`run_here`, as a fixture gives it: called with the words and the exit code."""
