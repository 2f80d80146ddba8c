"""Options as tables, those that several commands share, and what they set."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.cli import values
from casr.command_line import Group
from casr.errors import SettingError
from casr.terminal import note

if TYPE_CHECKING:
    from casr.flow.region import Region
    from casr.frames import FrameSequence
    from casr.pins import PinSettings
    from casr.scored import ScoreSettings

PAPER_STOP_N = 7.0
Row = tuple[str, Any, Any, str]
"""Option and, where it has another name, the field it sets; its kind or choices, None for a switch; default; help."""

# fmt: off
PATH_HELP = "a folder of images, a TIFF, AVI, MP4 or .npy file, or a press folder (frames, force.csv, camera.toml)"
FILES: tuple[Row, ...] = (
    ("--force", values.FILE, None,
     "force log, CSV: force_n (or force_mn, force_kgf, ...), frame_index; time_s, frame_time_s if known"),
    ("--force-column column", values.NAME, "force_n", "column of the log to take (default %(default)s)"),
    ("--force-rule", values.FORCE_RULES, "exposure",
     "force of a frame: at its exposure, or the mean of the rows that carry its index, as the paper has it "
     "(default %(default)s)"),
    ("--camera", values.FILE, None,
     "camera.toml (default: in the press folder, else in the folder above it); without one areas are in px²"),
)
ENGINE: Row = ("--engine", values.Engines(), "pin-affine", "motion estimate (default %(default)s)")
THRESHOLD: Row = (
    "--threshold-px", values.PIXELS, 2.0,
    "a pin that moved farther from rest is in contact: for the rules hexagon and paper, and to find first contact "
    "without a force log (default %(default)s)",
)
START: Row = ("--start-n force_start_n", values.NEWTON, 0.5, "force of first contact, N (default %(default)s)")
TARE: Row = (
    "--no-tare tare", None, True, "take forces as logged; else their level at rest before contact is taken off",
)
LAG: tuple[Row, ...] = (
    ("--camera-lag camera_lag_s", values.LAG, 0.0, "the frames were taken so long before their times in the force log"),
    ("--correct-lag", None, False,
     "find that lag, from when the pins begin to move and the force to rise, and take it off"),
)
METHOD: tuple[Row, ...] = (
    ("--quantity", values.QUANTITIES, "front",
     "which area is the result: front, the contact, whose edge is followed in every frame, or skin, that of the first "
     "contact as the flow stretches it, as in the paper; the other stands beside it (default %(default)s)"),
    ("--domes", values.FOLDER, None, "tables of your own domes, beside those that come with casr"),
    ENGINE,
    ("--area area_rule", values.AREA_RULES, "edge", "initial area (default %(default)s)"),
    ("--law area_law", values.AREA_LAWS, "ode",
     "area growth: ode, exp(sum of log growth), or paper, eq. (1) as printed (default %(default)s)"),
    ("--rate rate_rule", values.RATE_RULES, "power",
     "CASR: power, the mean rate from --start-n to --stop-n on a power law through the areas; slope of area on force; "
     "or paper, eq. (2) as printed (default %(default)s)"),
    THRESHOLD,
    ("--region", values.CIRCLE, None,
     "contact circle, px, or image, for dense engines: growth of skin is the mean divergence of the whole image "
     "(default: found from the pins that moved)"),
    START,
    ("--stop-n force_stop_n", values.NEWTON, None,
     f"force to stop at, N (default: the highest; the mean rate goes to {PAPER_STOP_N:g})"),
    TARE,
)
PINS: tuple[Row, ...] = (
    ("--dark-pins", None, False, "pins are darker than the skin (default: brighter)"),
    ("--contrast", values.GREY, None,
     "grey levels, of 255, that a pin stands out from its surroundings at least (default: 12, more in noise)"),
    ("--min-area min_area_px", values.PX2, None, "smallest area of a pin, px² (default: by the pitch)"),
    ("--pitch pitch_px", values.PIXELS, None,
     "distance from pin to pin, px (default: found; give it where pins are missed)"),
    ("--expect-pins", values.AT_LEAST_1, None,
     "how many pins the sensor has: another count is a note, one more than a quarter off an error"),
)
# fmt: on


def add_options(group: Group, *rows: Row) -> None:
    """An option for each row of a table."""
    for names, takes, default, words in rows:
        how: dict[str, Any] = dict(zip(("dest",), names.split()[1:], strict=False))
        if takes is None:
            how |= {"action": "store_false" if default else "store_true"}
        else:
            how |= (
                {"metavar": takes.metavar, "type": takes.read}
                if isinstance(takes, values.Kind)
                else {"choices": takes, "type": type(default)}
            )
            how |= {"default": default}
        group.add_argument(*names.split()[0].split(","), help=words, **how)


def add_frames(parser: argparse.ArgumentParser, help: str = PATH_HELP) -> None:
    """The frames, and the files that go with them."""
    parser.add_argument("path", type=Path, metavar="PATH", help=help)
    add_options(parser, *FILES)


def add_method(parser: argparse.ArgumentParser) -> Group:
    """How a press is scored; the group of these options."""
    method = parser.add_argument_group("method")
    add_options(method, *METHOD)
    add_options(parser.add_argument_group("pins"), *PINS)
    return method


def of_fields(arguments: argparse.Namespace, settings: type) -> dict[str, Any]:
    """What the options say of the fields of a settings dataclass."""
    names = [field.name for field in fields(settings)]
    return {name: getattr(arguments, name) for name in names if hasattr(arguments, name)}


def pin_settings(arguments: argparse.Namespace) -> PinSettings:
    """What the options say of the pins."""
    from casr.pins import PinSettings

    return PinSettings(**of_fields(arguments, PinSettings))


def check_forces(arguments: argparse.Namespace) -> tuple[float, float]:
    """The forces that the mean rate is taken between, N. SettingError where scoring would stop before it starts."""
    start_n, stop_n = arguments.force_start_n, arguments.force_stop_n or PAPER_STOP_N
    if stop_n <= start_n:
        raise SettingError(
            "--stop-n", wanted=f"more than --start-n, {start_n:g} N", found=f"{stop_n:g} N",
            do="Correct one of the two.",
        )  # fmt: skip
    return start_n, stop_n


def score_settings(arguments: argparse.Namespace) -> ScoreSettings:
    """The settings that the options ask for. SettingError as `check_forces`."""
    window_n = check_forces(arguments)
    from casr.flow.estimate import FlowSettings
    from casr.scored import WHOLE_IMAGE, ScoreSettings

    flow = FlowSettings(engine=arguments.engine, pins=pin_settings(arguments))
    region = arguments.region if arguments.region == WHOLE_IMAGE else region_of(arguments)
    asked = of_fields(arguments, ScoreSettings) | {"flow": flow, "region": region, "rate_window_n": window_n}
    return ScoreSettings(**asked)


def region_of(arguments: argparse.Namespace) -> Region | None:
    """The circle that was asked for."""
    from casr.flow.region import Region

    return Region.parse(arguments.region) if arguments.region is not None else None


def files_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The files that go with the frames, as `open_frames` takes them."""
    return {name: getattr(arguments, name) for name in ("force", "camera", "column", "force_rule")}


def open_sequence(arguments: argparse.Namespace, path: Path | None = None) -> FrameSequence:
    """The frames that were asked for. path : of one press of several."""
    from casr.frame_files import open_frames

    return open_frames(path or arguments.path, **files_of(arguments))


def say_notes(notes: Iterable[str], name: str = "") -> None:
    """One line on the error stream for each."""
    for text in notes:
        note(f"note: {name}: {text}" if name else f"note: {text}")
