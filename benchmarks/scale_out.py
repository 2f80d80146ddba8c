"""What a cluster costs beside one process: CPU seconds per recording, files, ledger; all results compared.

Run with ``python -m benchmarks.scale_out [--participants 30 60]``. Participants are simulated, five recordings each,
and brought to their fits: by one process, and by a Dask cluster of this computer where the extra is installed. CPU
times are those of processes and their children.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import hashlib
import importlib.util
import io
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import tracemalloc
from pathlib import Path

from emg2vsa.cli import main as emg2vsa
from emg2vsa.pipeline.fingerprint import Fingerprints, _head, part_of
from emg2vsa.pipeline.ledger import Entry, Ledger, Parts

ROOT = Path(__file__).resolve().parent.parent
TEMPLATE = ROOT / "studies" / "palpation" / "study.toml"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--participants", type=int, nargs="+", default=[30, 60])
    parser.add_argument("--memories", type=int, metavar="STEPS", help="only read a ledger and fingerprints of so many")
    arguments = parser.parse_args()
    if arguments.memories:
        _memories(arguments.memories)
        return
    print("| recordings | way | CPU s | CPU ms a recording | nothing to do: CPU s | same bytes |")
    print("|---:|---|---:|---:|---:|---|")
    ways = [("--jobs", "1")] + ([("--cluster", "local:2")] if importlib.util.find_spec("distributed") else [])
    for count in arguments.participants:
        with tempfile.TemporaryDirectory() as name:
            study, wanted = _simulated(Path(name), count), ""
            for way in ways:
                shutil.rmtree(study.parent / ".emg2vsa", ignore_errors=True)
                spent, idle, found = _cpu_s(study, *way), _cpu_s(study, *way), _digest(study)
                wanted = wanted or found
                each_ms, same = spent / (5 * count) * 1e3, "yes" if found == wanted else "NO"
                print(
                    f"| {5 * count} | {' '.join(way)} | {spent:.1f} | {each_ms:.0f} | {idle:.2f} | {same} |", flush=True
                )
            _store(study, count)


def _store(study: Path, count: int) -> None:
    """What lies on the disk."""
    results = next((study.parent / ".emg2vsa").iterdir())
    stored = [path for path in (results / "store").rglob("*") if path.is_file()]
    ledger, prints = (results / name for name in ("ledger.jsonl", "fingerprints.json"))
    data = [path for path in (study.parent / "data").rglob("*") if path.is_file()]
    print(
        f"\n{count} participants: {len(data)} files of data ({_mb(data):.0f} MB), {len(stored)} results "
        f"({_mb(stored):.1f} MB), ledger {ledger.stat().st_size / len(stored):.0f} bytes a step, "
        f"fingerprints {prints.stat().st_size / (len(stored) + len(data)):.0f} bytes a file\n",
        flush=True,
    )


def _memories(count: int) -> None:
    """CPU seconds and memory that a ledger of ``count`` steps, and fingerprints of as many files, take to be read."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shared = [part_of({f"{which}{number}": "0123456789abcdef" for number in range(60)}) for which in "abc"]
        parts = Parts(shared[0], {"data/P/emg.bdf": "0" * 16, "side.json": "1" * 16}, {"trials": "2" * 16}, *shared[1:])
        lines = Ledger(folder)
        for number in range(count):
            lines.record(Entry(f"trials/P{number:06d}/S1", f"{number:016x}", "done", "", False, "3" * 16, parts))
        prints = {
            f"{folder}/store/trials/P{n:06d}/S1/{n:016x}.result": [(1, 2**60, 2**60, n), "4" * 16] for n in range(count)
        }
        files = json.dumps(prints).encode()
        (folder / "fingerprints.json").write_bytes(_head(files) + files + b"}")
        del lines, prints, files
        for what, read in (("ledger", Ledger), ("fingerprints", lambda at: Fingerprints(at / "fingerprints.json"))):
            gc.collect()
            tracemalloc.start()
            kept = read(folder)
            size = tracemalloc.get_traced_memory()[0]
            tracemalloc.stop()
            del kept
            start = time.process_time()
            read(folder)
            spent, path = time.process_time() - start, next(folder.glob(f"{what}*"))
            print(
                f"{what}: {path.stat().st_size / count:.0f} bytes, {spent / count * 1e6:.1f} CPU us, "
                f"{size / count / 1e3:.2f} kB of memory a step ({count} steps)"
            )


def _mb(paths: list[Path]) -> float:
    return sum(path.stat().st_size for path in paths) / 1e6


def _simulated(folder: Path, count: int) -> Path:
    study = folder / "studies" / "palpation" / "study.toml"
    study.parent.mkdir(parents=True)
    text = re.sub(r"\[runs\]\n(.+\n)*", "", TEMPLATE.read_text())
    names = ", ".join(f'"P{number:04d}"' for number in range(1, count + 1))
    study.write_text(re.sub(r"ids = \[.*?\]", f"ids = [{names}]", text, flags=re.S))
    with contextlib.redirect_stdout(io.StringIO()):
        if emg2vsa(["tools", "simulate", str(study), "--json"]):
            raise SystemExit("the study was not simulated")
    return study


def _digest(study: Path) -> str:
    found = hashlib.blake2b()
    for path in sorted((study.parent / ".emg2vsa").rglob("*.result")):
        found.update(path.name.encode() + path.read_bytes())
    return found.hexdigest()


def _cpu_s(study: Path, *options: str) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "emg2vsa.cli", "run", str(study), "--only", "fits", "--json", *options]
    subprocess.run(command, capture_output=True, check=True, cwd=ROOT, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


if __name__ == "__main__":
    main()
