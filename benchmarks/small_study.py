"""Study files of a few specimens of the paper, in BIDS and to be simulated, for tests and benchmarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from casr.specimens import SPECIMENS

PAPER = {
    "S1": (str(SPECIMENS["S1"]), "42e-6", "20e-6"),
    "S3": (str(SPECIMENS["S3"]), "28e-6", "13e-6"),
    "S5": (str(SPECIMENS["S5"]), "16e-6", "7e-6"),
}
"""Stiffness, N/mm, a and b, V, of each specimen, as the file writes them."""

SIMULATED_SESSION = 'emg.kind = "simulated"\nforce.kind = "simulated"\n'
"""Keys of a table [session] whose devices are emulated."""


def small_study(
    *,
    name: str = "small",
    title: str = "A small study",
    participants: Sequence[str] = ("P01", "P02"),
    specimens: Sequence[str] | None = None,
    laws: Mapping[str, tuple[str, str, str]] = PAPER,
    muscles: Sequence[str] = ("EDC", "FDS"),
    task: str = "palpation",
    simulation: str = "seed = 3\nrepetitions = 3\n",
    tables: str = "",
) -> str:
    """The text of a study file.

    specimens : names in ``laws``, all if None; laws : as ``PAPER``. simulation : lines of its [simulation] beside the
    true a and b. tables : further tables, such as [window].
    """
    used = {one: laws[one] for one in specimens or laws}
    pressed = "".join(f'[[specimens]]\nname = "{one}"\nstiffness_n_per_mm = {law[0]}\n' for one, law in used.items())
    truth = "".join(
        f"{key} = {{ {', '.join(f'{one} = {law[i]}' for one, law in used.items())} }}\n"
        for i, key in enumerate(("a_v", "b_v"), 1)
    )
    people = ", ".join(f'"{one}"' for one in participants)
    channels = "".join(f'[channels.emg.{one}]\nname = "{one}"\n' for one in muscles)
    return f"""\
[study]
name = "{name}"
title = "{title}"
[participants]
ids = [{people}]
{pressed}[recordings]
layout = "bids"
root = "data"
task = "{task}"
{channels}[channels.force]
name = "Fz"
sign = -1
[simulation]
{simulation}{truth}{tables}"""


WITH_A_RIG = """\
[window]
expected_trials = 3
[profile]
participant = "P02"
new_specimen = "S_new"
new_stiffness_n_per_mm = 5.32
[schedule]
actuator = "qbmove-maker-pro"
[runs]
rig = "rig.toml"
"""
"""Tables of a small study that an emulated rig presses, too."""


def small_rig(angles_deg: str = "modular = [0]\n") -> str:
    """The text of its rig file. angles_deg : lines of [experiment.angles_deg]."""
    return f"""\
[actuator]
port = "/dev/ttyUSB0"
[motor]
port = "/dev/ttyUSB1"
[force]
kind = "net-ft"
host = "192.168.1.1"
[camera]
source = 0
[experiment]
specimens = ["S1", "S3", "S5", "S_new"]
repetitions = 2
pause_s = 0.1
[experiment.angles_deg]
{angles_deg}[emulated]
stiffness_n_per_mm = {{ S1 = 7.63, S3 = 3.35, S5 = 1.11, S_new = 5.32 }}
"""
