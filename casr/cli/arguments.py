"""Options as tables: how a value is read, those that several commands share, and what they set."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Group, add_options, wanted, whole, whole_number
from casr.errors import SettingError
from casr.plugins import ENGINES, known_engines
from casr.terminal import note

if TYPE_CHECKING:
    from casr.flow.region import Region
    from casr.frames import FrameSequence
    from casr.pins import PinSettings
    from casr.scored import ScoreSettings


class Engines:
    """Names of engines for argparse; those of other installed packages are looked up when ours do not do."""

    def __contains__(self, name: object) -> bool:
        return name in ENGINES or name in known_engines()

    def __iter__(self) -> Iterator[str]:
        return iter(known_engines())


def _refused(what: str, text: str) -> argparse.ArgumentTypeError:
    return argparse.ArgumentTypeError(f"expected {what}, but found {text!r}")


def numbers(text: str, count: int | None = None) -> tuple[float, ...]:
    """Finite numbers between commas. ArgumentTypeError : others, or not ``count`` of them."""
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if not found or (count is not None and len(found) != count) or any(x - x != 0 for x in found):
        what = f"{count} numbers" if count else "numbers"
        raise _refused(f"{what} with commas between them", text)
    return found


def number(text: str) -> float:
    """A finite number."""
    return numbers(text, 1)[0]


def positive(text: str) -> float:
    """A number above 0. ArgumentTypeError : another."""
    if (value := number(text)) <= 0:
        raise _refused("a number above 0", text)
    return value


def not_negative(text: str) -> float:
    """A number from 0. ArgumentTypeError : another."""
    if (value := number(text)) < 0:
        raise _refused("a number from 0", text)
    return value


count = wanted("a whole number from 0", whole(0))


def frame_pair(text: str) -> tuple[int, int]:
    """``"0,12"``: two different frame indices. ArgumentTypeError : other text."""
    first, second = numbers(text, 2)
    if first == second or min(first, second) < 0 or not (first.is_integer() and second.is_integer()):
        raise _refused("two different frame numbers from 0, such as 0,12", text)
    return int(first), int(second)


def _grid(text: str) -> tuple[int, int] | None:
    columns, _, rows = text.lower().partition("x")
    return (int(columns), int(rows)) if columns.isdecimal() and rows.isdecimal() else None


grid = wanted("columns and rows such as 9x7", _grid)


def names(text: str) -> tuple[str, ...]:
    """Names with commas between them, each once."""
    return tuple(dict.fromkeys(part.strip() for part in text.split(",")))


def _file(suffix: str) -> Callable[[str], Path]:
    right = lambda text: Path(text) if text.lower().endswith(suffix) else None  # noqa: E731
    return wanted(f"a file name that ends in {suffix}", right)


TYPES: Mapping[str, Any] = {
    **dict.fromkeys(("N", "PX", "PX2", "MM", "GREY", "SECONDS", "HZ"), positive),
    "RMS": not_negative, "DEGREES": numbers, "NAMES": names, "I,J": frame_pair, "COLUMNSxROWS": grid,
    "FILE.html": _file(".html"), "FILE.csv": _file(".csv"), "FOLDER": str,
    **dict.fromkeys(("PICTURE", "PICTURES", "PRESS"), Path),
}  # fmt: skip
"What makes a value from its text, by the word that stands for it in the help."


PAPER_STOP_N = 7.0
PATH_HELP = "a folder of images, a TIFF, AVI, MP4 or .npy file, or a press folder (frames, force.csv, camera.toml)"
FILES = """
--force FILE  force log, CSV: force_n (or force_mn, force_kgf, ...), frame_index; time_s, frame_time_s, travel_mm if
    known
--force-column NAME = force_n  column of the log to take (default %(default)s)
--force-rule {exposure,mean} = exposure  force of a frame: at its exposure, or the mean of the rows that carry its
    index, as the paper has it (default %(default)s)
--camera FILE  camera.toml (default: in the press folder, else in the folder above it); without one areas are in px²
"""
ENGINE = "--engine NAME = pin-affine  motion estimate (default %(default)s)\n"
THRESHOLD = """
--threshold-px PX = 2.0  a pin that moved farther from rest is in contact: for the rules hexagon and paper, and to find
    first contact without a force log (default %(default)s)
"""
START = "--start-n N = 0.5  force of first contact, N (default %(default)s)\n"
TARE = "--no-tare  take forces as logged; else their level at rest before contact is taken off\n"
FIGURES = "--figures DIR  write the pictures as SVG\n"
LAG = "--camera-lag SECONDS  the frames were taken so long before their times in the force log\n"
METHOD = f"""
--quantity {{front,skin}} = front  which area is the result: front, the contact, whose edge is followed in every frame,
    or skin, that of the first contact as the flow stretches it, as in the paper; the other stands beside it
    (default %(default)s)
