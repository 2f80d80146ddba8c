"""The command ``emg2vsa``: one file per sub-command, heavy modules loaded only by the one that runs."""

from __future__ import annotations

import argparse
import gc
import importlib
import os
import sys
from collections.abc import Sequence

import emg2vsa
from emg2vsa.errors import Emg2vsaError, StudyError

COMMANDS = (
    "simulate",
    "check",
    "run",
    "status",
    "fit",
    "schedule",
    "report",
    "power",
    "design",
    "stats",
    "stiffness",
    "rig",
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one sub-command; returns the exit status: 0 done, 1 something is not good, 2 unusable input."""
    arguments = parser().parse_args(argv)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # looking for plugins costs a tenth of a warm run
    gc.set_threshold(100_000)  # imports and reports make few cycles; looking for them took an eighth of a cold run
    try:
        status: int = arguments.run(arguments)
        sys.stdout.flush()
        return status
    except StudyError as error:
        count = len(error.problems)
        print(f"{error}\n{count} problem{'s' if count != 1 else ''}; nothing was run.", file=sys.stderr)
    except Emg2vsaError as error:
        print(f"emg2vsa: {error}", file=sys.stderr)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        print(f"emg2vsa: {error.filename or 'input or output'}: {error.strerror or error}", file=sys.stderr)
    except KeyboardInterrupt:
        print("\nStopped. What was finished is kept; the same command goes on from there.", file=sys.stderr)
        return 130
    return 2


def parser() -> argparse.ArgumentParser:
    """The parser of the whole command line; each sub-command adds its own."""
    whole = argparse.ArgumentParser(
        prog="emg2vsa",
        description="From palpation EMG and force to stiffness schedules of a variable stiffness actuator.",
        epilog="Try: emg2vsa simulate studies/palpation/study.toml, then emg2vsa run studies/palpation/study.toml. "
        "Exit status: 0 done; 1 something is not good; 2 unusable input, nothing was done; 130 stopped.",
    )
    whole.add_argument("--version", action="version", version=f"emg2vsa {emg2vsa.__version__}")
    commands = whole.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name in COMMANDS:
        importlib.import_module(f"emg2vsa.cli.{name}").add_to(commands)
    return whole
