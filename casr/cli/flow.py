"""``casr flow``: divergence of the contact region, between two frames or step by step."""

from __future__ import annotations

import argparse
import itertools
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.cli.arguments import (
    add_engine,
    add_frames,
    add_pins,
    frame_pair,
    open_sequence,
    pin_settings,
    say_notes,
)
from casr.command_line import Commands, add_command, add_json, print_json

if TYPE_CHECKING:
    from casr.flow.estimate import FlowSettings
    from casr.flow.region import Region
    from casr.frames import FrameSequence
    from casr.overlays import Picture


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "flow",
        run,
        "Compute divergence and growth of a region of skin from frame to frame. This needs no force log.",
        "The region is a circle in the first frame and moves with the skin. Divergence is its mean over the region; "
        "log growth is the logarithm of the factor by which the region's area grows. "
        "Example: casr flow frames --frames 19,20 --figures pictures",
    )
    add_frames(parser)
    parser.add_argument(
        "--frames", type=frame_pair, metavar="I,J", help="use the steps from frame I to frame J (default: all)"
    )
    add_engine(parser)
    parser.add_argument(
        "--region", metavar="X,Y,R", help="circle in the first frame, px (default: half as wide as the field of pins)"
    )
    add_pins(parser.add_argument_group("pins"))
    add_json(parser)
    parser.add_argument(
        "--figures",
        type=Path,
        metavar="DIR",
        help="write a picture as PNG and SVG: ways of the pins, or the dense flow of the step that grows most",
    )


def run(arguments: argparse.Namespace) -> int:
    from casr.flow.estimate import FlowSettings
    from casr.flow.region import Region

    sequence = open_sequence(arguments)
    frames = _frames(sequence, arguments.frames)
    flow = FlowSettings(engine=arguments.engine, pins=pin_settings(arguments))
    asked = Region.parse(arguments.region) if arguments.region else None
    region = _region(sequence[frames[0]], asked, flow)
    steps, regions = _steps(sequence, frames, region, flow)
    if arguments.json:
        centre = [float(x) for x in region.centre_px]
        print_json({"name": sequence.name, "engine": arguments.engine, "region_centre_px": centre, "steps": steps})
    else:
        _print(sequence.name, arguments.engine, region, steps)
    if arguments.figures:
        from casr.cli.pages import write_pictures

        write_pictures(arguments.figures, [_picture(sequence, steps, regions, flow)])
    return 0


def _frames(sequence: FrameSequence, asked: tuple[int, int] | None) -> list[int]:
    """Every frame between the two, which may run backwards."""
    from casr.errors import FramesError

    first, last = asked or (0, len(sequence) - 1)
    if max(first, last) >= len(sequence):
        raise FramesError(
            sequence.name, wanted=f"frames from 0 to {len(sequence) - 1}", found=f"{first},{last}",
            do="Frames are counted from 0.",
        )  # fmt: skip
    forward = 1 if last > first else -1
    return list(range(first, last + forward, forward))


def _region(image: Any, asked: Region | None, flow: FlowSettings) -> Region:
    """The region asked for, or a circle about the middle of the pins, half as wide as they reach."""
    import numpy as np

    from casr.flow.pin_engine import need_pins_inside
    from casr.flow.region import Region
    from casr.pins import detect_pins, pins_in_doubt

    if asked is not None and flow.engine != "pin-affine":
        return asked
    pins_px = detect_pins(image, flow.pins).centroids_px
    say_notes(pins_in_doubt(pins_px, flow.pins.expect_pins))
    if asked is not None:
        need_pins_inside(asked, pins_px)
        return asked
    centre = (pins_px.min(axis=0) + pins_px.max(axis=0)) / 2
    return Region.circle(float(centre[0]), float(centre[1]), float(np.hypot(*(pins_px - centre).T).max()) / 2)


def _steps(
    sequence: FrameSequence, frames: list[int], region: Region, flow: FlowSettings
) -> tuple[list[dict[str, Any]], list[Region]]:
    """Facts of each step, and the region before it; a frame in which the pins cannot be told is left out."""
    from casr.errors import PinsError, said_of
    from casr.flow.estimate import FlowTracker
    from casr.flow.step import MOST_BAD_FRAMES, notes_by_frame

    tracker = FlowTracker(flow)
    tracker.start(sequence[frames[0]], region)
    good, found, n_bad = [frames[0]], [], 0
    for after in frames[1:]:
        image = sequence[after]
        with said_of(f"{sequence.name}, frame {after}"):
            try:
                found.append(tracker.step(image))
            except PinsError as trouble:
                n_bad += 1
                if n_bad > MOST_BAD_FRAMES or (after == frames[-1] and not found):
                    raise
                say_notes([f"frame {after} is left out: {trouble}"])
                continue
        n_bad = 0
        good.append(after)
    say_notes(notes_by_frame(good[1:], found))
    sums = itertools.accumulate(step.log_growth for step in found)
    steps = [
        {
            "from": before, "to": after, "divergence": float(step.divergence), "log_growth": float(step.log_growth),
            "sum": float(total), "used": int(step.n),
        }
        for (before, after), step, total in zip(itertools.pairwise(good), found, sums, strict=True)
    ]  # fmt: skip
    return steps, [region, *(step.region for step in found)]


def _print(name: str, engine: str, region: Region, steps: list[dict[str, Any]]) -> None:
    import math

    x_px, y_px = region.centre_px
    radius_px = math.sqrt(region.area_px2 / math.pi)
    used = {"pin-affine": "pins", "horn-schunck": "pixels", "dis": "pixels"}.get(engine, "used")
    print(f"{name}: {engine}, region of radius {radius_px:.1f} px about ({x_px:.1f}, {y_px:.1f})")
    print(f"{'from':>6} {'to':>6} {'divergence':>11} {'log growth':>11} {'sum':>9} {used:>7}")
    for step in steps:
        print(
            f"{step['from']:>6} {step['to']:>6} {step['divergence']:>11.5f} {step['log_growth']:>11.5f} "
            f"{step['sum']:>9.4f} {step['used']:>7}"
        )
    print(f"area of the region at the end: {math.exp(steps[-1]['sum']):.4f} times that at first")


def _picture(
    sequence: FrameSequence, steps: list[dict[str, Any]], regions: list[Region], flow: FlowSettings
) -> Picture:
    """Of all steps for pins, which an engine of another package may use or not; of the step that grows most else."""
    from casr.overlays import flow_picture, pin_ways, spreading_picture

    if flow.engine not in ("dis", "horn-schunck"):
        frames = [steps[0]["from"], *(step["to"] for step in steps)]
        ways, span = pin_ways(sequence, frames, flow.pins), f"frames {frames[0]} to {frames[-1]}"
        return spreading_picture(sequence[frames[0]], *ways, regions[0].polygon_px, span)
    place = max(range(len(steps)), key=lambda i: abs(steps[i]["log_growth"]))
    before, after = steps[place]["from"], steps[place]["to"]
    if flow.engine == "dis":
        from casr.flow.dis import dis_flow

        field = dis_flow(sequence[before], sequence[after])
    else:
        from casr.flow.horn_schunck import horn_schunck

        field = horn_schunck(sequence[before], sequence[after])
    return flow_picture(sequence[before], field, regions[place].polygon_px, f"frames {before} to {after}")
