"""The child process of foreign decoders: crashes, loops without end, floods of memory, and how it ends itself."""

from __future__ import annotations

import importlib
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from casr import decoder_process
from casr.decoder_process import DecoderFailed, InChild, Limits, child_pid, end_child
from casr.errors import FramesError

DECODER = """
import ctypes, fcntl, os, sys, time
import numpy as np
from casr.errors import FramesError

def is_pipe_to_parent(fd):
    try:
        pipe = os.readlink(f"/proc/self/fd/{fd}").startswith("pipe")
        return pipe and fcntl.fcntl(fd, fcntl.F_GETFL) & os.O_ACCMODE == os.O_WRONLY
    except OSError:
        return False

class Decoder:
    made = 0

    def __init__(self, size=1000):
        Decoder.made += 1
        self.size = size

    def arrays(self):
        return [np.arange(self.size, dtype=np.float64), np.arange(6, dtype=np.uint8).reshape(2, 3)[:, ::2]]

    def times_made(self):
        return Decoder.made

    def crash(self):
        ctypes.string_at(0)

    def hang(self):
        ctypes.PyDLL(None).sleep(100)  # with the interpreter lock held, as a C++ loop would

    def flood(self):
        return np.ones(10**9)

    def nap(self):
        time.sleep(0.5)
        return "rested"

    def spoil(self):
        os.write(max(fd for fd in range(3, 20) if is_pipe_to_parent(fd)), bytes(range(100, 160)))
        return "unheard"

    def talk(self):
        os.write(1, b"decoder says hello" * 1000)
        sys.stdin.read()
        return "heard"

    def refuse(self):
        raise FramesError("press.avi", wanted="a", found="b", do="c")

    def refuse_oddly(self):
        class Odd(Exception):
            pass
        raise Odd("odd")

def in_a_worker():
    from casr.decoder_process import Limits
    from casr.decoder_process import InChild, child_pid
    return InChild("libodd", "misbehaving", "Decoder", (9,), Limits()).ask("size"), child_pid()
"""


@pytest.fixture
def make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    """Makes a misbehaving decoder in the child."""
    (tmp_path / "misbehaving.py").write_text(DECODER)
    monkeypatch.syspath_prepend(tmp_path)
    end_child()  # a child finds what could be found when it started

    def made(*arguments: object, seconds: float = 20.0, memory_mb: float = 600.0) -> InChild:
        return InChild("libodd", "misbehaving", "Decoder", arguments, Limits(seconds, memory_mb))

    yield made
    end_child()


def test_arrays_come_back_whole_writable_and_from_one_child(make) -> None:
    for size in (0, 1, 1000, 9_000_000, 10):
        first, second = make(size).ask("arrays")
        np.testing.assert_array_equal(first, np.arange(size, dtype=np.float64))
        np.testing.assert_array_equal(second, [[0, 2], [3, 5]])
        first += 1
        pid = child_pid()
    again = make(3)
    before = again.ask("arrays")[0]
    again.ask("arrays")[0][:] = 7
    assert before.tolist() == [0, 1, 2]
    assert again.ask("size") == 3
    assert child_pid() == pid
    assert again.ask("times_made") == 6


@pytest.mark.parametrize(
    ("fault", "reason", "limit"),
    [
        ("crash", r"^its reader crashed \(libodd, segmentation fault\)$", None),
        ("hang", r"^its reader took more than 1 s$", "seconds"),
        ("spoil", r"^its reader crashed \(libodd, no valid answer\)$", None),
        ("flood", r"^its reader needed more than 300 MB$", "memory"),
    ],
)
def test_a_fault_is_told_and_the_next_request_has_a_new_child(make, fault: str, reason: str, limit: str | None) -> None:
    kept = make(5)
    bad = make(seconds=1.0 if limit == "seconds" else 60.0, memory_mb=300)
    pid = child_pid()
    with pytest.raises(DecoderFailed, match=reason) as caught:
        bad.ask(fault)
    assert caught.value.limit == limit
    assert child_pid() is None
    assert kept.ask("arrays")[0].size == 5  # opened anew
    assert child_pid() not in (None, pid)


@pytest.mark.skipif(sys.platform != "linux", reason="the memory of another process is read from /proc")
def test_the_child_keeps_nothing_of_an_answer_that_was_sent(make) -> None:
    def resident_mb() -> float:
        found = re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{child_pid()}/status").read_text())
        assert found
        return int(found.group(1)) / 1000

    decoder = make(5_000_000)
    before = resident_mb()
    assert decoder.ask("arrays")[0].nbytes == 40_000_000
    deadline = time.monotonic() + 10
    while resident_mb() > before + 20 and time.monotonic() < deadline:
        time.sleep(0.01)
    assert resident_mb() < before + 20


