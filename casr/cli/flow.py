"""``casr flow``: divergence of the contact region, between two frames or step by step."""

from __future__ import annotations

import argparse
import math

from casr.cli import arguments as shared
from casr.command_line import Commands, add_command, add_json, print_json

FRAMES = "--frames I,J  use the steps from frame I to frame J (default: all)"
REGION = "--region X,Y,R  circle in the first frame, px (default: half as wide as the field of pins)"
FIGURES = """
--figures DIR  write a picture as PNG and SVG: ways of the pins, or the dense flow of the step that grows most
"""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "flow", run,
        "Compute divergence and growth of a region of skin from frame to frame. This needs no force log.",
        "The region is a circle in the first frame and moves with the skin. Divergence is its mean over the region; "
        "log growth is the logarithm of the factor by which the region's area grows. "
        "Example: casr flow frames --frames 19,20 --figures pictures",
    )  # fmt: skip
    shared.add_frames(parser)
    shared.add_shared(parser, FRAMES, shared.ENGINE, REGION)
    shared.add_shared(parser.add_argument_group("pins"), shared.PINS)
    add_json(parser)
    shared.add_shared(parser, FIGURES)


def run(arguments: argparse.Namespace) -> int:
    from casr.flow.estimate import FlowSettings, follow_region

    sequence, engine = shared.open_sequence(arguments), arguments.engine
    settings = FlowSettings(engine=engine, pins=shared.pin_settings(arguments))
    asked = shared.region_of(arguments)
    followed = follow_region(sequence, settings, arguments.frames, asked, say=lambda note: shared.say_notes([note]))
    region, rows = followed.regions[0], followed.rows()
    x_px, y_px = map(float, region.centre_px)
    if arguments.json:
        print_json({"name": sequence.name, "engine": engine, "region_centre_px": [x_px, y_px], "steps": rows})
    else:
        radius_px = math.sqrt(region.area_px2 / math.pi)
        used = {"pin-affine": "pins", "horn-schunck": "pixels", "dis": "pixels"}.get(engine, "used")
        print(f"{sequence.name}: {engine}, region of radius {radius_px:.1f} px about ({x_px:.1f}, {y_px:.1f})")
        print(f"{'from':>6} {'to':>6} {'divergence':>11} {'log growth':>11} {'sum':>9} {used:>7}")
        for row in rows:
            print(f"{row['from']:>6} {row['to']:>6} {row['divergence']:>11.5f} {row['log_growth']:>11.5f}", end=" ")
            print(f"{row['sum']:>9.4f} {row['used']:>7}")
        print(f"area of the region at the end: {math.exp(rows[-1]['sum']):.4f} times that at first")
    if arguments.figures:
        from casr.overlays import followed_picture
        from casr.press_files import write_pictures

        write_pictures(arguments.figures, [followed_picture(sequence, followed)])
    return 0
