"""Between the bytes and the window: the port, the clock, the files and the procedures.  Free of Qt."""


def version() -> str:
    """The version of the installed distribution; ``pyproject.toml`` is the one place that states it."""
    from importlib import metadata  # takes as long to load as all of the protocol, and few runs ask for the version

    return metadata.version("dps-s-configurator")
