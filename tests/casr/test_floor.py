"""What both packages stand on: files written whole, a quick median, one thread."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from casr.atomic import write_bytes_atomic, write_text_atomic
from casr.median import median
from casr.one_thread import VARIABLES


def test_replaces_and_leaves_nothing_beside(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b.txt"
    write_text_atomic(path, "old\n")
    write_text_atomic(path, "new µ\n")
    assert path.read_bytes() == "new µ\n".encode()
    assert [p.name for p in path.parent.iterdir()] == ["b.txt"]


def test_a_failed_write_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "b.txt"
    write_text_atomic(path, "old")

    def refuse(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        write_bytes_atomic(path, b"new")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["b.txt"]


def test_a_full_disk_names_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "chmod", refuse)
    with pytest.raises(OSError, match="No space left on device") as told:
        write_text_atomic(tmp_path / "b.txt", "new")
    assert told.value.filename == str(tmp_path / "b.txt")
    assert list(tmp_path.iterdir()) == []


def test_what_is_on_the_disk_gets_its_name_after_its_content_and_the_folder_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []
    replace = os.replace

    def sync(handle: int) -> None:
        path = Path(os.readlink(f"/proc/self/fd/{handle}"))
        order.append(path.name if path.is_dir() else path.read_text())

    def rename(path: str, to: Path) -> None:
        replace(path, to)
        order.append(to.name)

    if not Path("/proc/self/fd").exists():
        pytest.skip("names of open files are asked of /proc")
    monkeypatch.setattr(os, "fsync", sync)
    monkeypatch.setattr(os, "replace", rename)
    write_bytes_atomic(tmp_path / "plan.json", b"the plan")
    assert order == ["plan.json"]
    write_bytes_atomic(tmp_path / "plan.json", b"the plan", on_disk=True)
    assert order == ["plan.json", "the plan", "plan.json", tmp_path.name]


@pytest.mark.parametrize("shape", [(1,), (2,), (7,), (36,), (5, 2), (6, 3)])
@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_it_is_that_of_numpy(shape: tuple[int, ...], kind: type) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        values = np.round(rng.normal(size=shape) * 10.0 ** rng.integers(-3, 3), 2).astype(kind)
        for axis in range(len(shape)):
            np.testing.assert_array_equal(median(values, axis=axis), np.median(values, axis=axis))


TOLD = (
    "import os, sys; from {0}.cli import main; main(['completion', 'bash']); print(*(os.environ[name] for name in {1}))"
)


@pytest.mark.parametrize("program", ["casr", "emg2vsa"])
@pytest.mark.parametrize("asked", [{}, {"OPENBLAS_NUM_THREADS": "3"}])
def test_a_command_asks_for_one_thread(program: str, asked: dict[str, str]) -> None:
    without = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    told = subprocess.run(
        [sys.executable, "-c", TOLD.format(program, VARIABLES)],
        env=without | asked,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    assert told.splitlines()[-1].split() == [asked.get(name, "1") for name in VARIABLES]
