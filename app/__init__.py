"""Between the bytes and the window: the port, the clock, the files and the procedures.  Free of Qt."""

from importlib import metadata


def version() -> str:
    """The version of the installed distribution; ``pyproject.toml`` is the one place that states it."""
    return metadata.version("dps-s-configurator")
