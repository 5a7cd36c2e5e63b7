"""The system libraries that Qt needs on Linux: which, by which package, and whether they are there."""

import sys

import pytest

from app.system import qt_libraries


@pytest.mark.parametrize(
    ("release", "package"),
    [
        ('ID=debian\nVERSION_ID="12"\n', "libglib2.0-0"),
        ('ID=debian\nVERSION_ID="13"\n', "libglib2.0-0t64"),
        ("ID=debian\n", "libglib2.0-0t64"),
        ('ID=ubuntu\nID_LIKE=debian\nVERSION_ID="22.04"\n', "libglib2.0-0"),
        ('ID=ubuntu\nID_LIKE=debian\nVERSION_ID="24.04"\n', "libglib2.0-0t64"),
        ('ID=linuxmint\nID_LIKE="ubuntu debian"\nVERSION_ID="21.3"\n', "libglib2.0-0"),
        ('ID=linuxmint\nID_LIKE="ubuntu debian"\nVERSION_ID="22"\n', "libglib2.0-0t64"),
    ],
)
def test_glib_by_its_name_of_the_release(release: str, package: str) -> None:
    assert qt_libraries.has_time_t_64_names(release) == package.endswith("t64")


def test_a_library_is_found_or_missing() -> None:
    absent = qt_libraries.Library("libdps-s-absent.so.9", "a", "b", "c", "d")
    soname = {"win32": "kernel32.dll", "darwin": "libSystem.B.dylib"}.get(sys.platform, "libc.so.6")
    present = qt_libraries.Library(soname, "libc6", "glibc", "glibc", "glibc")
    assert qt_libraries.missing((present, absent)) == (absent,)


@pytest.mark.parametrize(
    ("environ", "is_screen_wanted", "extra"),
    [
        ({}, True, None),
        ({"DISPLAY": ":0"}, False, None),
        ({"DISPLAY": ":0"}, True, "FOR_X"),
        ({"DISPLAY": ":0", "QT_QPA_PLATFORM": "offscreen"}, True, None),
        ({"WAYLAND_DISPLAY": "wayland-0"}, True, "FOR_WAYLAND"),
        ({"DISPLAY": ":0", "WAYLAND_DISPLAY": "wayland-0"}, True, "FOR_X"),
        (
            {"DISPLAY": ":0", "WAYLAND_DISPLAY": "wayland-0", "XDG_SESSION_TYPE": "wayland"},
            True,
            "FOR_WAYLAND",
        ),
        ({"DISPLAY": ":0", "WAYLAND_DISPLAY": "wayland-0", "QT_QPA_PLATFORM": "xcb"}, True, "FOR_X"),
    ],
)
def test_the_libraries_for_the_screen_that_there_is(
    monkeypatch: pytest.MonkeyPatch,
    environ: dict[str, str],
    is_screen_wanted: bool,
    extra: str | None,
) -> None:
    for variable in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM", "XDG_SESSION_TYPE"):
        monkeypatch.delenv(variable, raising=False)
    for variable, value in environ.items():
        monkeypatch.setenv(variable, value)
    wanted = qt_libraries.wanted_libraries(is_screen_wanted=is_screen_wanted)
    assert wanted == qt_libraries.ALWAYS + (getattr(qt_libraries, extra) if extra else ())
