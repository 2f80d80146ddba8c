"""``casr area``: the initial contact area by every rule, from two frames."""

from __future__ import annotations

import argparse

from casr.cli import arguments as shared
from casr.command_line import Commands, add_command, add_json, print_json
from casr.errors import NoContactError

FRAMES = """
--frames I,J  rest and first-contact frame (default: from the force log; without one frame 0 and the first in which
    three pins have moved)
"""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "area", run,
        "Compute the initial contact area by every rule from the rest frame and the first-contact frame.",
        "Exit status 1: none of the rules finds a contact. Example: casr area press --frames 0,20",
    )  # fmt: skip
    shared.add_frames(parser)
    shared.add_shared(parser, FRAMES, shared.START, shared.TARE, shared.THRESHOLD)
    shared.add_shared(parser.add_argument_group("pins"), shared.PINS)
    add_json(parser)
    shared.add_shared(parser, shared.FIGURES)


def run(arguments: argparse.Namespace) -> int:
    from casr.first_areas import first_areas
    from casr.flow.estimate import FlowSettings
    from casr.scored import ScoreSettings

    sequence, flow = shared.open_sequence(arguments), FlowSettings(pins=shared.pin_settings(arguments))
    settings = ScoreSettings(**shared.of_fields(arguments, ScoreSettings), flow=flow)
    found = first_areas(sequence, settings, arguments.frames)
    shared.say_notes(found.notes)
    why = {rule: error for rule, error in found.areas.items() if isinstance(error, Exception)}
    for rule, error in why.items():
        shared.say_notes([str(error)], rule)
    report = found.to_dict()
    if arguments.json:
        print_json(report)
    else:
        print(f"{found.name}: rest frame {found.rest_frame}, first contact {found.contact_frame}", end="")
        print(f", {len(found.rest)} pins\n  {'rule':<10} {'mm2':>10} {'px2':>10} {'pins':>5}")
        for rule, area in report["areas"].items():
            if area is None:
                no = "no contact" if isinstance(why[rule], NoContactError) else "no contact is that large"
                print(f"  {rule:<10} {'-':>10} {'-':>10} {'-':>5}  {no}")
                continue
            mm2 = f"{area['area_mm2']:.4g}" if area["area_mm2"] is not None else "-"
            remark = "  saturated" * area["saturated"]
            if area["relative_sd"] is not None:
                remark += f"  noise of the pins moves it by {100 * area['relative_sd']:.1f} % (1 sd)"
            print(f"  {rule:<10} {mm2:>10} {area['area_px2']:>10.5g} {area['selected']:>5}{remark}")
            for note in area["notes"]:
                print(f"             {note}")
    if found.first is not None and arguments.figures:
        from casr.overlays import area_picture, pins_picture
        from casr.press_files import write_pictures

        of = (found.rest.centroids_px, found.contact_px, found.first)
        rest, contact = pins_picture(sequence[found.rest_frame], *of), area_picture(sequence[found.contact_frame], *of)
        write_pictures(arguments.figures, [rest, contact])
    return int(found.first is None)
