"""Study files of a few specimens of the paper, in BIDS and to be simulated, for tests and benchmarks."""

from __future__ import annotations

from collections.abc import Sequence

from casr.specimens import SPECIMENS

_A_V = {"S1": "42e-6", "S3": "28e-6", "S5": "16e-6"}
_B_V = {"S1": "20e-6", "S3": "13e-6", "S5": "7e-6"}

SIMULATED_SESSION = 'emg.kind = "simulated"\nforce.kind = "simulated"\n'
"""Keys of a table [session] whose devices are emulated."""


def small_study(
    *,
    name: str = "small",
    title: str = "A small study",
    participants: Sequence[str] = ("P01", "P02"),
    specimens: Sequence[str] = ("S1", "S3", "S5"),
    muscles: Sequence[str] = ("EDC", "FDS"),
    task: str = "palpation",
    simulation: str = "seed = 3\nrepetitions = 3\n",
    tables: str = "",
) -> str:
    """The text of a study file.

    simulation : lines of its [simulation] beside the true a and b. tables : further tables, such as [window].
    """
    pressed = "".join(f'[[specimens]]\nname = "{one}"\nstiffness_n_per_mm = {SPECIMENS[one]}\n' for one in specimens)
    truth = "".join(
        f"{key} = {{ {', '.join(f'{one} = {values[one]}' for one in specimens)} }}\n"
        for key, values in (("a_v", _A_V), ("b_v", _B_V))
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
