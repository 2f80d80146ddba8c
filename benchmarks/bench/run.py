"""What ``emg2vsa tools bench`` does: choose areas, measure each in a child process, print and write."""

from __future__ import annotations

import difflib
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.areas import NAMES, area
from benchmarks.bench.child import SOURCE, measured_in_child
from benchmarks.bench.results import AreaResult, from_json, to_json
from benchmarks.bench.tables import case_lines, index, page, provenance
from casr.atomic import write_text_atomic
from casr.terminal import finite
from emg2vsa.errors import DataError, SettingError

PUBLISHED = SOURCE / "docs" / "benchmarks"
ROUNDS = {"smoke": 2, "full": 9}


def list_areas() -> None:
    """Print every area with its question."""
    for name in NAMES:
        print(f"{name:14} {area(name).question}")


def bench(
    names: Sequence[str],
    *,
    smoke: bool = False,
    out: Path | None = None,
    json_file: Path | None = None,
    compare: str | None = None,
    repeats: int | None = None,
    only: str = "",
) -> None:
    """Measure areas, all if none is named, and print their tables.

    out : where pages, pictures and JSON go. Without it a full run of whole areas writes ``docs/benchmarks``, and any
    other run writes nothing there. SettingError for an unknown area, or for a folder that cannot be written, before
    anything runs.
    """
    chosen = chosen_areas(names)
    size = "smoke" if smoke else "full"
    folder = out or (None if smoke or only or compare else PUBLISHED)
    for path, what in ((folder, "--out"), (json_file and json_file.parent, "--json")):
        if path is not None:
            check_writable(path, what)
    options: dict[str, Any] = {"size": size, "rounds": repeats or ROUNDS[size], "only": only, "memory": not smoke}
    if compare is not None:
        _compare(chosen, options, compare, json_file)
        return
    results = []
    for name in chosen:
        result = measured_in_child(name, options)
        results.append(result)
        _print(result)
        if folder:
            write_area(result, folder)
    if not any(result.cases for result in results):
        raise SettingError(
            "--only", wanted="a word in the name of a case, of a library or of a way", found=repr(only),
            do="emg2vsa tools bench --smoke prints all names.",
        )  # fmt: skip
    if json_file:
        _write_json(json_file, [to_json(result) for result in results])


def chosen_areas(names: Sequence[str]) -> list[str]:
    """The names, all areas if none; SettingError for one that is no area."""
    for name in names:
        if name not in NAMES:
            near = difflib.get_close_matches(name, NAMES, 1)
            raise SettingError(
                "bench", wanted=f"an area: {', '.join(NAMES)}", found=repr(name),
                do=f"Did you mean {near[0]}?" if near else "Choose one of these.",
            )  # fmt: skip
    return list(dict.fromkeys(names)) or list(NAMES)


def check_writable(folder: Path, option: str) -> None:
    """Make the folder; SettingError where nothing can be written into it."""
    trial = folder / ".bench"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        trial.touch()
        trial.unlink()
    except OSError as error:
        raise SettingError(
            f"{option} {folder}", wanted="a folder to write to", found=error.strerror or str(error),
            do="Name another folder.",
        ) from error  # fmt: skip


def write_area(result: AreaResult, folder: Path) -> None:
    """Page, picture and JSON of an area, and the index of all areas whose JSON is in the folder."""
    from benchmarks.bench.plots import write_picture

    write_text_atomic(folder / f"{result.name}.md", page(result, write_picture(result, folder)))
    _write_json(folder / f"{result.name}.json", to_json(result))
    known = [folder / f"{name}.json" for name in NAMES]
    write_text_atomic(folder / "README.md", index(read_area(path) for path in known if path.exists()))


def _compare(chosen: Sequence[str], options: dict[str, Any], revision: str, json_file: Path | None) -> None:
    from benchmarks.bench.compare import compare, lines, product_of

    pairs = options["rounds"]
    found = {}
    with product_of(revision) as old:
        for name in chosen:
            # each process has few rounds of its own: the pairs of processes are the repeats
            found[name] = compare(name, {**options, "rounds": 3}, old, pairs)
            print("\n".join([f"# {name}: here beside {revision}", "", *lines(revision, found[name]), ""]), flush=True)
    if json_file:
        _write_json(json_file, {name: [asdict(one) for one in compared] for name, compared in found.items()})


def _print(result: AreaResult) -> None:
    parts = [f"# {result.name}", "", provenance(result), ""]
    for case in result.cases:
        parts += [f"## {case.name}", "", *case_lines(case), ""]
    parts += [f"not installed: {name}" for name in result.absent]
    parts += [f"not measured: {what}" for what in result.missing]
    print("\n".join(parts), flush=True)


def _write_json(path: Path, value: object) -> None:
    write_text_atomic(path, json.dumps(finite(value), indent=1) + "\n")


def read_area(path: Path) -> AreaResult:
    """What `write_area` kept."""
    try:
        return from_json(json.loads(path.read_text()))
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(
            path, wanted="what emg2vsa tools bench wrote", found=str(error), do="Delete it, and run its area again."
        ) from error


if __name__ == "__main__":
    print("Run: emg2vsa tools bench", file=sys.stderr)
