"""The folder of this program's data."""

from pathlib import Path


def data_folder() -> Path:
    from platformdirs import user_data_path

    return user_data_path("dps-s-configurator", appauthor=False)
