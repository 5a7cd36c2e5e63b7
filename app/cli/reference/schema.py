"""`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json."""

import argparse
import json

from app.cli.reference.schemas import NAMES, schema_of
from app.terminal import console


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser("schema")
    parser.add_argument("name", choices=NAMES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    console.write(text_of(args.name))
    return console.DONE


def text_of(name: str) -> str:
    """As it is published in docs/schemas."""
    return json.dumps(schema_of(name), indent=2, ensure_ascii=False) + "\n"
