"""``casr simulate``: presses whose flow, contact area and spread rate are known."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from casr.cli.arguments import TYPES, count, of_fields
from casr.command_line import Commands, add_command, add_json, add_options, print_json, whole_number
from casr.plugins import made_worlds
from casr.terminal import VOICE

PRESSES = """
--specimens NAMES = S1,S3,S5,S2  specimens of the paper, S1 to S5 (default %(default)s)
--angles DEGREES = 0,30,45  default %(default)s
--repetitions N = 10  of each specimen and angle (default %(default)s)
--force-max-n N = 7  peak force, N (default %(default)s)
--world {tabulated,tabulated-frictionless,stick,front} = tabulated  tabulated: finite elements, the skin sticks
    (default); tabulated-frictionless: it slides; stick: the contact grows over the skin up to --stick-force-n, then
    stretches it; front: it never stretches it
--stick-force-n N  with --world stick: force from which on the contact is a piece of skin (default 0.43)
--domes FOLDER  tables of one dome of your own (casr dome), which is pressed in place of that of the default world
--dome-radius-mm MM = 20  with --domes: radius of the sensor, for camera.toml; casr dome names it (default %(default)s)
--specimen-height-mm MM  with --domes: thickness of the specimens, where the tables have several
--scatter {realistic,none} = realistic  how presses of one kind differ: depth, stiffness and angle of a mounting; area,
    resting force and delay of a press (default %(default)s)
--mounting N = 0  another mounting of sensor and specimens (default %(default)s)
--seed N = 0  another sensor and other draws (default %(default)s)
"""
LOOK = """
--noise-grey RMS = 2  read noise, grey levels (default %(default)s)
--texture-grey RMS = 0  texture that moves with the skin, grey levels (default %(default)s)
--dirt-grey RMS = 0  dirt that stays where it is, grey levels (default %(default)s)
--glare N = 0  reflections (default %(default)s)
--missing-pins N = 0  pins broken off (default %(default)s)
"""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "simulate", run,
        "Write simulated presses: frames, force log, camera, and the truth they were made from.",
        "One folder per press, OUT/SPECIMEN_ANGLE_REPETITION, with frames.tif, force.csv, camera.toml and truth.json. "
        "The same options give the same bytes. Example: casr simulate presses --specimens S1,S3 --repetitions 3",
    )  # fmt: skip
    add_options(parser, "out OUT  folder to write to", {"OUT": Path})
    whole, least = {"type": count}, {"type": whole_number}
    presses = parser.add_argument_group("presses")
    add_options(presses, PRESSES, TYPES, repetitions=least, mounting=whole, seed={"type": int})
    add_options(parser.add_argument_group("look of the frames"), LOOK, {**TYPES, "N": count})
    add_options(parser, "--overwrite  replace presses that are there")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    worlds = made_worlds()
    out, look = arguments.out, worlds.Appearance(**of_fields(arguments, worlds.Appearance))
    presses = worlds.PressPlan(**of_fields(arguments, worlds.PressPlan), appearance=look).presses()

    def tell(done: int) -> None:
        if sys.stderr.isatty() and not VOICE.quiet:
            end = "\n" if done == len(presses) else ""
            print(f"\rsimulate: {done} of {len(presses)}", end=end, file=sys.stderr, flush=True)

    made = worlds.write_presses(presses, out, tell, overwrite=arguments.overwrite)
    if arguments.json:
        print_json({"folder": str(out), "presses": made})
        return 0
    width = max(map(len, presses))
    print(f"{'press':<{width}} {'frames':>6} {'A_c0, mm2':>10} {'CASR, mm2/N':>12}   (truth)")
    for press in made:
        area, rate = press["initial_area_mm2"], press["casr_mm2_per_n"]
        print(f"{press['press']:<{width}} {press['frames']:>6} {area:>10.2f} {rate:>12.3f}")
    print(f"{len(made)} presses in {out}; score them with: casr score {out}")
    return 0
