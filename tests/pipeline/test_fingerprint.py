"""Digests of files follow their content and are remembered; settings become plain values in a fixed order."""

from __future__ import annotations

import json
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from emg2vsa.pipeline import fingerprint
from emg2vsa.pipeline.fingerprint import Fingerprints, Part, Values, digest
from emg2vsa.pipeline.stage import Keyed


@pytest.fixture
def memory(tmp_path: Path) -> Path:
    return tmp_path / "memory.json"


@pytest.fixture
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """A file is remembered 0.1 s after its last change, and not only 1 s after it."""
    monkeypatch.setattr(fingerprint, "_SETTLED_NS", 100_000_000)


def written(path: Path, text: str) -> Path:
    """A file that was changed long enough ago to be remembered."""
    path.write_text(text)
    time.sleep(fingerprint._SETTLED_NS / 1e9 + 0.02)
    return path


def remembered(memory: Path, path: Path) -> str:
    """The digest by a program that starts, looks and ends."""
    prints = Fingerprints(memory, lambda text: pytest.fail(text))
    found = prints.file(path)
    prints.save()
    return found


@pytest.mark.usefixtures("soon")
def test_content_is_followed_and_read_once(memory: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert remembered(memory, tmp_path / "a") == "missing"
    path = written(tmp_path / "a", "1")
    assert remembered(memory, path) == digest("1")
    plain = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda self: plain(self) if self == memory else pytest.fail(f"read {self}"))
    assert remembered(memory, path) == digest("1")
    monkeypatch.undo()
    assert remembered(memory, written(path, "22")) == digest("22")
    path.unlink()
    assert remembered(memory, path) == "missing"


@pytest.mark.usefixtures("soon")
def test_a_change_in_place_with_its_time_put_back_is_noticed(memory: Path, tmp_path: Path) -> None:
    path = written(tmp_path / "a", "1")
    before = path.stat()
    remembered(memory, path)
    path.write_text("2")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    after = path.stat()
    assert (after.st_mtime_ns, after.st_size, after.st_ino) == (before.st_mtime_ns, before.st_size, before.st_ino)
    assert remembered(memory, path) == digest("2")


def test_changes_faster_than_the_clock_of_the_file_system_are_noticed(memory: Path, tmp_path: Path) -> None:
    prints, path = Fingerprints(memory), tmp_path / "a"
    for text in "12345678":
        path.write_text(text)
        assert prints.file(path) == digest(text)


@pytest.mark.usefixtures("soon")
def test_forgetting_reads_again(memory: Path, tmp_path: Path) -> None:
    path = written(tmp_path / "a", "1")
    prints = Fingerprints(memory)
    prints.file(path)
    prints._known[str(path)][1] = "of a disk that lies"
    assert prints.file(path) == "of a disk that lies"
    prints.forget(path)
    assert prints.file(path) == digest("1")


@pytest.mark.usefixtures("soon")
@pytest.mark.parametrize(
    "content",
    [b"", b'{"half', b"[1]", b"\xff\xfe", b"5", b'{"seen": 5}', b'{"sum": "0", "seen": {"a": [[], 1]}}', b"[" * 9**5],
)  # fmt: skip
def test_a_damaged_memory_is_one_warning_and_made_anew(memory: Path, tmp_path: Path, content: bytes) -> None:
    memory.write_bytes(content)
    path = written(tmp_path / "a", "1")
    warnings: list[str] = []
    prints = Fingerprints(memory, warnings.append)
    assert len(warnings) == 1
    assert str(memory) in warnings[0]
    assert prints.file(path) == digest("1")
    prints.save()
    assert remembered(memory, path) == digest("1")


@pytest.mark.usefixtures("soon")
def test_one_changed_byte_of_the_memory_is_noticed(memory: Path, tmp_path: Path) -> None:
    remembered(memory, written(tmp_path / "a", "1"))
    whole = memory.read_bytes()
    for at in range(0, len(whole), 7):
        memory.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        warnings: list[str] = []
        assert Fingerprints(memory, warnings.append)._known == {}
        assert len(warnings) == 1


@pytest.mark.usefixtures("soon")
@pytest.mark.parametrize("later", [False, True])
def test_the_memory_of_older_versions_is_read_anew_without_a_word(memory: Path, tmp_path: Path, later: bool) -> None:
    path = written(tmp_path / "a", "1")
    files = {str(path): [[1, path.stat().st_mtime_ns], "other"]}
    memory.write_text(json.dumps({"sum": "0", "files": files} if later else files))
    assert remembered(memory, path) == digest("1")


def test_a_memory_that_cannot_be_written_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    path = tmp_path / "a"
    path.write_text("1")
    prints = Fingerprints(tmp_path / "memory.json")
    prints._memory = tmp_path / "file" / "memory.json"
    assert prints.file(path) == digest("1")
    prints.save()


def test_libraries_are_looked_up_again_when_a_folder_of_them_changes(
    memory: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path / "site-packages")
    (tmp_path / "site-packages").mkdir()
    prints = Fingerprints(memory)
    assert prints.installed(lambda: "1.0") == "1.0"
    assert prints.installed(lambda: pytest.fail("nothing was installed")) == "1.0"
    (tmp_path / "site-packages" / "new").mkdir()
    assert prints.installed(lambda: "1.1") == "1.1"


def test_digest_keeps_borders() -> None:
    assert digest("ab", "c") != digest("a", "bc")


@dataclass(frozen=True)
class Filters:
    low_hz: float
    folder: Path
    inner: Any = None


def test_settings_become_plain_values_in_a_fixed_order() -> None:
    filters = Filters(20.0, Path("/here"), Filters(5.0, Path("x")))
    found = Values().plain({"b": (1, None, Path("y")), "a": filters, "c": Keyed(object(), ["key"])})
    assert found == {"a": {"low_hz": 20.0, "inner": {"low_hz": 5.0, "inner": None}}, "b": [1, None], "c": ["key"]}
    assert list(Values().plain({"b": 1, "a": 2})) == ["a", "b"]


def test_where_something_lies_is_no_part_of_a_key() -> None:
    values = Values()
    parts = [values.part({"filters": Filters(20.0, Path(where)), "at": Path(where)})[0] for where in ("/a", "/b")]
    assert parts[0].digest == parts[1].digest
    assert values.part({"filters": Filters(21.0, Path("/a")), "at": None})[0].digest != parts[0].digest


@dataclass(frozen=True)
class Holding:
    inner: tuple[Any, ...]


def test_settings_tell_the_modules_of_their_types() -> None:
    """But not of what a setting holds beside its key."""
    part, values = Part("", {}), Values()
    assert values.part({"a": Holding(({"b": part},)), "c": Keyed(1, 1)})[1] == ("emg2vsa.pipeline.fingerprint",)
    assert values.part({"a": Keyed(part, None)})[1] == ("emg2vsa.pipeline.fingerprint",)
    assert values.part({"a": Keyed(Holding((part,)), None)})[1] == values.part({"a": Keyed(None, None)})[1] == ()


def test_a_shared_object_is_converted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    values, shared = Values(), Filters(20.0, Path("x"))
    first, _ = values.part({"filters": shared, "n": 1})
    assert values.part({"filters": shared, "n": 1})[0] is first
    monkeypatch.setattr("dataclasses.fields", lambda value: pytest.fail("converted again"))
    assert values.part({"filters": shared, "n": 2})[0].digest != first.digest
