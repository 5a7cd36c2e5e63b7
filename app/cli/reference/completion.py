"""`dps-s completion bash|zsh|fish`: prints a completion script."""

import argparse

from app.terminal import console

SHELLS = ("bash", "zsh", "fish")


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser("completion", epilog=_INSTALL, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shell", choices=SHELLS)
    parser.set_defaults(run=run, parser=None)


_INSTALL = """\
bash   dps-s completion bash > ~/.local/share/bash-completion/completions/dps-s
zsh    dps-s completion zsh > ~/.zfunc/_dps-s    (~/.zfunc in $fpath before compinit)
fish   dps-s completion fish > ~/.config/fish/completions/dps-s.fish"""


def run(args: argparse.Namespace) -> int:
    """`args.parser` knows all commands; `app.__main__` puts it there."""
    from app.cli.reference import completion_scripts
    from app.cli.reference.command_tree import tree_of
    from app.preflight.reading_object import SETTING_KEYS
    from protocol.catalogue import SETTINGS
    from protocol.fields import Choice, Flag

    values: dict[str, tuple[str, ...]] = dict.fromkeys(SETTING_KEYS, ())
    for command in SETTINGS:
        match command.write:
            case Flag():
                values[command.key] = ("true", "false")
            case Choice(values=choices):
                values[command.key] = tuple(str(one) for one in choices.values())
    script = {"bash": completion_scripts.bash, "zsh": completion_scripts.zsh, "fish": completion_scripts.fish}
    console.write(script[args.shell](tree_of(args.parser), values))
    return console.DONE
