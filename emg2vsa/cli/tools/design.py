"""``emg2vsa tools design``: how many calibration specimens and presses a wanted precision of kappa needs."""

from __future__ import annotations

import argparse

from casr.command_line import JSON, Commands, add_command, answer

SUMMARY = "Find how many calibration specimens and presses a given precision of stiffness needs."
EPILOG = """
The command simulates whole experiments: it presses known specimens, calibrates by the compliance law and estimates. The
defaults describe the specimens of the paper and the noise of simulated presses. Use the noise and the sensor stiffness
of your own calibration.
"""
OPTIONS = f"""
--precision P = 0.1  half width of the interval to reach, as a share of kappa (default 0.1)
--kappa K = 5.32  stiffness to be estimated, N/mm (default 5.32)
--range X  stiffness of the softest and the stiffest known specimen, N/mm (default 1.11 7.63)
--noise S = 0.02  standard deviation of the score of a press, as a share of the score (default 0.02)
--kappa-error E = 0  relative error of each known stiffness (default 0)
--mounting M = 0  SD of a score from one mounting to the next, share of it (default 0: all specimens are mounted alike)
--sensor K = 4  stiffness of the sensor itself, N/mm (default 4)
--experiments N = 1000  number of simulated experiments for each design (default 1000)
{JSON}
"""


def add_to(commands: Commands) -> None:
    two = {"nargs": 2, "metavar": ("LOW", "HIGH"), "default": (1.11, 7.63)}
    add_command(
        commands, "design", run, SUMMARY, EPILOG, OPTIONS, {**dict.fromkeys("PKEM", float), "N": int}, range=two
    )


def run(arguments: argparse.Namespace) -> int:
    import dataclasses

    from emg2vsa.calibration.design import Situation, smallest, try_designs

    situation = Situation(
        kappa=arguments.kappa, kappa_range=tuple(arguments.range), noise=arguments.noise,
        kappa_error=arguments.kappa_error, mounting_sd=arguments.mounting, sensor_n_per_mm=arguments.sensor,
    )  # fmt: skip
    designs = try_designs(situation, experiments=arguments.experiments)
    chosen = smallest(designs, arguments.precision)
    told = {
        "designs": [dataclasses.asdict(design) | {"presses": design.presses} for design in designs],
        "smallest": None if chosen is None else dataclasses.asdict(chosen),
    }
    mounted = "every specimen is mounted once" if arguments.mounting else "all specimens are mounted alike"
    lines = [
        "specimens  presses each  in all  half width  median error  coverage",
        *(
            f"{one.specimens:>9}  {one.repetitions:>12}  {one.presses:>6}  {one.half_width:>10.1%}  "
            f"{one.error:>12.1%}  {one.coverage:>8.1%}"
            for one in designs
        ),
        f"none of these designs has a half width of {arguments.precision:.0%} or less: lower the noise of a press"
        if chosen is None
        else f"smallest design for {arguments.precision:.0%}: {chosen.specimens} specimens, {chosen.repetitions} "
        f"presses of each and of the new one, {chosen.presses} in all",
        f"These are simulated experiments in which the compliance law holds and {mounted}.",
    ]
    answer(arguments.json, told, lines)
    return 0
