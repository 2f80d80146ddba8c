"""A study on ten workers of Dask over loopback: two are killed, then the scheduler, which is started anew.

What is left must be, byte for byte, what one process makes alone. Linux.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.scale.people import ROOT, environment, run
from benchmarks.small_study import WITH_A_RIG, small_rig, small_study
from emg2vsa.study_file import load_study

KILLED = 2
AFTER_WORKERS_S, AFTER_SCHEDULER_S = 4.0, 8.0
"""After the first step is under way, so many seconds pass to each kill."""
PEOPLE = tuple(f"P{number:02d}" for number in range(1, 9))


def measured(folder: Path, count: int) -> dict[str, Any]:
    """How many files are equal in the end, how many the first try left, and what each try ended with."""
    study = folder / "studies" / "small" / "study.toml"
    study.parent.mkdir(parents=True)
    study.write_text(small_study(participants=PEOPLE, tables=WITH_A_RIG))
    study.with_name("rig.toml").write_text(small_rig("high-stiffness = [0]\nmodular = [0]\n"))
    run("tools simulate", study)
    run("run", study, "--jobs", "1")
    before = outcome(study)
    for part in _parts(study):
        shutil.rmtree(part)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with _cluster(port, count) as (scheduler, workers):
        first = _begun(study, port)
        _wait_for_a_step(study)
        time.sleep(AFTER_WORKERS_S)
        for worker in workers[:KILLED]:
            worker.kill()
        time.sleep(AFTER_SCHEDULER_S - AFTER_WORKERS_S)
        scheduler.kill()
        _, told = first.communicate()
        kept = len(outcome(study))
    with _cluster(port, count):
        second = _begun(study, port)
        second.communicate()
    after = outcome(study)
    return {
        "workers": count, "killed": KILLED, "first_exit": first.returncode, "files_kept": kept,
        "second_exit": second.returncode, "files": len(before),
        "equal": sum(after.get(name) == data for name, data in before.items()), "more": len(set(after) - set(before)),
        "said": told.strip().splitlines()[-1] if told.strip() else "",
    }  # fmt: skip


def outcome(study: Path) -> dict[str, bytes]:
    """Every stored result and every written file."""
    files = (path for part in _parts(study) for path in part.rglob("*") if path.is_file())
    kept = (path for path in files if not path.name.startswith(".") and _is_result(path))
    return {path.relative_to(study.parents[2]).as_posix(): path.read_bytes() for path in kept}


def _is_result(path: Path) -> bool:
    """Not ledgers, memories of files and what is under way: these tell of times and processes."""
    return ".emg2vsa" not in path.parts or "store" in path.parts


def _parts(study: Path) -> list[Path]:
    loaded = load_study(study)
    return [one for one in (study.parent / ".emg2vsa", loaded.reports, study.parent / "runs-virtual") if one.exists()]


def _begun(study: Path, port: int) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "emg2vsa.cli", "run", str(study), "--scheduler", f"tcp://127.0.0.1:{port}"]
    return subprocess.Popen(
        [*command, "--json"], cwd=ROOT, env=environment(), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def _wait_for_a_step(study: Path) -> None:
    ended_s = time.monotonic() + 600
    while not list((study.parent / ".emg2vsa").glob("*/under-way/*.json")):
        if time.monotonic() > ended_s:
            raise RuntimeError("no step began within 600 s")
        time.sleep(0.1)


@contextlib.contextmanager
def _cluster(port: int, count: int) -> Iterator[tuple[subprocess.Popen[bytes], list[subprocess.Popen[bytes]]]]:
    address = f"tcp://127.0.0.1:{port}"
    started = [_dask("scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")]
    time.sleep(3)
    started += [
        _dask("worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny", "--death-timeout", "60")
        for _ in range(count)
    ]
    try:
        yield started[0], started[1:]
    finally:
        for process in started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _dask(*arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments], env=environment() | {"PYTHONPATH": str(ROOT)}, cwd=ROOT,
        start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
