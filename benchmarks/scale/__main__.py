"""How one machine copes with many people and many frames: ``python -m benchmarks.scale``.

Sizes can be measured in pieces (``--participants 200``, ``--frames 1000 100000``): each replaces its row in
docs/benchmarks/scale.json, and scale.md with its curves is written anew.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from benchmarks.scale import frames, people
from benchmarks.scale.results import keep


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--participants", type=int, nargs="*", metavar="N", help="default: 14 50 200 1000")
    parser.add_argument("--frames", type=int, nargs="*", metavar="N", help="default: 1000 to 1000000")
    arguments = parser.parse_args()
    neither = arguments.participants is None and arguments.frames is None
    sizes = (14, 50, 200, 1000) if neither else arguments.participants
    counts = (1000, 10_000, 100_000, 1_000_000) if neither else arguments.frames
    if sizes:
        with tempfile.TemporaryDirectory() as name:
            one, _ = people.measured(Path(name) / "measured")
            for size in sizes:
                study = people.replicated(one, Path(name) / str(size), size)
                keep("people", "participants", {"participants": size} | people.measure(study))
    if counts:
        for row in frames.measure(sorted(counts)):
            keep("frames", "frames", row)


if __name__ == "__main__":
    main()
