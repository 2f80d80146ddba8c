"""``emg2vsa design``: how many calibration specimens and presses a wanted precision of kappa needs."""

from __future__ import annotations

import argparse

from casr.command_line import Commands, add_command, add_json, print_json


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "design",
        run,
        "Find how many calibration specimens and presses a given precision of stiffness needs.",
        "The command simulates whole experiments: it presses known specimens, calibrates by the compliance law and "
        "estimates. The defaults describe the specimens of the paper and the noise of simulated presses. "
        "Use the noise and the sensor stiffness of your own calibration.",
    )
    parser.add_argument(
        "--precision",
        type=float,
        default=0.1,
        metavar="P",
        help="half width of the interval to reach, as a share of kappa (default 0.1)",
    )
    parser.add_argument(
        "--kappa", type=float, default=5.32, metavar="K", help="stiffness to be estimated, N/mm (default 5.32)"
    )
    parser.add_argument(
        "--range",
        type=float,
        nargs=2,
        default=(1.11, 7.63),
        metavar=("LOW", "HIGH"),
        help="stiffness of the softest and the stiffest known specimen, N/mm (default 1.11 7.63)",
    )
    parser.add_argument(
        "--noise",
        type=float,
        default=0.02,
        metavar="S",
        help="standard deviation of the score of a press, as a share of the score (default 0.02)",
    )
    parser.add_argument(
        "--kappa-error", type=float, default=0.0, metavar="E", help="relative error of each known stiffness (default 0)"
    )
    parser.add_argument(
        "--mounting", type=float, default=0.0, metavar="M",
        help="SD of a score from one mounting to the next, share of it (default 0: all specimens are mounted alike)",
    )  # fmt: skip
    parser.add_argument(
        "--sensor", type=float, default=4.0, metavar="K", help="stiffness of the sensor itself, N/mm (default 4)"
    )
    parser.add_argument(
        "--experiments",
        type=int,
        default=1000,
        metavar="N",
        help="number of simulated experiments for each design (default 1000)",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    import dataclasses

    from emg2vsa.calibration.design import Situation, smallest, try_designs

    situation = Situation(
        kappa=arguments.kappa,
        kappa_range=(arguments.range[0], arguments.range[1]),
        noise=arguments.noise,
        kappa_error=arguments.kappa_error,
        mounting_sd=arguments.mounting,
        sensor_n_per_mm=arguments.sensor,
    )
    designs = try_designs(situation, experiments=arguments.experiments)
    chosen = smallest(designs, arguments.precision)
    if arguments.json:
        print_json(
            {
                "designs": [dataclasses.asdict(design) | {"presses": design.presses} for design in designs],
                "smallest": None if chosen is None else dataclasses.asdict(chosen),
            }
        )
        return 0
    print("specimens  presses each  in all  half width  median error  coverage")
    for design in designs:
        print(
            f"{design.specimens:>9}  {design.repetitions:>12}  {design.presses:>6}  {design.half_width:>10.1%}  "
            f"{design.error:>12.1%}  {design.coverage:>8.1%}"
        )
    if chosen is None:
        print(
            f"none of these designs has a half width of {arguments.precision:.0%} or less: lower the noise of a press"
        )
    else:
        print(
            f"smallest design for {arguments.precision:.0%}: {chosen.specimens} specimens, {chosen.repetitions} "
            f"presses of each and of the new one, {chosen.presses} in all"
        )
    mounted = "every specimen is mounted once" if arguments.mounting else "all specimens are mounted alike"
    print(f"These are simulated experiments in which the compliance law holds and {mounted}.")
    return 0
