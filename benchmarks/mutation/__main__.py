"""How many small wrong changes of the code the test suite notices.

    mkdir map; LINE_MAP=map python -m pytest -p benchmarks.mutation.line_map -n auto --dist loadfile -m "not realtime"
    python -m benchmarks.mutation --seed 20 --count 60 --map map --out mutation_20.json
    python -m benchmarks.mutation --table mutation_20.json ... > docs/benchmarks/mutation.md

The second line takes about 20 s of processor time a mutant, at most about 40 s for each of two runs. It resumes where
it was ended, and asks at its end that every test which killed a mutant passes on the unchanged tree: what such a test
killed is run again without it. The tests are those of the last commit. ``benchmarks/mutation/judged.json`` says what
each survivor is.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.mutation.mutants import Chosen, sample
from benchmarks.mutation.nearest import LineMap, files_for, read_line_map
from benchmarks.mutation.table import page
from benchmarks.mutation.trial import export, failed_tests, run_tests, tried

TREE = Path(__file__).resolve().parents[2]


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mutation", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=20)
    parser.add_argument("--count", type=int, default=60, help="mutants, over all packages in proportion to their lines")
    parser.add_argument("--package", default="", help="only packages whose name begins so, such as emg2vsa.statistics")
    parser.add_argument("--map", type=Path, help="folder of the line map; without it, tests that name the module")
    parser.add_argument("--out", type=Path, default=Path("mutation.json"), help="results, one entry a mutant")
    parser.add_argument("--about", default="", help="what these results are of, for the page")
    parser.add_argument("--list", action="store_true", help="print the sample, run nothing")
    parser.add_argument("--table", type=Path, nargs="+", metavar="JSON", help="print the page of these results")
    arguments = parser.parse_args(words)
    try:
        if arguments.table:
            print(page([json.loads(path.read_text(encoding="utf-8")) for path in arguments.table]))
            return 0
        if arguments.count < 1:
            raise ValueError(f"--count: expected 1 mutant or more, but found {arguments.count}. Give a larger number.")
        chosen = sample(TREE, seed=arguments.seed, count=arguments.count, package=arguments.package)
        lines = read_line_map(arguments.map) if arguments.map else {}
    except (ValueError, FileNotFoundError) as error:
        print(error, file=sys.stderr)
        return 2
    if arguments.list:
        for each in chosen:
            print(
                f"{each.module}:{each.mutant.line} {each.mutant.kind}: {each.mutant.before!r} -> {each.mutant.after!r}"
            )
        return 0
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        about = {"seed": arguments.seed, "about": arguments.about}
        run(chosen, lines, about, arguments.out, Path(folder))
    return 0


def run(chosen: list[Chosen], lines: LineMap, of: dict[str, Any], out: Path, folder: Path) -> None:
    """Try each mutant that ``out`` does not hold yet, then confirm what killed them. folder : for copies."""
    results: dict[str, Any] = json.loads(out.read_text(encoding="utf-8")) if out.exists() else of | {"mutants": []}
    results["drawn"] = len(chosen)
    done = {(row["module"], row["start"], row["kind"], row["after"]) for row in results["mutants"]}
    for each in chosen:
        mutant = each.mutant
        if (each.module, mutant.start, mutant.kind, mutant.after) in done:
            continue
        verdict = tried(TREE, each, files_for(TREE, each.module, mutant.line, lines), folder)
        results["mutants"].append({"module": each.module} | asdict(mutant) | asdict(verdict))
        _write(out, results)
        print(f"{each.module}:{mutant.line} {mutant.kind}: {verdict.state} {verdict.by}", flush=True)
    confirm(chosen, lines, results, folder)
    _write(out, results)


def confirm(chosen: list[Chosen], lines: LineMap, results: dict[str, Any], folder: Path) -> None:
    """Run every killing test on the unchanged tree; what one that fails there killed is tried without it."""
    killers = {row["by"] for row in results["mutants"] if "::" in row["by"]} - set(results.get("confirmed", []))
    failing: list[str] = []
    while killers:
        export(TREE, folder / "tree")
        _, out = run_tests(folder / "tree", sorted(killers), folder / "compiled", first_failure=False)
        failing += [name for name in failed_tests(out) if name in killers]
        results["confirmed"] = sorted({*results.get("confirmed", []), *killers} - set(failing))
        again = [row for row in results["mutants"] if row["by"] in failing]
        for row in again:
            each = next(each for each in chosen if (each.module, each.mutant.start) == (row["module"], row["start"]))
            files = files_for(TREE, each.module, each.mutant.line, lines)
            row |= asdict(tried(TREE, each, files, folder, deselected=failing))
        killers = {row["by"] for row in again if "::" in row["by"]} - set(results["confirmed"])


def _write(out: Path, results: dict[str, Any]) -> None:
    part = out.with_suffix(".part")
    part.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    part.replace(out)


if __name__ == "__main__":
    sys.exit(main())
