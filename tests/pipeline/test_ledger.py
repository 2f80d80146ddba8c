"""The ledger gives back what was recorded, and leaves out whatever is not as it was written."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from emg2vsa.pipeline.fingerprint import part_of
from emg2vsa.pipeline.ledger import Entry, Ledger, Parts, differences

CODE, LIBRARIES = part_of({"emg2vsa.fits": "c"}), part_of({"numpy": "2"})
PARTS = Parts(part_of({"fit": {"bin_n": 0.3}}), {"a.bdf": "1"}, {"trials/P1/S1": "k"}, CODE, LIBRARIES)


def entry(step: str = "fits/P1/S1", key: str = "k1", status: str = "done") -> Entry:
    return Entry(step, key, status, "", False, f"digest of {key}", PARTS)


def told(found: Entry | None) -> object:
    """An entry as something that can be compared."""
    if found is None:
        return None
    shared = (found.parts.settings.value, found.parts.code.value, found.parts.libraries.value)
    return found.step, found.key, found.status, found.result, found.parts.files, found.parts.inputs, shared


def read(folder: Path) -> tuple[Ledger, list[str]]:
    warnings: list[str] = []
    return Ledger(folder, warnings.append), warnings


def with_entries(folder: Path, *entries: Entry) -> Path:
    ledger = Ledger(folder)
    for each in entries:
        ledger.record(each)
    return folder / "ledger.jsonl"


def test_the_newest_counts_and_the_one_before_is_found_again(tmp_path: Path) -> None:
    with_entries(tmp_path, entry(key="k0"), entry(key="k1"), entry(key="k2", status="failed"))
    ledger, warnings = read(tmp_path)
    assert told(ledger.last("fits/P1/S1")) == told(entry(key="k2", status="failed"))
    assert told(ledger.with_key("fits/P1/S1", "k1")) == told(entry(key="k1"))
    assert ledger.with_key("fits/P1/S1", "k0") is None
    assert ledger.keys("fits/P1/S1") == ["k2", "k1"]
    assert ledger.last("fits/P2/S1") is None
    assert warnings == []


def test_what_steps_share_is_written_once(tmp_path: Path) -> None:
    path = with_entries(tmp_path, *(entry(f"fits/P{n}/S1") for n in range(9)))
    assert path.read_text().count('"emg2vsa.fits"') == 1
    assert len(read(tmp_path)[0].keys("fits/P8/S1")) == 1
    read(tmp_path)[0].record(entry("fits/P9/S1"))  # nor by the next program
    assert path.read_text().count('"emg2vsa.fits"') == 1


def test_half_a_last_line_is_skipped_and_removed(tmp_path: Path) -> None:
    path = with_entries(tmp_path, entry())
    path.write_bytes(path.read_bytes() + b'{"step": "fits/P1/S2", "ke')
    ledger, warnings = read(tmp_path)
    assert told(ledger.last("fits/P1/S1")) == told(entry())
    assert warnings == []
    ledger.record(entry("fits/P1/S3"))
    again, warnings = read(tmp_path)
    assert told(again.last("fits/P1/S3")) == told(entry("fits/P1/S3"))
    assert again.last("fits/P1/S2") is None
    assert warnings == []


def test_every_flipped_bit_is_noticed(tmp_path: Path) -> None:
    steps = [f"fits/P{n}/S1" for n in range(4)]
    path = with_entries(tmp_path, *map(entry, steps))
    whole, draw = path.read_bytes(), random.Random(12)
    for _ in range(200):
        at = draw.randrange(len(whole) - 1)
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 1 << draw.randrange(8)]) + whole[at + 1 :])
        ledger, warnings = read(tmp_path)
        assert len(warnings) == 1
        found = [ledger.last(step) for step in steps]
        assert None in found
        assert all(told(one) in (None, told(entry(step))) for step, one in zip(steps, found, strict=True))


@pytest.mark.parametrize(
    "line", [b"\xff\xfe\x00", b"[1]", b"5", b"null", b'"text"', b'{"parts": 3}', b'{"step": "x"}', b"{", b"[" * 9**5]
)
def test_a_line_of_another_shape_is_left_out_with_one_warning(tmp_path: Path, line: bytes) -> None:
    path = with_entries(tmp_path, entry())
    path.write_bytes(line + b"\n" + path.read_bytes())
    ledger, warnings = read(tmp_path)
    assert warnings == [f"{path} is damaged: 1 line left out. What they told of is done again."]
    assert told(ledger.last("fits/P1/S1")) == told(entry())
    ledger.compact()
    assert read(tmp_path)[1] == []
    assert told(read(tmp_path)[0].last("fits/P1/S1")) == told(entry())


def test_lines_of_0_1_0_are_one_sentence(tmp_path: Path) -> None:
    old = {"step": "fits/P1/S1", "key": "k", "status": "done", "parts": {"code": {"emg2vsa.fits": "c"}, "settings": {}}}
    (tmp_path / "ledger.jsonl").write_text(f"{json.dumps(old)}\n" * 3)
    ledger, warnings = read(tmp_path)
    assert warnings == [f"{tmp_path} holds results of version 0.1.0. They are not used; everything runs once more."]
    assert ledger.last("fits/P1/S1") is None
    ledger.compact()
    assert read(tmp_path)[1] == []


def test_compact_keeps_the_newest_and_the_one_before(tmp_path: Path) -> None:
    path = with_entries(tmp_path, *(entry(key=f"k{n}") for n in range(40)), entry("gone/study"))
    ledger, _ = read(tmp_path)
    ledger.drop("gone/study")
    ledger.compact()
    assert len(path.read_bytes().splitlines()) == 3 + 2
    again, warnings = read(tmp_path)
    assert again.keys("fits/P1/S1") == ["k39", "k38"]
    assert list(again.steps()) == ["fits/P1/S1"]
    assert warnings == []
    again.record(entry(key="k40"))
    assert read(tmp_path)[0].keys("fits/P1/S1") == ["k40", "k39"]


def test_differences_name_the_leaf() -> None:
    new = PARTS._replace(
        settings=part_of({"fit": {"bin_n": 0.2, "robust": True}}),
        files={"a.bdf": "missing", "b.tsv": "1"},
        inputs={"trials/P1/S2": "k"},
        code=part_of({"emg2vsa.fits": "d"}),
        libraries=part_of({"numpy": "3"}),
    )
    assert differences(PARTS, new, unknown=["trials/P1/S2"]) == [
        "setting fit.bin_n: 0.3 -> 0.2",
        "setting fit.robust: unset -> true",
        "missing file a.bdf",
        "new file b.tsv",
        "removed input trials/P1/S1",
        "changed code emg2vsa.fits",
        "library numpy 2 -> 3",
    ]
    assert differences(PARTS, PARTS) == []


@pytest.mark.parametrize("name", ["files", "inputs"])
def test_another_order_is_told_where_nothing_else_changed(name: str) -> None:
    one = PARTS._replace(**{name: {"a": "1", "b": "2"}})
    other = PARTS._replace(**{name: {"b": "2", "a": "1"}})
    assert differences(one, other) == [f"the order of its {name} changed"]
    assert differences(one, one) == []
    assert differences(one, other._replace(**{name: {"b": "2", "a": "3"}})) != [f"the order of its {name} changed"]
