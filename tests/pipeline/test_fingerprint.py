"""Code digests follow imports and ignore prose; file digests follow content."""

from __future__ import annotations

from pathlib import Path

import pytest

from emg2vsa.pipeline import fingerprint
from emg2vsa.pipeline.fingerprint import Fingerprints, as_json, digest


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small package: stage -> helper -> deep; other stands alone."""
    folder = tmp_path / "emg2vsa"
    (folder / "signals").mkdir(parents=True)
    (folder / "stage.py").write_text('"""Doc."""\nfrom emg2vsa.signals import helper\n\nX = helper.f(1)\n')
    (folder / "signals" / "__init__.py").write_text("")
    (folder / "signals" / "helper.py").write_text(
        "from ..deep import K\n\n\ndef f(x):\n    'Doc.'\n    return x * K  # why\n"
    )
    (folder / "deep.py").write_text("K = 2\n")
    (folder / "other.py").write_text("Y = 1\n")
    monkeypatch.setattr(fingerprint, "_package_folder", lambda package: folder)
    return folder


def code(tmp_path: Path) -> dict[str, str]:
    prints = Fingerprints(tmp_path / "memory.json")
    reached = prints.code(["emg2vsa.stage"])
    prints.save()
    return reached


def test_reaches_helpers_of_helpers(package: Path, tmp_path: Path) -> None:
    assert set(code(tmp_path)) == {"emg2vsa.stage", "emg2vsa.signals", "emg2vsa.signals.helper", "emg2vsa.deep"}


@pytest.mark.parametrize(
    ("file", "old", "new", "changed"),
    [
        ("deep.py", "K = 2", "K = 3", {"emg2vsa.deep"}),
        ("signals/helper.py", "# why", "# because", set()),
        ("signals/helper.py", "'Doc.'", "'Another text.'", set()),
        ("stage.py", '"""Doc."""', '"""Changed."""', set()),
        ("stage.py", "f(1)", "f(2)", {"emg2vsa.stage"}),
        ("other.py", "Y = 1", "Y = 2", set()),
    ],
)
def test_what_counts_as_a_change(
    package: Path, tmp_path: Path, file: str, old: str, new: str, changed: set[str]
) -> None:
    before = code(tmp_path)
    path = package / file
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new) + "\n")
    after = code(tmp_path)
    assert {name for name in after if after[name] != before.get(name)} == changed


def test_file_digest_follows_content_and_is_remembered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "rec.csv"
    prints = Fingerprints(tmp_path / "memory.json")
    assert prints.file(path) == "missing"
    path.write_text("1")
    first = prints.file(path)
    prints.save()
    monkeypatch.setattr(Path, "read_bytes", lambda self: pytest.fail(f"read {self} again"))
    assert Fingerprints(tmp_path / "memory.json").file(path) == first
    monkeypatch.undo()
    path.write_text("22")
    assert Fingerprints(tmp_path / "memory.json").file(path) == digest("22") != first


def test_a_damaged_memory_is_forgotten(tmp_path: Path) -> None:
    (tmp_path / "memory.json").write_text('{"half')
    (tmp_path / "x").write_text("1")
    assert Fingerprints(tmp_path / "memory.json").file(tmp_path / "x") == digest("1")


def test_digest_keeps_borders() -> None:
    assert digest("ab", "c") != digest("a", "bc")


def test_as_json_sorts_and_flattens() -> None:
    assert as_json({"b": (1, Path("x/y")), "a": None}) == {"a": None, "b": [1, "x/y"]}
