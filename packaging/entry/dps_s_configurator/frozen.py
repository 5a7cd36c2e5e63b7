"""PyInstaller begins here: the bundle's `dps-s` and, on Windows, `dps-s-window`."""

import os
import sys

import dps_s_configurator


def restore_library_path() -> None:
    """Programs that this one starts, such as the browser, must not load the bundle's libraries."""
    original = os.environ.pop("LD_LIBRARY_PATH_ORIG", None)
    if original is not None:
        os.environ["LD_LIBRARY_PATH"] = original
    else:
        os.environ.pop("LD_LIBRARY_PATH", None)


if __name__ == "__main__":
    if sys.platform.startswith("linux"):
        restore_library_path()
    sys.exit(dps_s_configurator.open_window())
