"""The command ``casr``: one file per sub-command, heavy modules loaded only by the one that runs."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence

import casr
from casr.errors import CasrError

COMMANDS = ("score", "area", "flow", "simulate", "bench")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one sub-command; returns the exit status: 0 done, 1 something is not good, 2 unusable input."""
    arguments = parser().parse_args(argv)
    try:
        status: int = arguments.run(arguments)
        sys.stdout.flush()
        return status
    except CasrError as error:
        print(f"casr: {error}", file=sys.stderr)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        print(f"casr: {error.filename or 'input or output'}: {error.strerror or error}", file=sys.stderr)
    except KeyboardInterrupt:
        print("\nStopped. Files that were finished are kept.", file=sys.stderr)
        return 130
    return 2


def parser() -> argparse.ArgumentParser:
    """The parser of the whole command line; each sub-command adds its own."""
    whole = argparse.ArgumentParser(
        prog="casr",
        description="From tactile frames and force to the contact area spread rate (CASR) of a soft specimen.",
        epilog="Try: casr simulate presses, then casr score presses --page scores.html. "
        "Exit status: 0 done; 1 something is not good; 2 unusable input, nothing was done; 130 stopped.",
    )
    whole.add_argument("--version", action="version", version=f"casr {casr.__version__}")
    commands = whole.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name in COMMANDS:
        importlib.import_module(f"casr.cli.{name}").add_to(commands)
    return whole
