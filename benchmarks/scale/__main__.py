"""How one machine copes with many people, specimens and frames, long sessions and dying workers.

``python -m benchmarks.scale`` measures everything, which takes a night. Sizes can be measured in pieces
(``--participants 200``, ``--frames 1000 100000``): each replaces its row in docs/benchmarks/scale.json, with the date
and the commit, and scale.md with its curves is written anew.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from benchmarks.scale import cluster, frames, people, sitting, specimens
from benchmarks.scale.results import KEYS, keep

SIZES: dict[str, tuple[int, ...]] = {
    "participants": (14, 50, 200, 1000, 5000),
    "frames": (1000, 10_000, 100_000, 1_000_000),
    "specimens": (10, 30, 100),
    "session_s": (1800, 7200),
    "workers": (10,),
}


def rows_of(kind: str, sizes: Iterable[int], folder: Path) -> Iterator[dict[str, Any]]:
    """One row for each size."""
    if kind == "participants":
        one, _ = people.measured(folder / "measured")
        for size in sizes:
            yield {kind: size} | people.measure(people.replicated(one, folder / str(size), size))
    elif kind == "frames":
        yield from frames.measure(sorted(sizes))
    else:
        for size in sizes:
            if kind == "specimens":
                yield specimens.measured(folder / str(size), size)
            elif kind == "session_s":
                yield {kind: size} | sitting.measured(size)
            else:
                yield cluster.measured(folder / str(size), size)


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for kind, sizes in SIZES.items():
        option = f"--{kind.replace('_', '-')}"
        parser.add_argument(option, type=int, nargs="*", metavar="N", help=f"default: {' '.join(map(str, sizes))}")
    asked = {kind: sizes for kind, sizes in vars(parser.parse_args()).items() if sizes is not None}
    for kind, sizes in (asked or SIZES).items():
        with tempfile.TemporaryDirectory() as name:
            for row in rows_of(kind, sizes or SIZES[kind], Path(name) / kind):
                keep(KEYS[kind], kind, row)


if __name__ == "__main__":
    main()
