"""Starts `dps-s` where it was installed by pip, after checking that its packages are its own.

They are called `app`, `protocol` and `ui`. In a shared environment another program may have overwritten or removed
them: that is reported in one sentence instead of an ImportError.
"""

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from app.text.i18n import set_language, system_language, tr

OURS: Final = {"app": "__main__.py", "protocol": "translatable.py", "ui": "main.py"}
"""The packages, each with a file that it must contain."""
FOREIGN: Final = 3


def main() -> int:
    """Run the program; returns the exit code."""
    sentence = foreign_package()
    if sentence is not None:
        print(sentence, file=sys.stderr)
        return FOREIGN
    from app.__main__ import main as run

    return run()


def foreign_package() -> str | None:
    """A sentence about a package that is not this program's, or None."""
    top = Path(__file__).resolve().parents[1]
    for name, file in OURS.items():
        found = find_spec(name)
        places = [] if found is None else [Path(place) for place in found.submodule_search_locations or ()]
        if not any(place.resolve() == top / name for place in places) or not (top / name / file).is_file():
            set_language(system_language())
            place = places[0] if places else top / name
            return tr(
                "“{name}” in {place} is not this program's: install it with pipx or uv tool.", name=name, place=place
            )
    return None
