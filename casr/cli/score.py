"""``casr score``: one press or a folder of presses to contact area and its spread rate."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from casr.cli.arguments import (
    AREA_RULES,
    add_engine,
    add_frames,
    add_pins,
    add_tare,
    add_threshold,
    html_file,
    number,
    open_sequence,
    pin_settings,
    positive,
    say_notes,
)
from casr.command_line import Commands, add_command, add_json, print_json
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
    add_pins(parser.add_argument_group("pins"))
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
    add_tare(method)
    lag = method.add_mutually_exclusive_group()
    lag.add_argument(
        "--camera-lag", type=number, default=0.0, metavar="SECONDS",
        help="the frames were taken so long before their times in the force log",
    )  # fmt: skip
    lag.add_argument(
        "--correct-lag", action="store_true",
        help="find that lag, from when the pins begin to move and the force to rise, and take it off",
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
        flow=FlowSettings(engine=arguments.engine, pins=pin_settings(arguments)),
        area_rule=arguments.area,
        area_law=arguments.law,
        rate_rule=arguments.rate,
        rate_window_n=(arguments.start_n, arguments.stop_n or PAPER_STOP_N),
        threshold_px=arguments.threshold_px,
        force_start_n=arguments.start_n,
        force_stop_n=arguments.stop_n,
        region=Region.parse(arguments.region) if arguments.region else None,
        tare=not arguments.no_tare,
        camera_lag_s=arguments.camera_lag,
        correct_lag=arguments.correct_lag,
    )


def _one(arguments: argparse.Namespace, path: Path) -> int:
    scored = _score(arguments, path, settings_of(arguments), arguments.page, arguments.figures)
    say_notes(scored.notes)
    if arguments.json:
        print_json(scored.to_dict())
    else:
        print(_block(scored))
    return 0


def _many(arguments: argparse.Namespace, found: list[Path]) -> int:
    from casr.cli.pages import pages_folder

    settings = settings_of(arguments)
    called = [_name(path, arguments.path) for path in found]
    width = max(map(len, called))
    scores: dict[str, Score] = {}
    failures: dict[str, str] = {}
    if not arguments.json:
        print(_head(width))
    for name, path in zip(called, found, strict=True):
        page = arguments.page and pages_folder(arguments.page) / f"{name}.html"
        try:
            scores[name] = _score(arguments, path, settings, page, arguments.figures and arguments.figures / name)
        except CasrError as error:
            failures[name] = str(error)
            print(f"not scored: {name}: {error}", file=sys.stderr)
            continue
        if not arguments.json:
            print(_row(name, scores[name], width), flush=True)
    for name, scored in scores.items():
        say_notes((*(f"check this press: {doubt}" for doubt in scored.doubts), *scored.notes), name)
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


def _block(score: Score) -> str:
    """One press, a fact per line."""
    from casr.page.wording import camera_lag, force_zero

    settings, frames = score.settings, score.frames
    force = score.force_n
    span = f"{frames[0]} to {frames[-1]}"
    if force is not None:
        span += f", {force[0]:.2f} to {force[-1]:.2f} N"
    pins = f"{len(score.initial.selected)} of {len(score.rest.centroids_px)} pins, rule {score.initial.rule}"
    saturated = ", saturated" if score.initial.saturated else ""
    lines = [
        score.name + (", areas in px², not mm²" if score.area_unit == "px2" else ""),
        *(f"  Check this press: {doubt}" for doubt in score.doubts),
        f"  frames      {len(frames)} ({span}), rest frame {score.rest_frame}",
        f"  A_c0        {score.area[0]:.4g} {score.area_unit} ({pins}{saturated})",
        f"  growth      {score.log_growth.sum():+.4f} in log, {score.area[-1] / score.area[0]:.3f} times the area",
        f"  CASR        {_rate(score)}",
        *([] if force is None else [f"  force zero  {force_zero(score)}", f"  camera lag  {camera_lag(score)}"]),
        f"  method      {settings.flow.engine}, area rule {settings.area_rule}, law {settings.area_law}, "
        f"rate {settings.rate_rule}",
    ]
    return "\n".join(lines)


def _head(width: int) -> str:
    """Names of the columns of ``_row``."""
    names = f"{'frames':>6} {'pins':>5} {'A_c0':>10} {'growth':>7} {'CASR':>9} {'95 % interval':>19} {'notes':>5}  unit"
    return f"{'press':<{width}} {names}"


def _row(name: str, score: Score, width: int) -> str:
    """One press of many on a line."""
    rate = score.rate
    interval = f"{rate.low:.4g} to {rate.high:.4g}" if rate and rate.low is not None else "-"
    return (
        f"{name:<{width}} {len(score.frames):>6} {len(score.initial.selected):>5} {score.area[0]:>10.4g} "
        f"{score.log_growth.sum():>7.3f} {f'{rate.value:.4g}' if rate else '-':>9} {interval:>19} "
        f"{len(score.notes):>5}  {rate.unit if rate else score.area_unit}{'  check this press' if score.doubts else ''}"
    )


def _rate(score: Score) -> str:
    rate = score.rate
    if rate is None:
        return "none: no force belongs to these frames"
    interval = f" ({rate.low:.4g} to {rate.high:.4g}, 95 %)" if rate.low is not None else ""
    window = f", {rate.window_n[0]:g} to {rate.window_n[1]:g} N" if rate.window_n else ""
    return f"{rate.value:.4g} {rate.unit}{interval}{window}, from {rate.n_frames} frames"
