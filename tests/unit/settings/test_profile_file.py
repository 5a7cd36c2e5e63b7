"""Profile files: what is refused, hostile files, and round trips."""

import os
import tomllib
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.guided.results import GuidedKind
from app.settings import profile_file
from app.settings.profile_file import (
    MAX_TEST_DAYS,
    ProfileRefused,
    parse_profile,
    profile_text,
    read_profile,
    save_profile,
)
from app.settings.profiles import LIMITS, ActivatedBy, ManualLine, Profile
from app.settings.values import SETTINGS_BY_KEY
from protocol.fields import Quantity

WHOLE = """\
format = 1
name = "Survey hexacopter"
airframe = "H6"
light_inverted = true
approved_fingerprint = "OPQ7-5ZRY"
notes = \"\"\"
[settings]
freefall_time_s = "not a key, a note"
\"\"\"

[settings]
attitude_threshold_deg = 60
freefall_acceleration_g = 0.5
freefall_time_s = 1.60
light_threshold_v = 2
attitude_trigger = true
freefall_trigger = false
serial_output = false
baud_rate = 115200

[limits]
cell_voltage_min_v = 3.8

[expectations]
activated_by = "aircraft"

[[manual]]
text = "Bridle free"
required = true

[[manual]]
text = "Pack date"
"""


def test_a_whole_profile() -> None:
    profile = parse_profile(WHOLE.encode())
    answered = profile.answered({2: False})
    assert answered == Profile(
        name="Survey hexacopter",
        airframe="H6",
        limits={"cell_voltage_min_v": 3.8},
        settings=tomllib.loads(WHOLE)["settings"],
        activated_by=ActivatedBy.AIRCRAFT,
        is_light_inverted=True,
        approved_fingerprint="OPQ7-5ZRY",
        manual=(ManualLine("Bridle free", is_required=True), ManualLine("Pack date", is_done=False)),
        notes=profile.notes,
    )
    assert (answered.limit("cell_voltage_min_v"), answered.limit("tilt_spread_max_deg")) == (3.8, 2)
    assert parse_profile(profile_text(profile).encode()) == profile


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("format = 2", "format: expected 1."),
        ('name = "' + "x" * 201 + '"', 'name: expected "…", 0 … 200.'),
        ("settings = 3", "settings: expected […]."),
        ("[[manual]]\nrequired = true", 'manual 1.text: expected "…".'),
        ('[[manual]]\ntext = "a"\n[[manual]]\ntext = "b"\ncolour = 1', "“manual 2.colour” is unknown."),
        ("light_inverted = 1", "light_inverted: expected true, false."),
        ("[limits]\ntilt_max_deg = nan", "limits.tilt_max_deg: expected 0 … 15."),
        ("[tests]\ntilt = 1.5", "tests.tilt: expected 1 … 3650."),
        ("[settings]\nfreefall_time_s = 1.605",
         "settings.freefall_time_s: 1.605: the nearest steps are 1.60 s and 1.61 s."),
        ("freefall_time_s = = 2", "not TOML: Invalid value (at line 1, column 19)."),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_by_its_key(text: str, said: str) -> None:
    with pytest.raises(ProfileRefused) as refused:
        parse_profile(text.encode())
    assert refused.value.sentence == said


def test_its_texts_show_what_they_are() -> None:
    profile = parse_profile(b'name = "a\\u202Eb"\nnotes = "a\\nb\\u0000"\n[[manual]]\ntext = "\\u0007c"')
    assert (profile.name, profile.notes) == ("a[U+202E]b", "a\nb[U+0000]")
    assert profile.manual == (ManualLine("[U+0007]c"),)


@pytest.mark.parametrize("data", [
    b"#" * (profile_file.LARGEST_BYTES + 1), b"\xff\xfe" + WHOLE.encode("utf-16-le"), b"a=" + b"[" * 120_000,
    b"a" + b" " * 120_000, b"=\n" * 60_000, ("'" + "\u202e" * 100 + "' = 1").encode(),
    b"format = 1" + b"0" * 4000, b"[limits]\ntilt_max_deg = 0x" + b"F" * 6000,
    b"[settings]\nattitude_trigger = 1" + b"0" * 4000,
], ids=["large", "UTF-16", "nested", "key", "errors", "turned", "format", "limit", "switch"])  # fmt: skip
@pytest.mark.promise("g")
def test_hostile_files_are_refused_soon_with_short_printable_errors(data: bytes) -> None:
    with pytest.raises(ProfileRefused) as refused:
        parse_profile(data)
    assert refused.value.sentence.isprintable()
    assert len(refused.value.sentence) < 300


