"""``casr simulate``: presses whose flow, contact area and spread rate are known."""

from __future__ import annotations

import argparse
import itertools
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.cli.arguments import names, not_negative, numbers, positive
from casr.command_line import Commands, add_command, add_json, print_json, whole_number
from casr.terminal import VOICE

if TYPE_CHECKING:
    from casr.synthetic import PressSettings, World


WORLDS = ("tabulated", "tabulated-frictionless", "stick", "front")
_WORLD_HELP = (
    "tabulated: finite elements, the skin sticks (default); tabulated-frictionless: it slides; stick: the contact "
    "grows over the skin up to --stick-force-n, then stretches it; front: it never stretches it"
)


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "simulate",
        run,
        "Write simulated presses: frames, force log, camera, and the truth they were made from.",
        "One folder per press, OUT/SPECIMEN_ANGLE_REPETITION, with frames.tif, force.csv, camera.toml and truth.json. "
        "The same options give the same bytes. Example: casr simulate presses --specimens S1,S3 --repetitions 3",
    )
    parser.add_argument("out", type=Path, metavar="OUT", help="folder to write to")
    presses = parser.add_argument_group("presses")
    presses.add_argument(
        "--specimens", type=names, default=("S1", "S3", "S5", "S2"), metavar="NAMES",
        help="specimens of the paper, S1 to S5 (default S1,S3,S5,S2)",
    )  # fmt: skip
    presses.add_argument("--angles", type=numbers, default=(0.0, 30.0, 45.0), metavar="DEGREES", help="default 0,30,45")
    presses.add_argument(
        "--repetitions", type=whole_number, default=10, metavar="N", help="of each specimen and angle (default 10)"
    )
    presses.add_argument("--force-max-n", type=positive, default=7.0, metavar="N", help="peak force, N (default 7)")
    presses.add_argument("--world", choices=WORLDS, default=WORLDS[0], help=_WORLD_HELP)
    presses.add_argument(
        "--stick-force-n", type=positive, metavar="N",
        help="with --world stick: force from which on the contact is a piece of skin (default 0.43)",
    )  # fmt: skip
    presses.add_argument(
        "--scatter", choices=("realistic", "none"), default="realistic",
        help="how presses of one kind differ: depth, stiffness and angle of a mounting; area, resting force and delay "
        "of a press (default %(default)s)",
    )  # fmt: skip
    presses.add_argument(
        "--mounting", type=_count, default=0, metavar="N", help="another mounting of sensor and specimens (default 0)"
    )
    presses.add_argument("--seed", type=int, default=0, metavar="N", help="another sensor and other draws (default 0)")
    look = parser.add_argument_group("look of the frames")
    for name, default, words in (
        ("noise", 2.0, "read noise, grey levels"), ("texture", 0.0, "texture that moves with the skin, grey levels"),
        ("dirt", 0.0, "dirt that stays where it is, grey levels"),
    ):  # fmt: skip
        look.add_argument(
            f"--{name}-grey", type=not_negative, default=default, metavar="RMS", help=f"{words} (default {default:g})"
        )
    look.add_argument("--glare", type=_count, default=0, metavar="N", help="reflections (default 0)")
    look.add_argument("--missing-pins", type=_count, default=0, metavar="N", help="pins broken off (default 0)")
    parser.add_argument("--overwrite", action="store_true", help="replace presses that are there")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from casr.synthetic import simulate_press, write_press

    planned = _planned(arguments)
    if not arguments.overwrite:
        _refuse_existing(arguments.out, planned)
    made = []
    for done, (name, settings) in enumerate(planned.items()):
        _say_progress(done, len(planned))
        press = simulate_press(settings)
        folder = write_press(press, arguments.out / name, overwrite=arguments.overwrite)
        truth = press.truth
        made.append({
            "press": name, "folder": str(folder), "frames": len(press.frames),
            "initial_area_mm2": float(truth.area_mm2[truth.loading_frames[0]]),
            "casr_mm2_per_n": truth.casr_power_mm2_per_n,
        })  # fmt: skip
    _say_progress(len(planned), len(planned))
    if arguments.json:
        print_json({"folder": str(arguments.out), "presses": made})
    else:
        _print(made, arguments.out)
    return 0


