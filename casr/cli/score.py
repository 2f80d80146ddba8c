"""``casr score``: one press or a folder of presses to contact area and its spread rate."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from casr.cli.arguments import (
    AREA_RULES,
    Commands,
    add_command,
    add_engine,
    add_frames,
    add_json,
    add_threshold,
    html_file,
    open_sequence,
    positive,
    print_json,
    say_notes,
)
from casr.errors import CasrError, SettingError

if TYPE_CHECKING:
    from casr.score import Score, ScoreSettings

AREA_LAWS = ("ode", "paper")
RATE_RULES = ("power", "slope", "paper")
PAPER_STOP_N = 7.0


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "score",
        run,
        "Score a press: initial contact area, its growth and the contact area spread rate (CASR).",
        "A larger CASR means a softer specimen. Without a force log there is area and growth, but no CASR. "
        "In a folder of presses each is scored; one that cannot be is named and left out. "
        "Exit status 1: a press of several could not be scored. Example: casr score press --page press.html",
    )
    add_frames(
        parser,
        help="a press: a folder of images, a TIFF, AVI, MP4 or .npy file, or a press folder (frames, force.csv, "
        "camera.toml); or a folder of presses",
    )
    method = parser.add_argument_group("method")
    add_engine(method)
    method.add_argument("--area", choices=AREA_RULES, default=AREA_RULES[0], help="initial area (default %(default)s)")
    method.add_argument(
        "--law", choices=AREA_LAWS, default=AREA_LAWS[0],
        help="area growth: ode, exp(sum of log growth), or paper, eq. (1) as printed (default %(default)s)",
    )  # fmt: skip
    method.add_argument(
        "--rate", choices=RATE_RULES, default=RATE_RULES[0],
        help="CASR: power, the mean rate from --start-n to --stop-n on a power law through the areas; slope of area on "
        "force; or paper, eq. (2) as printed (default %(default)s)",
    )  # fmt: skip
    add_threshold(method)
    method.add_argument(
        "--region", metavar="X,Y,R", help="contact circle, px (default: found from the pins that moved)"
    )
    method.add_argument(
        "--start-n", type=positive, default=0.5, metavar="N", help="force of first contact, N (default %(default)s)"
    )
    method.add_argument(
        "--stop-n", type=positive, metavar="N",
        help=f"force to stop at, N (default: the highest; the mean rate goes to {PAPER_STOP_N:g})",
    )  # fmt: skip
    output = parser.add_argument_group("output")
    add_json(output)
    output.add_argument(
        "--page",
        type=html_file,
        metavar="FILE.html",
        help="write a page; of several presses, an index and a page for each",
    )
    output.add_argument("--figures", type=Path, metavar="DIR", help="write the pictures as PNG and SVG")


def run(arguments: argparse.Namespace) -> int:
    if (arguments.stop_n or PAPER_STOP_N) <= arguments.start_n:
        raise SettingError(
            "--stop-n",
            wanted=f"more than --start-n, {arguments.start_n:g} N",
            found=f"{arguments.stop_n or PAPER_STOP_N:g} N",
            do="Correct one of the two.",
        )
    from casr.frame_files import find_presses

    found = find_presses(arguments.path)
    if len(found) > 1 and arguments.force:
        raise SettingError(
            "--force",
            wanted="one press",
            found=f"{len(found)} presses in {arguments.path}",
            do="Put a force.csv into each press folder.",
        )
    return _one(arguments, found[0]) if found == [arguments.path] else _many(arguments, found)


def settings_of(arguments: argparse.Namespace) -> ScoreSettings:
    """The settings that the options ask for."""
    from casr.flow.estimate import FlowSettings
    from casr.flow.region import Region
    from casr.score import ScoreSettings

    return ScoreSettings(
        flow=FlowSettings(engine=arguments.engine),
        area_rule=arguments.area,
        area_law=arguments.law,
        rate_rule=arguments.rate,
        rate_window_n=(arguments.start_n, arguments.stop_n or PAPER_STOP_N),
        threshold_px=arguments.threshold_px,
        force_start_n=arguments.start_n,
        force_stop_n=arguments.stop_n,
        region=Region.parse(arguments.region) if arguments.region else None,
    )


def _one(arguments: argparse.Namespace, path: Path) -> int:
    from casr.cli.results import block

    scored = _score(arguments, path, settings_of(arguments), arguments.page, arguments.figures)
    say_notes(scored.notes)
    if arguments.json:
        print_json(scored.to_dict())
    else:
        print(block(scored))
    return 0


def _many(arguments: argparse.Namespace, found: list[Path]) -> int:
    from casr.cli.results import head, row

    settings = settings_of(arguments)
    called = [_name(path, arguments.path) for path in found]
    width = max(map(len, called))
    scores: dict[str, Score] = {}
    failures: dict[str, str] = {}
    if not arguments.json:
        print(head(width))
    for name, path in zip(called, found, strict=True):
        page = arguments.page and arguments.page.with_suffix("") / f"{name}.html"
        try:
            scores[name] = _score(arguments, path, settings, page, arguments.figures and arguments.figures / name)
        except CasrError as error:
            failures[name] = str(error)
            print(f"not scored: {name}: {error}", file=sys.stderr)
            continue
        if not arguments.json:
            print(row(name, scores[name], width), flush=True)
    for name, scored in scores.items():
        say_notes(scored.notes, name)
    if arguments.page:
        from casr.cli.pages import write_index

        write_index(arguments.page, arguments.path.resolve().name, scores, failures)
    if arguments.json:
        print_json({"presses": {name: s.to_dict() for name, s in scores.items()}, "not_scored": failures})
    return int(bool(failures))


def _name(path: Path, root: Path) -> str:
    """The path below ``root`` with dashes, without a file's suffix."""
    return "-".join((path.with_suffix("") if path.is_file() else path).relative_to(root).parts)


def _score(
    arguments: argparse.Namespace, path: Path, settings: ScoreSettings, page: Path | None, figures: Path | None
) -> Score:
    """Score one press and write what was asked for of it."""
    from casr.score import score

    sequence = open_sequence(arguments, path)
    scored = score(sequence, settings)
    if page or figures:
        from casr.cli.pages import write_press

        write_press(sequence, scored, page, figures)
    return scored
