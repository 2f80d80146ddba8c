"""One area measured in this process.

Peak memory of one call, in a process of its own.

On what a benchmark ran: processor, load, libraries. No host names and no paths.

One thread for everybody: processor time adds threads up, so a threaded way would look slower than it is.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import platform
import re
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

import emg2vsa
from benchmarks.bench.case import Area, Case, NotHere, Size, Way
from benchmarks.bench.results import AreaResult, CaseResult, Row, digits_of
from benchmarks.bench.timing import Timed, first_call, timed

CLEAR, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")
HOW = "Memory is the peak of resident pages during one call less those before it, in a forked process (Linux)."


def peak_mb(run: Callable[[], Any]) -> float | None:
    """Megabytes that one call adds at most to those the process holds; None where the system cannot say.

    The call runs in a fork, so inputs and libraries are loaded and not counted, and its writes are lost.
    """
    if sys.platform != "linux":
        return None
    read_end, write_end = os.pipe()
    pid = os.fork()
    if pid == 0:
        try:
            os.write(write_end, repr(_added_kb(run) / 1024).encode())
        finally:
            os._exit(0)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        text = answer.read()
    os.waitpid(pid, 0)
    return float(text) if text else None


def _added_kb(run: Callable[[], Any]) -> int:
    _give_back()
    CLEAR.write_text("5")  # the peak becomes what is held now
    before = _peak_kb()
    output = run()
    after = _peak_kb()
    del output
    return after - before


def _give_back() -> None:
    """Give memory that is held but free back to the system: taken again, it would not be seen."""
    with suppress(AttributeError, OSError):  # another library of C than GNU's
        ctypes.CDLL("libc.so.6").malloc_trim(0)


def _peak_kb() -> int:
    found = re.search(r"VmHWM:\s+(\d+) kB", STATUS.read_text())
    assert found
    return int(found.group(1))


def peak_so_far_mb() -> float:
    """Most memory this process ever held, MB; NaN on systems that do not say."""
    try:
        resource = importlib.import_module("resource")
    except ImportError:
        return float("nan")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # macOS counts bytes, Linux KiB
    return float(peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6)


ALWAYS = ("numpy", "scipy", "pandas", "opencv-contrib-python-headless", "numba")


def machine(peers: tuple[str, ...] = ()) -> dict[str, Any]:
    """processor, cores, load (1 min), system, python, emg2vsa, revision, libraries (name -> version)."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None,
        "system": platform.system(),
        "python": platform.python_version(),
        "emg2vsa": emg2vsa.__version__,
        "revision": revision(),
        "libraries": {name: version for name in sorted({*ALWAYS, *peers}) if (version := _version(name))},
    }


def rates() -> dict[str, float]:
    """What one thread of this machine moves and computes at best, in this very run: a copy of 256 MB, which no cache
    holds, and a product of matrices."""
    source, target, matrix = np.ones(2**25), np.empty(2**25), np.ones((768, 768))
    runs = [lambda: np.copyto(target, source), lambda: matrix @ matrix]
    copy_s, product_s = (min(first_call(run)[0] for _ in range(5)) for run in runs)
    return {"bytes_per_s": 2 * source.nbytes / copy_s, "flops_per_s": 2 * 768**3 / product_s}


def revision(folder: Path | None = None) -> str | None:
    """Short hash of the checkout, with ``+`` where the sources were changed; None without git."""
    where = folder or Path(__file__).resolve().parents[2]
    try:
        said = [
            subprocess.run(["git", "-C", str(where), *words], capture_output=True, text=True, check=True).stdout.strip()
            for words in (
                ("rev-parse", "--short=9", "HEAD"),
                ("status", "--porcelain", "-uno", "--", "emg2vsa", "casr", "benchmarks"),
            )
        ]
    except (OSError, subprocess.CalledProcessError):
        return None
    return said[0] + ("+" if said[1] else "")


def _processor() -> str:
    try:
        found = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text())
    except OSError:
        found = None
    return found.group(1).strip() if found else platform.processor() or platform.machine()


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


VARIABLES = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS", "POLARS_MAX_THREADS",
)  # fmt: skip


def one_thread_environment() -> dict[str, str]:
    """The environment of a child process whose libraries take one thread."""
    return os.environ | dict.fromkeys(VARIABLES, "1")


