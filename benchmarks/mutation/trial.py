"""One mutant against the suite: in a copy of the tree of its own, nearest test files first, until one test fails."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.mutation.mutants import Chosen
from benchmarks.mutation.time_limit import EXIT_CODE

FIRST_FILES = 4
RUN_S = 600.0
"""Wall time of one run of pytest: one that waits for a thread after its last test is seen by no test's clock."""
COMPILED = "casr/flow/"
"""Modules of the functions that numba compiles."""
_FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", re.MULTILINE)


@dataclass(frozen=True)
class Verdict:
    """What the suite said. state : killed, timed out or survived. by : the test that failed. tried : test files run."""

    state: str
    by: str
    tried: tuple[str, ...]


def tried(tree: Path, chosen: Chosen, files: Sequence[str], folder: Path, *, deselected: Sequence[str] = ()) -> Verdict:
    """Run the ranked test ``files`` against the mutant: the first ``FIRST_FILES`` alone, then the others.

    folder : for the copy; the next mutant's takes its place, and finds there what numba compiled of unchanged code.
    """
    copy = folder / "tree"
    export(tree, copy)
    module = copy / chosen.module
    module.write_text(chosen.mutant.applied(module.read_text(encoding="utf-8")), encoding="utf-8")
    # numba does not see that a function in another file has changed
    compiled = (copy if chosen.module.startswith(COMPILED) else folder) / "compiled"
    for part in (files[:FIRST_FILES], files[FIRST_FILES:]):
        if not part:
            continue
        code, out = run_tests(copy, part, compiled, deselected=deselected)
        if code == EXIT_CODE:
            return Verdict("timed out", "", tuple(part))
        if code not in (0, 5):  # 5: no test was chosen
            failed = _FAILED.search(out)
            return Verdict("killed", failed[1] if failed else f"pytest ended with {code}", tuple(part))
    return Verdict("survived", "", tuple(files))


def export(tree: Path, copy: Path) -> None:
    """What the last commit of ``tree`` holds, in place of whatever ``copy`` is."""
    shutil.rmtree(copy, ignore_errors=True)
    copy.mkdir()
    archive = subprocess.Popen(["git", "-C", str(tree), "archive", "HEAD"], stdout=subprocess.PIPE)
    subprocess.run(["tar", "x", "-C", str(copy)], stdin=archive.stdout, check=True)
    if archive.wait():
        raise OSError(f"{tree}: expected a git checkout, but found none. Run this from the project's own folder.")


def run_tests(
    copy: Path, tests: Sequence[str], compiled: Path, *, deselected: Sequence[str] = (), first_failure: bool = True
) -> tuple[int, str]:
    """pytest's exit code, or that of ``time_limit``, and its output. compiled : folder of numba's."""
    data = os.environ.get("EMG2VSA_TEST_DATA", str(Path.cwd().parent / "shared" / "data"))
    environment = os.environ | {"PYTHONPATH": str(copy), "EMG2VSA_TEST_DATA": data, "OPENBLAS_NUM_THREADS": "1"}
    environment["NUMBA_CACHE_DIR"] = str(compiled)
    skipped = [word for name in deselected for word in ("--deselect", name)]
    stop = ["-x"] if first_failure else []
    command = [
        sys.executable,
        "-m",
        "pytest",
        *stop,
        *skipped,
        "-p",
        "no:cacheprovider",
        "-p",
        "benchmarks.mutation.time_limit",
    ]
    command += ["--tb=no", "-rfE", "--hypothesis-seed=0", "-m", "not slow and not realtime", *tests]
    run = subprocess.Popen(
        command, cwd=copy, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        out, _ = run.communicate(timeout=RUN_S)
    except subprocess.TimeoutExpired:
        if sys.platform != "win32":  # time_limit has refused it already
            os.killpg(run.pid, signal.SIGKILL)  # with its child processes, which may hold its output open
        out, _ = run.communicate()
        return (1 if _FAILED.search(out) else EXIT_CODE), out
    return run.returncode, out


def failed_tests(out: str) -> list[str]:
    """Names of the tests that failed, from pytest's short summary."""
    return _FAILED.findall(out)
