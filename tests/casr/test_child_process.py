"""A child process: what it says, how it dies, and that it never outlives the process that started it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from casr.child_process import Child

FAR_END = """
import ctypes, os, sys, time

def echo(pipes, *numbers):
    print("hello from the child")
    while True:
        message = pipes.receive().tobytes()
        pipes.send(message + repr(numbers).encode())

def about(pipes):
    import signal
    threads = os.environ["OPENBLAS_NUM_THREADS"]
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    pipes.send(repr((threads, ignored, os.getpgrp() == os.getpid(), os.nice(0), os.sched_getscheduler(0))).encode())

def half(pipes):
    os.write(pipes.to_other.fileno(), (1000).to_bytes(8, "little") + b"half of an ans")
    os.kill(os.getpid(), 9)

def leave(pipes):
    sys.exit(3)

def fault(pipes):
    ctypes.string_at(0)

def hang(pipes):
    pipes.send(b"hanging")
    ctypes.PyDLL(None).sleep(100)  # with the interpreter lock held, as a C++ loop would
"""


@pytest.fixture
def start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Child]]:
    (tmp_path / "far_end.py").write_text(FAR_END)
    monkeypatch.syspath_prepend(tmp_path)
    started: list[Child] = []

    def begun(function: str, *arguments: int, **how: int) -> Child:
        started.append(Child("far_end", function, *arguments, quiet=True, **how))
        return started[-1]

    yield begun
    for child in started:
        child.end()


def test_messages_come_back_whole_and_what_it_prints_is_none(start) -> None:
    child = start("echo", 7, 8)
    for message in (b"", b"word", b"x" * 300_000):
        child.pipes.send(message)
        assert child.pipes.readable(20.0)
        assert child.pipes.receive().tobytes() == message + b"(7, 8)"
    assert not child.pipes.readable()
    assert child.alive
    assert child.close(5.0) == 0
    assert not child.alive


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux")
def test_one_thread_an_ordinary_priority_and_no_ctrl_c(start) -> None:
    child = start("about", nice=5)
    told = eval(child.pipes.receive().tobytes())
    assert told == ("1", True, True, os.nice(0) + 5, os.SCHED_OTHER)


@pytest.mark.parametrize(
    ("function", "died_of"),
    [("half", ("killed", True)), ("leave", ("exit code 3", False)), ("fault", ("segmentation fault", False))],
)
def test_a_child_that_dies_while_it_answers_is_noticed_and_says_of_what(start, function, died_of) -> None:
    child = start(function)
    assert child.pipes.readable(20.0)
    with pytest.raises(EOFError):
        child.pipes.receive()
    assert child.died_of() == died_of
    assert not child.alive


def test_a_child_that_was_killed_is_noticed(start) -> None:
    child = start("echo")
    child.pipes.send(b"one")
    child.pipes.receive()
    os.kill(child.pid, signal.SIGKILL)
    assert child.wait(60) == -signal.SIGKILL
    assert child.pipes.readable()
    assert not child.alive


def test_a_child_that_hangs_is_ended(start) -> None:
    child = start("hang")
    assert child.pipes.receive().tobytes() == b"hanging"
    assert not child.pipes.readable(0.1)
    assert child.close(0.2) is None
    with pytest.raises(ProcessLookupError):
        os.kill(child.pid, 0)
    child.end()


def test_a_full_pipe_that_is_not_waited_for_takes_a_message_whole_or_not_at_all(start) -> None:
    child = start("hang")
    assert child.pipes.receive().tobytes() == b"hanging"
    os.set_blocking(child.pipes.to_other.fileno(), False)

    def fill() -> None:
        for _ in range(100_000):
            child.pipes.send(b"x" * 32)

    with pytest.raises(BlockingIOError):
        fill()


PARENT = """
import sys
from casr.child_process import Child
child = Child("far_end", sys.argv[1], quiet=True)
if sys.argv[1] == "echo":
    child.pipes.send(b"one")
child.pipes.receive()
print(child.pid, flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize("function", ["echo", "hang"])
@pytest.mark.parametrize("how", ["killed", "ends"])
def test_it_ends_with_its_parent(start, tmp_path: Path, function: str, how: str) -> None:
    if function == "hang" and sys.platform != "linux" and how == "killed":
        pytest.skip("elsewhere it ends with its next message")
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, function], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    pid = int(parent.stdout.readline())
    if how == "killed":
        parent.kill()
    parent.communicate(timeout=60)
    end_s = time.monotonic() + 60
    while _runs(pid) and time.monotonic() < end_s:
        time.sleep(0.02)
    assert not _runs(pid)


def _runs(pid: int) -> bool:
    """Whether it has not ended; one that waits for its new parent to notice has."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    stat = Path(f"/proc/{pid}/stat")
    return not (stat.exists() and stat.read_text().rpartition(")")[2].split()[0] == "Z")


def test_a_fork_has_no_child_of_its_parent(start) -> None:
    child = start("echo")
    pid = os.fork()
    if pid == 0:
        os._exit(int(child.alive))
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    child.pipes.send(b"still mine")
    assert child.pipes.receive().tobytes() == b"still mine()"
