"""The command ``casr``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import casr


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="casr", description=casr.__doc__)
    parser.add_argument("--version", action="version", version=f"casr {casr.__version__}")
    parser.parse_args(argv)
    parser.print_help()
    return 0
