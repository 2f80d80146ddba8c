"""Every command computes on one thread, unless its user asked for more."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from casr.one_thread import VARIABLES

TOLD = (
    "import os, sys; from {0}.cli import main; main(['completion', 'bash']); print(*(os.environ[name] for name in {1}))"
)


@pytest.mark.parametrize("program", ["casr", "emg2vsa"])
@pytest.mark.parametrize("asked", [{}, {"OPENBLAS_NUM_THREADS": "3"}])
def test_a_command_asks_for_one_thread(program: str, asked: dict[str, str]) -> None:
    without = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    told = subprocess.run(
        [sys.executable, "-c", TOLD.format(program, VARIABLES)],
        env=without | asked,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    assert told.splitlines()[-1].split() == [asked.get(name, "1") for name in VARIABLES]
