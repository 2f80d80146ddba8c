"""``casr area``: the initial contact area by every rule, from two frames."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.cli.arguments import (
    AREA_RULES,
    add_frames,
    add_pins,
    add_tare,
    add_threshold,
    frame_pair,
    open_sequence,
    pin_settings,
    positive,
    say_notes,
)
from casr.command_line import Commands, add_command, add_json, print_json

if TYPE_CHECKING:
    from casr.contact_area import InitialArea
    from casr.frames import FrameSequence


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "area",
        run,
        "Compute the initial contact area by every rule from the rest frame and the first-contact frame.",
        "Exit status 1: none of the rules finds a contact. Example: casr area press --frames 0,20",
    )
    add_frames(parser)
    parser.add_argument(
        "--frames", type=frame_pair, metavar="I,J",
        help="rest and first-contact frame (default: from the force log; without one frame 0 and the first in which "
        "three pins have moved)",
    )  # fmt: skip
    parser.add_argument(
        "--start-n", type=positive, default=0.5, metavar="N", help="force of first contact, N (default %(default)s)"
    )
    add_tare(parser)
    add_threshold(parser)
    add_pins(parser.add_argument_group("pins"))
    add_json(parser)
    parser.add_argument("--figures", type=Path, metavar="DIR", help="write the pictures as SVG")


def run(arguments: argparse.Namespace) -> int:
    from casr.contact_area import AS_PRINTED, initial_area
    from casr.errors import AreaError, NoContactError
    from casr.pins import PinTracker, pins_in_doubt
    from casr.scored import NO_SCALE

    sequence = open_sequence(arguments)
    rest_frame, contact_frame, notes = _frames(sequence, arguments)
    tracker = PinTracker(pin_settings(arguments))
    rest = tracker.start(sequence[rest_frame])
    contact_px = tracker.step(sequence[contact_frame])
    doubts = pins_in_doubt(rest.centroids_px, arguments.expect_pins)
    say_notes((*([] if sequence.camera else [NO_SCALE]), *notes, *rest.notes, *doubts, *tracker.notes))
    found: dict[str, InitialArea | None] = {}
    why: dict[str, str] = {}
    for rule in (*AREA_RULES, AS_PRINTED):
        try:
            found[rule] = initial_area(
                rest, contact_px, camera=sequence.camera, rule=rule, threshold_px=arguments.threshold_px
            )
        except (AreaError, NoContactError) as error:
            found[rule] = None
            why[rule] = "no contact" if isinstance(error, NoContactError) else "no contact is that large"
            say_notes([str(error)], rule)
    report = {
        "name": sequence.name, "rest_frame": rest_frame, "contact_frame": contact_frame, "pins": len(rest),
        "areas": {rule: _facts(area) for rule, area in found.items()},
    }  # fmt: skip
    if arguments.json:
        print_json(report)
    else:
        _print(report, why)
    chosen = next(filter(None, found.values()), None)
    if chosen and arguments.figures:
        from casr.cli.pages import write_pictures
        from casr.overlays import area_picture, pins_picture

        pins_px, image = rest.centroids_px, sequence[contact_frame]
        pictures = [
            pins_picture(sequence[rest_frame], pins_px, contact_px, chosen),
            area_picture(image, pins_px, contact_px, chosen),
        ]
        write_pictures(arguments.figures, pictures)
    return 0 if chosen else 1


def _frames(sequence: FrameSequence, arguments: argparse.Namespace) -> tuple[int, int, tuple[str, ...]]:
    from casr.errors import said_of
    from casr.frames import loading_phase
    from casr.press_forces import press_forces
    from casr.scored import ScoreSettings
    from casr.seen_loading import first_touch

    if arguments.frames:
        return (*arguments.frames, ())
    with said_of(sequence.name):
        if sequence.force_n is None:
            contact = first_touch(sequence, arguments.threshold_px, pin_settings(arguments))
            return 0, contact, (f"no force log: the pins are touched from frame {contact} on; others with --frames",)
        settings = ScoreSettings(force_start_n=arguments.start_n, tare=not arguments.no_tare)
        forces = press_forces(sequence, settings)
        phase = loading_phase(forces.force_n, start_n=arguments.start_n)
    return phase.rest, int(phase.frames[0]), (*sequence.notes, *forces.notes, *phase.notes)


def _facts(area: InitialArea | None) -> dict[str, Any] | None:
    if area is None:
        return None
    return {
        "area_mm2": area.area_mm2, "area_px2": area.area_px2, "selected": len(area.selected),
        "relative_sd": area.relative_sd, "saturated": bool(area.saturated), "notes": list(area.notes),
    }  # fmt: skip


def _print(report: dict[str, Any], why: dict[str, str]) -> None:
    print(f"{report['name']}: rest frame {report['rest_frame']}, first contact {report['contact_frame']}", end="")
    print(f", {report['pins']} pins")
    print(f"  {'rule':<10} {'mm2':>10} {'px2':>10} {'pins':>5}")
    for rule, area in report["areas"].items():
        if area is None:
            print(f"  {rule:<10} {'-':>10} {'-':>10} {'-':>5}  {why[rule]}")
            continue
        mm2 = f"{area['area_mm2']:.4g}" if area["area_mm2"] is not None else "-"
        remark = "  saturated" if area["saturated"] else ""
        if area["relative_sd"] is not None:
            remark += f"  noise of the pins moves it by {100 * area['relative_sd']:.1f} % (1 sd)"
        print(f"  {rule:<10} {mm2:>10} {area['area_px2']:>10.5g} {area['selected']:>5}{remark}")
        for note in area["notes"]:
            print(f"             {note}")
