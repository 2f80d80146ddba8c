"""A study of many specimens, from its recordings to its report: CPU seconds and peak memory.

Every pair of specimens is compared: 100 of them are 4 950 pairs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.scale.people import measure, run

PEOPLE = ("P01", "P02", "P03", "P04")
HARDEST, SOFTEST = 10.0, 1.0
"""N/mm."""


def made(folder: Path, count: int) -> Path:
    """The study file of ``count`` specimens whose recordings are simulated; stiffness falls in equal steps of ln."""
    study = folder / "studies" / "many" / "study.toml"
    study.parent.mkdir(parents=True)
    study.write_text(_text(count))
    run("tools simulate", study)
    return study


def measured(folder: Path, count: int) -> dict[str, Any]:
    """What the whole run takes, its trials too."""
    return {"specimens": count} | measure(made(folder, count))


def _text(count: int) -> str:
    stiffness = {
        f"M{index + 1:03d}": HARDEST * (SOFTEST / HARDEST) ** (index / max(count - 1, 1)) for index in range(count)
    }
    pressed = "".join(
        f'[[specimens]]\nname = "{name}"\nstiffness_n_per_mm = {value:.4f}\n' for name, value in stiffness.items()
    )
    a_v = ", ".join(f"{name} = {4e-6 * value:.4g}" for name, value in stiffness.items())
    b_v = ", ".join(f"{name} = {2e-6 * value:.4g}" for name, value in stiffness.items())
    people = ", ".join(f'"{one}"' for one in PEOPLE)
    return f"""\
[study]
name = "many"
title = "Many specimens"
[participants]
ids = [{people}]
{pressed}[recordings]
layout = "bids"
root = "data"
task = "press"
[channels.emg.EDC]
name = "EDC"
[channels.emg.FDS]
name = "FDS"
[channels.force]
name = "Fz"
sign = -1
[simulation]
seed = 3
repetitions = 3
a_v = {{ {a_v} }}
b_v = {{ {b_v} }}
"""
