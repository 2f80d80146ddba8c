"""What becomes of flipped bits in stored results, and of two runs of one study at once.

Run as ``python -m benchmarks.store_faults [--flips 200] [--pairs 20]``; it prints Markdown tables. The study is a small
one with every stage. A flip is one bit of one stored result, at random places; it is noticed if ``status`` says so, and
made again if ``run`` ends well with every stored result and ``results.json`` byte for byte as they were. The runs of a
pair start 0.3 s apart on a study without results; every second pair does not wait (``--no-wait``).
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from benchmarks.small_study import WITH_A_RIG, small_rig, small_study
from emg2vsa.cli import main as emg2vsa
from emg2vsa.pipeline.plan import survey
from emg2vsa.pipeline.stage_order import ORDER
from emg2vsa.study_file import load_study

STUDY = small_study(tables=WITH_A_RIG)
RIG = small_rig()
APART_S = 0.3


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--flips", type=int, default=200)
    parser.add_argument("--pairs", type=int, default=20)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "finished" / "studies" / "small"
        folder.mkdir(parents=True)
        (folder / "study.toml").write_text(STUDY)
        (folder / "rig.toml").write_text(RIG)
        _quietly("tools simulate", folder / "study.toml")
        fresh = Path(name) / "fresh"
        shutil.copytree(Path(name) / "finished", fresh)
        if _quietly("run", folder / "study.toml"):
            sys.exit("the study itself did not run")
        if arguments.flips:
            _flips(folder / "study.toml", arguments.flips)
        if arguments.pairs:
            _pairs(fresh, _results_json(folder), arguments.pairs)


def _flips(study: Path, tries: int) -> None:
    draw = random.Random(20261122)
    whole, results = _stored(study.parent), _results_json(study.parent)
    noticed, mended, flips = Counter[str](), Counter[str](), Counter[str]()
    for _ in range(tries):
        path = draw.choice(sorted(whole))
        stage = path.relative_to(study.parent / ".emg2vsa" / "small" / "store").parts[0]
        data = bytearray(whole[path])
        data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
        path.write_bytes(data)
        flips[stage] += 1
        stale = [step for step in survey(load_study(study), ORDER, print).steps.values() if step.status == "stale"]
        noticed[stage] += [step.reasons for step in stale] == [("its result was damaged",)]
        ended = _quietly("run", study, "--jobs", "1")
        mended[stage] += ended == 0 and _stored(study.parent) == whole and _results_json(study.parent) == results
    print("| one bit flipped in a result of | tries | noticed | made again, everything as it was |\n|---|---|---|---|")
    for stage in (name for name in ORDER if name in flips):
        print(f"| {stage} | {flips[stage]} | {noticed[stage]} | {mended[stage]} |")
    print(f"| **all** | {tries} | {noticed.total()} of {tries} | {mended.total()} of {tries} |\n", flush=True)


def _pairs(fresh: Path, results: bytes, tries: int) -> None:
    rows: Counter[tuple[str, str, str, bool]] = Counter()
    for one in range(tries):
        folder = fresh.parent / f"pair-{one}"
        shutil.copytree(fresh, folder)
        study = folder / "studies" / "small" / "study.toml"
        option = [] if one % 2 == 0 else ["--no-wait"]
        command = [sys.executable, "-m", "emg2vsa.cli", "run", str(study), *option]
        both = []
        for pause in (APART_S, 0):
            both.append(
                subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=_env())
            )
            time.sleep(pause)
        told = [process.communicate() for process in both]
        words = "".join(text for pair in told for text in pair)
        said = "waits" if "Waiting: another run holds" in words else "held by" if "held by process" in words else "-"
        failed = " ".join(line for out, _ in told for line in out.splitlines() if "refused or failed" in line)
        clean = failed.count(" 0 refused or failed") == failed.count("refused or failed")
        ends = " and ".join(str(process.returncode) for process in both)
        rows[" ".join(["run", *option]), ends, said, clean and _results_json(study.parent) == results] += 1
        shutil.rmtree(folder)
    print("| two at once | exit statuses | one of them said | no step failed, results equal | pairs |")
    print("|---|---|---|---|---|")
    for (command_line, ends, said, equal), count in sorted(rows.items()):
        print(f"| `{command_line}` | {ends} | {said} | {'yes' if equal else 'NO'} | {count} |")


def _stored(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in (folder / ".emg2vsa" / "small" / "store").rglob("*.result")}


def _results_json(folder: Path) -> bytes:
    return (folder.parent.parent / "reports" / "small" / "results.json").read_bytes()


def _quietly(command: str, study: Path, *options: str) -> int:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        return emg2vsa([*command.split(), str(study), *options])


def _env() -> dict[str, str]:
    return os.environ | {"OPENBLAS_NUM_THREADS": "1"}


if __name__ == "__main__":
    main()