def pin_loaded() -> None:
    """One thread for the libraries that count threads of their own and are already loaded."""
    if "cv2" in sys.modules:
        sys.modules["cv2"].setNumThreads(1)
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(1)


Say = Callable[[str], None]


def measure(
    area: Area,
    size: Size,
    *,
    rounds: int,
    budget_s: float = 2.0,
    only: str = "",
    ours_alone: bool = False,
    memory: bool = False,
    older: bool = False,
    say: Say = lambda _: None,
) -> AreaResult:
    """Every case of the area: times, errors, digits, and with ``memory`` peaks.

    rounds : 0 measures errors alone. only : a word that the name of a case or of its library and way must hold.
    ours_alone : no other library runs.
    older : the product is of another revision; a part whose functions it lacks is in ``missing``, not an error. A way
    that raises is a row that says so.
    """
    missing: list[str] = []
    results = []
    for case in _cases(area, size, missing, older):
        chosen = _chosen(case, only, ours_alone)
        if chosen is None:
            continue
        say(f"{area.name}: {case.name}")
        results.append(_measured(chosen, rounds, budget_s, memory))
    return AreaResult(
        name=area.name,
        question=area.question,
        meaning=area.meaning,
        size=size.value,
        machine=machine(tuple(area.peers.values())) | ({"rates": rates()} if rounds else {}),
        absent=area.absent,
        missing=tuple(missing),
        cases=tuple(results),
    )


def _cases(area: Area, size: Size, missing: list[str], older: bool) -> Iterator[Case]:
    for part in area.parts:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                cases = list(part(size))
        except NotHere as error:
            missing.append(str(error))
            continue
        except (ImportError, AttributeError, TypeError) as error:
            if not older:
                raise
            missing.append(f"{part.__name__}, not in this revision: {error}")
            continue
        yield from cases


def _chosen(case: Case, only: str, ours_alone: bool) -> Case | None:
    """The case with the ways asked for, its first always; None where nothing was asked of it."""
    first, *others = case.ways
    if only and only.lower() not in case.name.lower():
        others = [way for way in others if only.lower() in f"{way.library} {way.name}".lower()]
        if not others:
            return None
    if ours_alone:
        others = [way for way in others if way.ours]
    return replace(case, ways=(first, *others))


def _measured(case: Case, rounds: int, budget_s: float, memory: bool) -> CaseResult:
    rows: dict[Way, Row] = {}
    first: dict[Way, tuple[float, Any]] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what peers warn of, their errors show
        for way in case.ways:
            try:
                first[way] = first_call(way.run)
            except Exception as error:  # peers break with versions of other libraries
                rows[way] = Row(way.library, way.name, way.work, way.note, way.ours, failed=_said(error))
        pin_loaded()
        times = timed(
            [way.run for way in first], [seconds for seconds, _ in first.values()], rounds=rounds, budget_s=budget_s
        )
        reference = times[0] if times and case.ways[0] in first else None
        for (way, (_, output)), time in zip(first.items(), times, strict=True):
            rows[way] = _row(case, way, time, output, None if time is reference else reference, memory)
    ordered = tuple(rows[way] for way in case.ways)
    return CaseResult(
        case.name, case.size, case.size_unit, case.error_unit, case.truth, case.family, ordered,
        case.bytes_moved, case.flops,
    )  # fmt: skip


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {next(iter(str(error).splitlines()), '')}"[:120]


def _row(case: Case, way: Way, time: Timed, output: Any, reference: Timed | None, memory: bool) -> Row:
    error = case.error_of(way, output)
    return Row(
        library=way.library,
        name=way.name,
        work=way.work,
        note=way.note,
        ours=way.ours,
        first_ms=1e3 * time.first_s,
        rounds=time.known_s.size,
        **(_times(time, reference) if time.known_s.size else {}),
        error=error,
        digits=digits_of(error) if error is not None and case.error_unit == "relative" else None,
        peak_mb=peak_mb(way.run) if memory else None,
    )


def _times(time: Timed, reference: Timed | None) -> dict[str, Any]:
    return {
        "least_ms": 1e3 * time.least_s,
        "median_ms": 1e3 * time.median_s,
        "iqr_ms": 1e3 * time.iqr_s,
        "ratio": reference and time.ratio_to(reference),
    }
