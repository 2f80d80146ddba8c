"""The command ``casr``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import casr


def main(argv: Sequence[str] | None = None) -> int:
    """Answer ``--help`` and ``--version``; scoring tactile frames is not part of this release."""
    parser = argparse.ArgumentParser(
        prog="casr",
        description="Contact area spread rate of soft specimens from tactile frames and force. "
        "This release holds the package only; its commands come with the tactile pipeline.",
    )
    parser.add_argument("--version", action="version", version=f"casr {casr.__version__}")
    parser.parse_args(argv)
    parser.print_help()
    return 0
