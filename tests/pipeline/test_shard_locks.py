"""Shards share the results of a study with each other and with nothing else; what dead ones left is told or taken."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from emg2vsa.errors import DataError
from emg2vsa.held_lock import myself, taken
from emg2vsa.pipeline import presence as presences
from emg2vsa.pipeline.lock import WHOLE_FILE, holder, shard_lock, study_lock
from emg2vsa.pipeline.presence import presence, present
from emg2vsa.pipeline.shard import Shard

HOLD = """
import sys, time
from pathlib import Path
from emg2vsa.pipeline.lock import shard_lock, study_lock
from emg2vsa.pipeline.shard import Shard
folder, number, of = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
lock = shard_lock(folder, Shard(number, of), wait=True, say=print) if of else study_lock(folder, wait=True, say=print)
with lock:
    print("held", flush=True)
    time.sleep(60)
"""


def held_by_another(folder: Path, shard: Shard | None) -> subprocess.Popen[str]:
    """Another process that is this shard, or a whole run."""
    numbers = (0, 0) if shard is None else (shard.number, shard.of)
    command = [sys.executable, "-c", HOLD, str(folder), *map(str, numbers)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


@pytest.fixture
def second(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """Another process that is shard 2 of 4 in ``tmp_path``."""
    with held_by_another(tmp_path, Shard(2, 4)) as process:
        yield process
        process.kill()


def refused(folder: Path, shard: Shard | None) -> str:
    """What is said when the lock is refused."""
    lock = study_lock(folder, wait=False, say=pytest.fail)
    if shard is not None:
        lock = shard_lock(folder, shard, wait=False, say=pytest.fail)
    with pytest.raises(DataError) as error, lock:
        pass
    return str(error.value)


def left_elsewhere(path: Path) -> None:
    """A presence of a process on another computer."""
    path.write_text(json.dumps(myself() | {"host": "node7", "pid": 4711}))


def test_shards_of_one_number_share_and_all_else_is_refused_by_name(
    tmp_path: Path, second: subprocess.Popen[str]
) -> None:
    named = f"process {second.pid} on "
    with shard_lock(tmp_path, Shard(1, 4), wait=False, say=pytest.fail):
        assert (tmp_path / ".lock.shard-1-of-4").exists()
    assert not (tmp_path / ".lock.shard-1-of-4").exists()
    assert f"expected no other process with shard 2 of 4, but found {named}" in refused(tmp_path, Shard(2, 4))
    assert f"expected shards of 3 only, but found shard 2 of 4, {named}" in refused(tmp_path, Shard(1, 3))
    assert f"results in use by shard 2 of 4, {named}" in refused(tmp_path, None)
    assert holder(tmp_path).startswith(f"shard 2 of 4, {named}")
    second.send_signal(signal.SIGKILL)
    second.wait()
    assert holder(tmp_path) == ""
    with shard_lock(tmp_path, Shard(2, 4), wait=False, say=pytest.fail):
        pass
    with study_lock(tmp_path, wait=False, say=pytest.fail):
        assert holder(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".lock"]


def test_a_shard_waits_for_a_whole_run(tmp_path: Path) -> None:
    said: list[str] = []
    with held_by_another(tmp_path, None) as whole:
        assert f"results in use by process {whole.pid} on " in refused(tmp_path, Shard(1, 2))

        def say(text: str) -> None:
            said.append(text)
            whole.kill()

        with shard_lock(tmp_path, Shard(1, 2), wait=True, say=say):
            pass
    assert said[0].startswith(f"Waiting: another run holds {tmp_path}: process {whole.pid} on ")


def test_what_a_dead_process_elsewhere_left_is_told_with_the_way_out(tmp_path: Path) -> None:
    left = tmp_path / ".lock.shard-2-of-4"
    left_elsewhere(left)
    os.utime(left, (left.stat().st_atime, left.stat().st_mtime - 3 * 3600))
    for shard in (Shard(2, 4), None):
        told = refused(tmp_path, shard)
        assert "process 4711 on node7, since " in told
        assert f", 3 h ago (if it has ended, remove {left})" in told
    left.unlink()
    left_elsewhere(tmp_path / WHOLE_FILE)
    assert "process 4711 on node7" in refused(tmp_path, Shard(2, 4))
    with study_lock(tmp_path, wait=False, say=pytest.fail):  # its own lock tells a whole run that the other has ended
        assert f"process {os.getpid()} " in holder(tmp_path)
    assert not (tmp_path / WHOLE_FILE).exists()


@pytest.mark.parametrize("content", ["", "[]", '{"pid": 1}', "\xff"])
def test_a_presence_that_says_nothing_counts_as_somebodys(tmp_path: Path, content: str) -> None:
    path = tmp_path / ".lock.shard-1-of-2"
    path.write_text(content)
    assert present(path).startswith("another process, 0 min ago (if it has ended, remove ")
    assert "another process" in refused(tmp_path, Shard(1, 2))


def test_a_look_at_a_presence_that_was_left_keeps_nobody_out(tmp_path: Path) -> None:
    path = tmp_path / ".lock.shard-1-of-2"
    path.write_text(json.dumps(myself()))
    with path.open("r+b") as looking:
        assert taken(looking.fileno())
        threading.Timer(0.05, looking.close).start()
        with presence(path):
            assert path.exists()


def test_a_folder_in_the_place_of_a_lock_is_to_be_removed(tmp_path: Path) -> None:
    for name in (".lock.shard-1-of-2", ".lock.whole", ".lock"):
        (tmp_path / name).mkdir()
        shard = None if name == ".lock" else Shard(1, 2)
        told = refused(tmp_path, shard)
        assert f"{tmp_path / name}: expected a file, which says who works here, but found a folder. Remove it." == told
        (tmp_path / name).rmdir()


def test_of_two_that_take_over_one_gets_it(tmp_path: Path) -> None:
    path = tmp_path / "presence"
    path.write_text(json.dumps(myself() | {"pid": 1}))
    with ExitStack() as stack:
        stack.enter_context(presence(path))
        with pytest.raises(presences.Present, match=f"process {os.getpid()} on"), presence(path):
            pass
        assert path.exists()
    assert list(tmp_path.iterdir()) == []


def test_a_file_system_without_hard_links_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def link(source: Path, target: Path) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "link", link)
    assert "a file system with hard links, but found Operation not supported" in refused(tmp_path, Shard(1, 2))
    assert list(tmp_path.iterdir()) == []