--domes FOLDER  tables of your own domes, beside those that come with casr
--specimen-height-mm MM  thickness of the specimen, for tables of it; those that come with casr are of 25 mm
{ENGINE}--area {{edge,hexagon,circle,paper}} = edge  initial area (default %(default)s)
--law {{ode,paper}} = ode  area growth: ode, exp(sum of log growth), or paper, eq. (1) as printed (default %(default)s)
--rate {{power,slope,paper}} = power  CASR: power, the mean rate from --start-n to --stop-n on a power law through the
    areas; slope of area on force; or paper, eq. (2) as printed (default %(default)s)
{THRESHOLD.strip()}
--region X,Y,R  contact circle, px, or image, for dense engines: growth of skin is the mean divergence of the whole
    image (default: found from the pins that moved)
{START}--stop-n N  force to stop at, N; a press that turns back at 80 %% of it or more ends at its highest (default: the
    highest; the mean rate goes to {PAPER_STOP_N:g})
{TARE}"""
PINS = """
--dark-pins  pins are darker than the skin (default: brighter)
--contrast GREY  grey levels, of 255, that a pin stands out from its surroundings at least (default: 12, more in noise)
--min-area PX2  smallest area of a pin, px² (default: by the pitch)
--pitch PX  distance from pin to pin, px (default: found; give it where pins are missed)
--expect-pins N  how many pins the sensor has: another count is a note, one more than a quarter off an error
"""
OPTION_OF = {
    "area_rule": "area", "area_law": "law", "rate_rule": "rate", "force_start_n": "start_n", "force_stop_n": "stop_n",
    "camera_lag_s": "camera_lag", "min_area_px": "min_area", "pitch_px": "pitch", "n_glare": "glare",
    "n_missing": "missing_pins", "column": "force_column",
}  # fmt: skip
"Fields of settings to the options that set them, where their names differ."
MORE: Mapping[str, dict[str, Any]] = {
    "engine": {"choices": Engines(), "type": None, "metavar": None},
    "no_tare": {"dest": "tare", "action": "store_false"},
    "camera_lag": {"type": number},
    "expect_pins": {"type": whole_number},
}
"Choices and notes of options that the tables of settings do not hold."


def add_shared(parser: Group, *tables: str) -> None:
    """Options of tables of this module."""
    add_options(parser, "\n".join(table.strip() for table in tables), TYPES, **MORE)


def add_frames(parser: argparse.ArgumentParser, help: str = PATH_HELP) -> None:
    """The frames, and the files that go with them."""
    parser.add_argument("path", type=Path, metavar="PATH", help=help)
    add_shared(parser, FILES)


def add_method(parser: argparse.ArgumentParser) -> Group:
    """How a press is scored; the group of these options."""
    method = parser.add_argument_group("method")
    add_shared(method, METHOD)
    add_shared(parser.add_argument_group("pins"), PINS)
    return method


def asked_of(arguments: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Values of the options that the user gave for these settings, by name."""
    options = {name: OPTION_OF.get(name, name) for name in names}
    return {name: getattr(arguments, option) for name, option in options.items() if hasattr(arguments, option)}


def of_fields(arguments: argparse.Namespace, settings: type) -> dict[str, Any]:
    """Values of the options that the user gave for the fields of a settings dataclass, by name."""
    return asked_of(arguments, *(field.name for field in fields(settings)))


def pin_settings(arguments: argparse.Namespace) -> PinSettings:
    """Settings of the pins from the options."""
    from casr.pins import PinSettings

    return PinSettings(**of_fields(arguments, PinSettings))


def check_forces(arguments: argparse.Namespace) -> tuple[float, float]:
    """The forces that the mean rate is taken between, N. SettingError where scoring would stop before it starts."""
    start_n, stop_n = arguments.start_n, arguments.stop_n or PAPER_STOP_N
    if stop_n <= start_n:
        wanted, do = f"more than --start-n, {start_n:g} N", "Correct one of the two."
        raise SettingError("--stop-n", wanted=wanted, found=f"{stop_n:g} N", do=do)
    return start_n, stop_n


def score_settings(arguments: argparse.Namespace) -> ScoreSettings:
    """The settings that the options ask for. SettingError as `check_forces`."""
    check_forces(arguments)
    from casr.flow.estimate import FlowSettings
    from casr.scored import WHOLE_IMAGE, ScoreSettings

    flow = FlowSettings(engine=arguments.engine, pins=pin_settings(arguments))
    region = arguments.region if arguments.region == WHOLE_IMAGE else region_of(arguments)
    asked = of_fields(arguments, ScoreSettings) | {"flow": flow, "region": region}
    return ScoreSettings(**asked)


def region_of(arguments: argparse.Namespace) -> Region | None:
    """The circle that was asked for."""
    from casr.flow.region import Region

    return Region.parse(arguments.region) if arguments.region is not None else None


def files_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The files that go with the frames, as `open_frames` takes them."""
    return asked_of(arguments, "force", "camera", "column", "force_rule")


def open_sequence(arguments: argparse.Namespace, path: Path | None = None) -> FrameSequence:
    """The frames that were asked for. path : of one press of several."""
    from casr.frame_files import open_frames

    return open_frames(path or arguments.path, **files_of(arguments))


def say_notes(notes: Iterable[str], name: str = "") -> None:
    """One line on the error stream for each."""
    for text in notes:
        note(f"note: {name}: {text}" if name else f"note: {text}")