def _planned(arguments: argparse.Namespace) -> dict[str, PressSettings]:
    """Name to settings of every press."""
    from casr.specimens import SPECIMENS
    from casr.synthetic import REALISTIC, Appearance, PressSettings, Scatter, TimelineSettings

    _check(arguments, SPECIMENS, start_n=TimelineSettings.start_n)
    world = _world(arguments)
    scatter = REALISTIC if arguments.scatter == "realistic" else Scatter()
    appearance = Appearance(
        noise_grey=arguments.noise_grey, texture_grey=arguments.texture_grey, dirt_grey=arguments.dirt_grey,
        n_glare=arguments.glare, n_missing=arguments.missing_pins,
    )  # fmt: skip
    timeline = TimelineSettings(peak_n=arguments.force_max_n)
    every = itertools.product(arguments.specimens, arguments.angles, range(arguments.repetitions))
    return {
        f"{specimen}_{angle:02g}deg_{repetition + 1:02d}": PressSettings(
            stiffness_n_per_mm=SPECIMENS[specimen], angle_deg=angle, repetition=repetition, seed=arguments.seed,
            mounting=arguments.mounting, world=world, scatter=scatter, appearance=appearance, timeline=timeline,
        )
        for specimen, angle, repetition in every
    }  # fmt: skip


def _world(arguments: argparse.Namespace) -> World:
    from casr.errors import SettingError
    from casr.synthetic import ContactWorld, TabulatedWorld

    if arguments.stick_force_n is not None and arguments.world != "stick":
        raise SettingError(
            "--stick-force-n", wanted="it with --world stick", found=f"--world {arguments.world}",
            do="Leave it out, or simulate that world.",
        )  # fmt: skip
    if arguments.world == "front":
        return ContactWorld(stick_force_n=arguments.force_max_n)
    if arguments.world == "stick":
        return (
            ContactWorld() if arguments.stick_force_n is None else ContactWorld(stick_force_n=arguments.stick_force_n)
        )
    return TabulatedWorld(friction="frictionless" if arguments.world == "tabulated-frictionless" else "stick")


def _check(arguments: argparse.Namespace, known: dict[str, float], start_n: float) -> None:
    from casr.errors import SettingError

    unknown = [name for name in arguments.specimens if name not in known]
    if unknown:
        raise SettingError(
            "--specimens", wanted=f"specimens of the paper, {', '.join(known)}", found=", ".join(unknown),
            do="Check the spelling.",
        )  # fmt: skip
    if not all(0 <= angle < 90 for angle in arguments.angles):
        raise SettingError(
            "--angles", wanted="degrees from 0 to below 90", found=", ".join(f"{a:g}" for a in arguments.angles),
            do="The paper presses at 0, 30 and 45.",
        )  # fmt: skip
    if arguments.force_max_n <= start_n:
        raise SettingError(
            "--force-max-n", wanted=f"more than the force of first contact, {start_n:g} N",
            found=f"{arguments.force_max_n:g} N", do="The paper presses up to 7 N.",
        )  # fmt: skip


def _refuse_existing(out: Path, planned: dict[str, PressSettings]) -> None:
    from casr.errors import SettingError

    there = [name for name in planned if (out / name).exists()]
    if there:
        raise SettingError(
            out, wanted="no press of the same name", found=f"{len(there)} of them, the first {there[0]}",
            do="Choose another folder, or replace them with --overwrite.",
        )  # fmt: skip


def _print(made: list[dict[str, Any]], out: Path) -> None:
    width = max(len(press["press"]) for press in made)
    print(f"{'press':<{width}} {'frames':>6} {'A_c0, mm2':>10} {'CASR, mm2/N':>12}   (truth)")
    for press in made:
        area, rate = press["initial_area_mm2"], press["casr_mm2_per_n"]
        print(f"{press['press']:<{width}} {press['frames']:>6} {area:>10.2f} {rate:>12.3f}")
    print(f"{len(made)} presses in {out}; score them with: casr score {out}")


def _say_progress(done: int, total: int) -> None:
    if sys.stderr.isatty() and not VOICE.quiet:
        print(f"\rsimulate: {done} of {total}", end="\n" if done == total else "", file=sys.stderr, flush=True)


def _count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number from 0, but found {text!r}")
    return int(text)