def test_an_answer_may_be_no_larger_than_half_the_memory(make) -> None:
    assert make(10_000_000, memory_mb=400).ask("arrays")[0].nbytes == 80_000_000
    with pytest.raises(DecoderFailed, match="needed more than 300 MB"):
        make(20_000_000, memory_mb=300).ask("arrays")


def test_a_child_that_was_killed_meanwhile_is_no_fault_of_the_next_file(make) -> None:
    opened = make(5)
    os.kill(child_pid(), signal.SIGKILL)
    while child_pid() is not None:
        time.sleep(0.01)
    assert opened.ask("arrays")[0].size == 5


def test_what_a_decoder_raises_prints_or_reads_is_its_own(make) -> None:
    decoder = make()
    with pytest.raises(FramesError, match=r"press.avi: expected a, but found b. c"):
        decoder.ask("refuse")
    with pytest.raises(RuntimeError, match="Odd: odd"):
        decoder.ask("refuse_oddly")
    assert decoder.ask("talk") == "heard"
    assert decoder.ask("times_made") == 1


def test_a_decoder_that_is_not_installed_raises_as_it_would_here() -> None:
    with pytest.raises(ModuleNotFoundError, match="no_such_decoder"):
        InChild("lib", "no_such_decoder", "open", (), Limits())


def test_larger_files_have_wider_limits(tmp_path: Path) -> None:
    with (tmp_path / "big").open("wb") as file:
        file.truncate(50_000_000)
    assert Limits(10, 600).for_file(tmp_path / "big") == Limits(15, 1100)
    assert Limits(10, 600).for_file(tmp_path / "absent") == Limits(10, 600)


@pytest.mark.parametrize("method", ["forkserver", "fork"])
def test_every_worker_of_a_pool_has_its_own_child(make, method: str) -> None:
    opened = make(5)
    task = importlib.import_module("misbehaving").in_a_worker
    with ProcessPoolExecutor(1, mp_context=get_context(method)) as pool:
        size, pid = pool.submit(task).result(timeout=60)
        assert size == 9
        assert pid != child_pid()
        assert opened.ask("arrays")[0].size == 5
    assert _ends(pid)


HANGING = """
import signal, sys
sys.path.insert(0, sys.argv[1])
from casr.decoder_process import Limits
from casr.decoder_process import InChild, child_pid
decoder = InChild("libodd", "misbehaving", "Decoder", (), Limits(60))
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background has it ignored
print(child_pid(), flush=True)
decoder.ask("hang")
"""


def _hanging_parent(folder: Path) -> tuple[subprocess.Popen[str], int]:
    parent = subprocess.Popen(
        [sys.executable, "-c", HANGING, str(folder)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    pid = int(parent.stdout.readline())
    time.sleep(0.5)
    return parent, pid


def _ends(pid: int | None, seconds: float = 60.0) -> bool:
    assert pid is not None
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        state = Path(f"/proc/{pid}/stat")
        if state.exists() and state.read_text().rpartition(")")[2].split()[0] == "Z":
            return True  # ended, and waits for its new parent to notice
        time.sleep(0.02)
    return False


def test_interrupted_parent_ends_at_once_with_its_child(make, tmp_path: Path) -> None:
    parent, pid = _hanging_parent(tmp_path)
    start = time.monotonic()
    parent.send_signal(signal.SIGINT)
    _, said = parent.communicate(timeout=50)
    assert time.monotonic() - start < 30  # the request may take 60
    assert said.count("KeyboardInterrupt") == 1  # of the parent alone
    assert _ends(pid)


def test_a_request_that_is_signalled_late_does_not_end_the_child(make, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = make()
    child = decoder_process._current
    written = child.pipes.to_other.write

    def write_and_signal_again(message: bytes) -> int:
        size = written(message)
        threading.Timer(0.2, lambda: written(b"\0")).start()  # its signal comes while the child works
        return size

    with monkeypatch.context() as patched:
        patched.setattr(child.pipes, "to_other", SimpleNamespace(write=write_and_signal_again))
        assert opened.ask("nap") == "rested"
    end_child()


def test_no_child_before_it_is_needed() -> None:
    code = "import casr.decoder_process as d, casr.frame_files; print(d.child_pid())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "None\n"
