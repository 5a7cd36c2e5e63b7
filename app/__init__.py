"""Between the bytes and the window: the port, the clock, the files and the procedures.  Free of Qt."""

import sys
from pathlib import Path


def version() -> str:
    """The version of the installed distribution; ``pyproject.toml`` is the one place that states it.

    The name of the distribution's folder has it. To load `importlib.metadata` takes longer than all else of
    ``dps-s --version``.
    """
    for place in sys.path:
        for folder in Path(place).glob("dps_s_configurator-*.dist-info"):
            return folder.name.split("-")[1].removesuffix(".dist")
    raise LookupError("DPS-S Configurator is not installed")
