"""The command ``emg2vsa``: heavy modules are loaded only by the sub-command that runs."""

from __future__ import annotations

import gc
from collections.abc import Sequence

import emg2vsa
from casr.command_line import Program
from emg2vsa.cli.tools import SUBCOMMANDS as TOOLS
from emg2vsa.errors import EXTRAS

PROGRAM = Program(
    name="emg2vsa",
    version=emg2vsa.__version__,
    description="From palpation EMG and force to stiffness schedules of a variable stiffness actuator.",
    epilog="Try: emg2vsa tools simulate studies/palpation/study.toml, then emg2vsa run studies/palpation/study.toml.",
    commands={
        "new": "new", "inspect": "recordings", "check": "check", "register": "register", "run": "run",
        "status": "run", "report": "report", "fit": "recordings", "schedule": "report", "stats": "stats",
        "session": "session", "rig": "rig", "verify": "report", "tools": "tools",
    },
    stopped="What was finished is kept; the same command goes on from there.",
    extras=EXTRAS,
    moved={name: f"tools {name}" for name in TOOLS},
)  # fmt: skip


def main(argv: Sequence[str] | None = None) -> int:
    """Run one sub-command; returns the exit status: 0 done, 1 something is not good, 2 unusable input."""
    gc.set_threshold(100_000)  # imports and reports make few cycles; looking for them took an eighth of a cold run
    return PROGRAM.main(argv)
