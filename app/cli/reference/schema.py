"""`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json."""

import argparse
import json

from app.cli.reference.schemas import NAMES, schema_of
from app.terminal.console import DONE, write
from app.text.i18n import tr


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "schema",
        description=tr("Print the JSON Schema of what a command prints with --json, or of the record of a check."),
    )
    parser.add_argument("name", choices=NAMES, help=tr("the command, or record"))
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    write(text_of(args.name))
    return DONE


def text_of(name: str) -> str:
    """As it is published in docs/schemas."""
    return json.dumps(schema_of(name), indent=2, ensure_ascii=False) + "\n"
