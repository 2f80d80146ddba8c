"""Arguments that several commands share, and the values they accept."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Group, whole_number
from casr.plugins import plugins
from casr.terminal import note

if TYPE_CHECKING:
    from casr.frames import FrameSequence
    from casr.pins import PinSettings

ENGINES = ("pin-affine", "horn-schunck", "dis")
AREA_RULES = ("edge", "hexagon", "circle", "paper")
FORCE_RULES = ("exposure", "mean")
"Written out once more, because the modules that own them load NumPy; a test compares them."


class Engines:
    """Names of engines for argparse; those of other installed packages are looked up when ours do not do."""

    def __contains__(self, name: object) -> bool:
        return name in ENGINES or name in tuple(self)

    def __iter__(self) -> Iterator[str]:
        yield from ENGINES
        yield from (plugin.name for plugin in plugins("casr.flow_engines") if plugin.name not in ENGINES)


def add_frames(parser: argparse.ArgumentParser, metavar: str = "PATH", help: str = "") -> None:
    """The frames, and the files that go with them."""
    kinds = "a folder of images, a TIFF, AVI, MP4 or .npy file, or a press folder (frames, force.csv, camera.toml)"
    parser.add_argument("path", type=Path, metavar=metavar, help=help or kinds)
    columns = "force log, CSV: force_n (or force_mn, force_kgf, ...), frame_index; time_s, frame_time_s if known"
    parser.add_argument("--force", type=Path, metavar="FILE", help=columns)
    parser.add_argument(
        "--force-column", default="force_n", metavar="NAME", help="column of the log to take (default %(default)s)"
    )
    parser.add_argument(
        "--force-rule", choices=FORCE_RULES, default=FORCE_RULES[0],
        help="force of a frame: at its exposure, or the mean of the rows that carry its index, as the paper has it "
        "(default %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--camera", type=Path, metavar="FILE",
        help="camera.toml (default: in the press folder, else in the folder above it); without one areas are in px²",
    )  # fmt: skip


def add_tare(parser: Group) -> None:
    """Whether forces count from where the sensor rests."""
    parser.add_argument(
        "--no-tare",
        action="store_true",
        help="take forces as logged; else their level at rest before contact is taken off",
    )


def add_engine(parser: Group) -> None:
    """How motion between frames is measured."""
    parser.add_argument("--engine", choices=Engines(), default=ENGINES[0], help="motion estimate (default %(default)s)")


def add_threshold(parser: Group) -> None:
    """Which pins count as moved."""
    parser.add_argument(
        "--threshold-px", type=positive, default=2.0, metavar="PX",
        help="a pin that moved farther from rest is in contact: for the rules hexagon and paper, and to find first "
        "contact without a force log (default %(default)s)",
    )  # fmt: skip


def add_pins(parser: Group) -> None:
    """How pins are found; what is not given follows from the frames."""
    parser.add_argument("--dark-pins", action="store_true", help="pins are darker than the skin (default: brighter)")
    parser.add_argument(
        "--contrast", type=positive, metavar="GREY",
        help="grey levels, of 255, that a pin stands out from its surroundings at least (default: 12, more in noise)",
    )  # fmt: skip
    parser.add_argument(
        "--min-area", type=positive, metavar="PX2", help="smallest area of a pin, px² (default: by the pitch)"
    )
    parser.add_argument(
        "--pitch", type=positive, metavar="PX",
        help="distance from pin to pin, px (default: found; give it where pins are missed)",
    )  # fmt: skip
    parser.add_argument(
        "--expect-pins", type=whole_number, metavar="N",
        help="how many pins the sensor has: another count is a note, one more than a quarter off an error",
    )  # fmt: skip


def pin_settings(arguments: argparse.Namespace) -> PinSettings:
    """What the options say of the pins."""
    from casr.pins import PinSettings

    return PinSettings(
        dark_pins=arguments.dark_pins,
        contrast=arguments.contrast,
        min_area_px=arguments.min_area,
        pitch_px=arguments.pitch,
        expect_pins=arguments.expect_pins,
    )


def open_sequence(arguments: argparse.Namespace, path: Path | None = None) -> FrameSequence:
    """The frames that were asked for."""
    from casr.frame_files import open_frames

    return open_frames(
        path or arguments.path,
        force=arguments.force,
        camera=arguments.camera,
        column=arguments.force_column,
        force_rule=arguments.force_rule,
    )


def say_notes(notes: Iterable[str], name: str = "") -> None:
    """One line on the error stream for each."""
    for text in notes:
        note(f"note: {name}: {text}" if name else f"note: {text}")


def frame_pair(text: str) -> tuple[int, int]:
    """``"0,12"``: two different frame indices."""
    first, second = numbers(text, 2)
    if first == second or min(first, second) < 0 or not (first.is_integer() and second.is_integer()):
        raise argparse.ArgumentTypeError(
            f"expected two different frame numbers from 0, such as 0,12, but found {text!r}"
        )
    return int(first), int(second)


def html_file(text: str) -> Path:
    """A file name that ends in .html; pages of several presses go into a folder named without it."""
    if not text.lower().endswith(".html"):
        raise argparse.ArgumentTypeError(f"expected a file name that ends in .html, but found {text!r}")
    return Path(text)


def names(text: str) -> tuple[str, ...]:
    """Names with commas between them, each once."""
    return tuple(dict.fromkeys(part.strip() for part in text.split(",")))


def csv_file(text: str) -> Path:
    """A file name that ends in .csv."""
    if not text.lower().endswith(".csv"):
        raise argparse.ArgumentTypeError(f"expected a file name that ends in .csv, but found {text!r}")
    return Path(text)


def numbers(text: str, count: int | None = None) -> tuple[float, ...]:
    """Finite numbers between commas."""
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if not found or (count is not None and len(found) != count) or any(x - x != 0 for x in found):
        wanted = f"{count} numbers" if count else "numbers"
        raise argparse.ArgumentTypeError(f"expected {wanted} with commas between them, but found {text!r}")
    return found


def positive(text: str) -> float:
    """A number above 0."""
    (value,) = numbers(text, 1)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"expected a number above 0, but found {text!r}")
    return value


def number(text: str) -> float:
    """A finite number."""
    return numbers(text, 1)[0]


def not_negative(text: str) -> float:
    """A number from 0."""
    (value,) = numbers(text, 1)
    if value < 0:
        raise argparse.ArgumentTypeError(f"expected a number from 0, but found {text!r}")
    return value