def test_a_missing_file_and_a_profile_without_a_name(tmp_path: Path) -> None:
    for none in (tmp_path / "none.toml", tmp_path, Path("a\0b")):
        with pytest.raises(ProfileRefused, match="cannot be read"):
            read_profile(none)
    (tmp_path / "bad.toml").write_text("junk = [", encoding="utf-8")
    with pytest.raises(ProfileRefused, match=r"bad\.toml is not a profile: not TOML"):
        read_profile(tmp_path / "bad.toml")
    (tmp_path / "H6.toml").write_text("[settings]\nfreefall_time_s = 1.2\n", encoding="utf-8")
    assert read_profile(tmp_path / "H6.toml").name == "H6"


def test_saving_is_atomic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "p.toml"
    old = Profile(name="old", settings={"freefall_time_s": 1.2})
    save_profile(path, old)
    with pytest.raises(ProfileRefused):
        save_profile(path, Profile(name="a" * 300))

    def full(_file: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        save_profile(path, Profile(name="new"))
    assert read_profile(path) == old
    assert [one.name for one in tmp_path.iterdir()] == ["p.toml"]


CHARACTERS = st.characters(
    exclude_categories=("Cc", "Cn", "Co", "Cs", "Zl", "Zp"),
    exclude_characters="\u061c\u200b\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\ufeff",
)
"""Those that stand for themselves. A filter would leave out too many, which is a failure."""
# With the letter that is added to it, no text of a manual check is too long.
NAMES, TEXTS = st.text(CHARACTERS, max_size=200), st.text(CHARACTERS, max_size=199)
SETTINGS = st.fixed_dictionaries(
    {},
    optional={
        key: st.integers(0, 255).map(command.write.decode)
        if isinstance(command.write, Quantity)
        else st.sampled_from([4800, 9600, 115200] if key == "baud_rate" else [True, False])
        for key, command in SETTINGS_BY_KEY.items()
    },
)
LIMIT_VALUES = st.fixed_dictionaries(
    {},
    optional={
        name: st.floats(allowed.low, allowed.high)
        for name, allowed in LIMITS.items()
        if name not in ("acceleration_min_g", "acceleration_max_g")
    },
)
PROFILES = st.builds(
    Profile,
    name=NAMES,
    airframe=NAMES,
    notes=st.lists(TEXTS, max_size=3).map("\n\t".join),
    settings=SETTINGS,
    limits=LIMIT_VALUES,
    manual=st.lists(st.builds(ManualLine, TEXTS.map("{}x".format), st.booleans(), st.none()), max_size=3).map(tuple),
    approved_fingerprint=st.sampled_from([None, "OPQ7-5ZRY"]),
    is_light_inverted=st.booleans(),
    is_service_required=st.booleans(),
    activated_by=st.sampled_from(ActivatedBy),
    tests_within_days=st.dictionaries(st.sampled_from(GuidedKind), st.integers(1, MAX_TEST_DAYS)),
)


@given(PROFILES, PROFILES)
def test_what_is_written_is_read_back_also_into_the_file_of_another(before: Profile, after: Profile) -> None:
    written = profile_text(before)
    assert parse_profile(written.encode()) == before
    assert parse_profile(profile_text(after, written).encode()) == after


COMMENTED = """\
# measured on 2026-01-02
format = 1
name = "H6"  # the big one

[limits]  # ours
tilt_max_deg = 3  # the tail is heavy
cell_voltage_min_v = 3.90

# settings last
[settings]
light_threshold_v = 2
freefall_time_s = 1.60  # as it came

# before the flight
[[manual]]
text = "Bridle free"  # both ends

[[manual]]
text = "Hatch free"
"""


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_comments_and_order_of_a_persons_file_survive(tmp_path: Path, newline: str) -> None:
    path, other = tmp_path / "h6.toml", tmp_path / "other.toml"
    path.write_bytes(COMMENTED.replace("\n", newline).encode())
    profile = read_profile(path)
    save_profile(path, profile, source=path)
    assert path.read_bytes() == COMMENTED.replace("\n", newline).encode()
    changed = profile._replace(airframe="hexa", limits={"tilt_max_deg": 4})
    save_profile(other, changed, source=path)
    assert read_profile(other) == changed
    lines = other.read_bytes().decode().replace(newline, "\n").splitlines()
    lost = [line for line in COMMENTED.splitlines() if line not in lines]
    limits = [
        "tilt_max_deg = 3  # the tail is heavy",
        "cell_voltage_min_v = 3.90",
        "# settings last",
    ]
    assert lost == limits, "only the part that changed is written anew"
    assert lines.index("[settings]") < lines.index("# before the flight") < lines.index("[[manual]]")


def test_a_source_that_is_no_profile_any_more_costs_only_its_comments(tmp_path: Path) -> None:
    path = tmp_path / "h6.toml"
    profile = Profile(name="H6", settings={"freefall_time_s": 1.2})
    for content in (b"[", b"colour = 1", b"x" * 200_000, None):
        path.unlink(missing_ok=True)
        if content is not None:
            path.write_bytes(content)
        save_profile(path, profile, source=path)
        assert read_profile(path) == profile


@given(st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    with suppress(ProfileRefused):
        parse_profile(data)
