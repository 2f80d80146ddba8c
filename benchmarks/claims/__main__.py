"""Whole studies in worlds that are known, and how often their claims are wrong: ``python -m benchmarks.claims RUNS``.

RUNS is a file of lines of JSON, one for each chunk of studies, which a run that was stopped goes on with; lines of
another version of the code are left alone. ``--table`` reads them, and writes the record and what the report shows.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.bench.record import RESULTS, keep
from benchmarks.claims.study import judged, truth_of
from benchmarks.claims.table import module, page
from benchmarks.claims.verdicts import LETTERS, Truth
from benchmarks.claims.worlds import WORLDS, World
from casr.atomic import write_text_atomic

ROOT = Path(__file__).resolve().parents[2]
FOR_REPORT = ROOT / "emg2vsa" / "claims" / "calibrated.py"
_CODE = ("emg2vsa/claims/*.py", "emg2vsa/calibration/*.py", "emg2vsa/discrimination/*.py", "emg2vsa/statistics/*.py",
         "emg2vsa/profiles/*.py", "emg2vsa/settings.py")  # fmt: skip
_OWN = ("people.py", "laws.py", "rig.py", "kappa.py", "study.py")


def code_of(world: World) -> str:
    """Of the claims and of what makes the studies of this world."""
    digest = hashlib.sha256(repr(world).encode())
    own = [Path(__file__).with_name(name) for name in _OWN]
    for path in [*sorted(path for pattern in _CODE for path in ROOT.glob(pattern) if path != FOR_REPORT), *own]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def chunk(world: World, first: int, size: int) -> dict[str, Any]:
    """Verdicts of ``size`` studies from seed ``first`` on."""
    start = time.perf_counter()
    studies = judged(world, range(first, first + size))
    keys = [each.claim.key for each in studies[0]]
    assert all([each.claim.key for each in study] == keys for study in studies), "a claim is missing in some studies"
    verdicts = {key: "".join(LETTERS[study[i].verdict] for study in studies) for i, key in enumerate(keys)}
    seconds = round((time.perf_counter() - start) / size, 4)
    return {"world": world.name, "first": first, "size": size, "seconds": seconds, "verdicts": verdicts}


def run(path: Path, worlds: list[World], studies: int, size: int) -> None:
    """What is not yet in the file, round by round of worlds, so that all have about as many studies at any time."""
    done = {(line["world"], line["code"], line.get("first", -1)) for line in lines(path)}
    with path.open("a", encoding="utf-8") as out:
        for first in (-1, *range(0, studies, size)):
            for world in worlds:
                code = code_of(world)
                if (world.name, code, first) in done:
                    continue
                made = {"world": world.name, "truth": truth_of(world)} if first < 0 else chunk(world, first, size)
                out.write(json.dumps({"code": code, **made}) + "\n")
                out.flush()
                print(world.name, first, made.get("seconds", ""), file=sys.stderr, flush=True)


def lines(path: Path) -> Iterator[dict[str, Any]]:
    """Whole lines; one that was cut by the end of a run is left out."""
    for text in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
        try:
            yield json.loads(text)
        except json.JSONDecodeError:
            continue


def found(path: Path) -> tuple[dict[str, dict[str, str]], dict[str, dict[str, Truth]]]:
    """World to the verdicts of its studies by claim, and to what is true, by the code of today."""
    verdicts: dict[str, dict[str, str]] = {}
    truths: dict[str, dict[str, Truth]] = {}
    codes = {world.name: code_of(world) for world in WORLDS}
    chunks = [line for line in lines(path) if codes.get(line["world"]) == line["code"]]
    for line in sorted(chunks, key=lambda line: line.get("first", -1)):
        name = line["world"]
        if "truth" in line:
            truths[name] = {key: Truth(*each) for key, each in line["truth"].items()}
            continue
        own = verdicts.setdefault(name, {})
        for key, letters in line["verdicts"].items():
            own[key] = own.get(key, "") + letters
    return verdicts, truths


def main(words: list[str]) -> int:
    """Run what is missing, or write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=Path)
    parser.add_argument("--worlds", nargs="*", default=[world.name for world in WORLDS])
    parser.add_argument("--studies", type=int, default=500)
    parser.add_argument("--chunk", type=int, default=25, help="studies at a time")
    parser.add_argument(
        "--table", action="store_true", help="print the page; with --write keep it, and the report's table"
    )
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args(words)
    if not arguments.table:
        run(arguments.runs, [w for w in WORLDS if w.name in arguments.worlds], arguments.studies, arguments.chunk)
        return 0
    verdicts, truths = found(arguments.runs)
    text = "\n".join(page(verdicts, truths))
    print(text)
    if arguments.write:
        keep(RESULTS / "claims.json", text)
        write_text_atomic(FOR_REPORT, module(verdicts, truths))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
