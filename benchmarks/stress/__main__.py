"""``python -m benchmarks.stress [--smoke] [--out DIR] [AREA ...]``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from benchmarks.stress import AREAS, run

if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("areas", nargs="*", default=AREAS, metavar="AREA")
    parser.add_argument("--smoke", action="store_true")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    sys.exit(run(given.out, given.smoke, tuple(given.areas)))
