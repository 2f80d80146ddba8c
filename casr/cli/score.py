"""``casr score``: one press or a folder of presses to contact area and its spread rate."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from casr.cli.arguments import (
    AREA_RULES,
    add_engine,
    add_frames,
    add_pins,
    add_tare,
    add_threshold,
    csv_file,
    html_file,
    number,
    open_sequence,
    pin_settings,
    positive,
    say_notes,
)
from casr.command_line import Commands, Group, add_command, add_json, print_json
from casr.errors import CasrError, PassingError, SettingError

if TYPE_CHECKING:
    from casr.flow.region import Region
    from casr.scored import Spread
    from casr.scoring import Score, ScoreSettings

QUANTITIES = ("front", "skin")
AREA_LAWS = ("ode", "paper")
RATE_RULES = ("power", "slope", "paper")
PAPER_STOP_N = 7.0


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "score",
        run,
        "Score a press: initial contact area, its growth and the contact area spread rate (CASR).",
        "A larger CASR means a softer specimen. Without a force log the command computes area and growth, but no "
        "CASR. In a folder of presses the command scores each press, and names those that it cannot score. "
        "Exit status 1: one of several presses could not be scored. Example: casr score press --page "
        "press.html",
    )
    add_frames(
        parser,
        help="a press: a folder of images, a TIFF, AVI, MP4 or .npy file, or a press folder (frames, force.csv, "
        "camera.toml); or a folder of presses",
    )
    method = add_method(parser)
    lag = method.add_mutually_exclusive_group()
    add_lag(lag)
    lag.add_argument(
        "--correct-lag", action="store_true",
        help="find that lag, from when the pins begin to move and the force to rise, and take it off",
    )  # fmt: skip
    _add_outputs(parser.add_argument_group("output"))


def add_method(parser: argparse.ArgumentParser) -> Group:
    """How a press is scored; the group of these options."""
    method = parser.add_argument_group("method")
    method.add_argument(
        "--quantity", choices=QUANTITIES, default=QUANTITIES[0],
        help="which area is the result: front, the contact, whose edge is followed in every frame, or skin, that of "
        "the first contact as the flow stretches it, as in the paper; the other stands beside it (default %(default)s)",
    )  # fmt: skip
    method.add_argument("--domes", metavar="FOLDER", help="tables of your own domes, beside those that come with casr")
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
        "--region", metavar="X,Y,R",
        help="contact circle, px, or image, for dense engines: growth of skin is the mean divergence of the whole "
        "image (default: found from the pins that moved)",
    )  # fmt: skip
    method.add_argument(
        "--start-n", type=positive, default=0.5, metavar="N", help="force of first contact, N (default %(default)s)"
    )
    method.add_argument(
        "--stop-n", type=positive, metavar="N",
        help=f"force to stop at, N (default: the highest; the mean rate goes to {PAPER_STOP_N:g})",
    )  # fmt: skip
    add_tare(method)
    return method


def add_lag(parser: Group) -> None:
    """How late the frames are."""
    parser.add_argument(
        "--camera-lag", type=number, default=0.0, metavar="SECONDS",
        help="the frames were taken so long before their times in the force log",
    )  # fmt: skip


def _add_outputs(output: Group) -> None:
    """What is written of a press."""
    add_json(output)
    output.add_argument(
        "--page",
        type=html_file,
        metavar="FILE.html",
        help="write a page; of several presses, an index and a page for each",
    )
    output.add_argument("--pins", type=csv_file, metavar="FILE.csv", help="write the way of every pin, of one press")
    output.add_argument(
        "--frames", type=csv_file, metavar="FILE.csv",
        help="write force, areas, shear and torsion of every frame, of one press",
    )  # fmt: skip
    output.add_argument("--figures", type=Path, metavar="DIR", help="write the pictures as SVG")


def run(arguments: argparse.Namespace) -> int:
    check_forces(arguments)
    from casr.frame_files import find_presses

    found = find_presses(arguments.path)
    if len(found) > 1 and arguments.force:
        raise SettingError(
            "--force",
            wanted="one press",
            found=f"{len(found)} presses in {arguments.path}",
            do="Put a force.csv into each press folder.",
        )
    _check_outputs(arguments, found)
    return _one(arguments, found[0]) if found == [arguments.path] else _many(arguments, found)


def check_forces(arguments: argparse.Namespace) -> None:
    """SettingError where scoring would stop before it starts."""
    if (arguments.stop_n or PAPER_STOP_N) <= arguments.start_n:
        raise SettingError(
            "--stop-n",
            wanted=f"more than --start-n, {arguments.start_n:g} N",
            found=f"{arguments.stop_n or PAPER_STOP_N:g} N",
            do="Correct one of the two.",
        )


def settings_of(arguments: argparse.Namespace) -> ScoreSettings:
    """The settings that the options ask for."""
    from casr.flow.estimate import FlowSettings
    from casr.scoring import ScoreSettings

    return ScoreSettings(
        quantity=arguments.quantity,
        domes=arguments.domes,
        flow=FlowSettings(engine=arguments.engine, pins=pin_settings(arguments)),
        area_rule=arguments.area,
        area_law=arguments.law,
        rate_rule=arguments.rate,
        rate_window_n=(arguments.start_n, arguments.stop_n or PAPER_STOP_N),
        threshold_px=arguments.threshold_px,
        force_start_n=arguments.start_n,
        force_stop_n=arguments.stop_n,
        region=_region(arguments.region),
        tare=not arguments.no_tare,
        camera_lag_s=arguments.camera_lag,
        correct_lag=arguments.correct_lag,
    )


def _region(text: str | None) -> Region | str | None:
    from casr.flow.region import Region
    from casr.scored import WHOLE_IMAGE

    return text if text is None or text == WHOLE_IMAGE else Region.parse(text)


def _one(arguments: argparse.Namespace, path: Path) -> int:
    scored = _score(arguments, path, settings_of(arguments))
    _write(arguments, path, scored, arguments.page, arguments.figures)
    if arguments.pins or arguments.frames:
        _write_tables(arguments, scored)
    say_notes(scored.notes)
    if arguments.json:
        print_json(scored.to_dict())
    else:
        print(block_of(scored))
    return 0


def _many(arguments: argparse.Namespace, found: list[Path]) -> int:
    from casr.cli.pages import pages_folder

    settings = settings_of(arguments)
    called = {_name(path, arguments.path): path for path in found}
    width = max(map(len, called))
    scores: dict[str, Score] = {}
    failures: dict[str, str] = {}
    if not arguments.json:
        print(_head(width, settings.quantity))
    for name, path in called.items():
        try:
            scores[name] = _score(arguments, path, settings)
        except (CasrError, PassingError) as error:
            failures[name] = str(error)
            print(f"not scored: {name}: {error}", file=sys.stderr)
            continue
        if not arguments.json:
            print(_row(name, scores[name], width), flush=True)
    unlike = _unlike_others(scores)
    scores = {
        name: replace(score, doubts=(*score.doubts, unlike[name])) if name in unlike else score
        for name, score in scores.items()
    }
    for name, scored in scores.items():
        page = arguments.page and pages_folder(arguments.page) / f"{name}.html"
        _write(arguments, called[name], scored, page, arguments.figures and arguments.figures / name)
        say_notes((*(f"check this press: {doubt}" for doubt in scored.doubts), *scored.notes), name)
    if arguments.page:
        from casr.cli.pages import write_index

        write_index(arguments.page, arguments.path.resolve().name, scores, failures)
    if arguments.json:
        print_json({"presses": {name: s.to_dict() for name, s in scores.items()}, "not_scored": failures})
    else:
        for name, reason in unlike.items():
            print(f"check this press: {name}: {reason}")
    return int(bool(failures))


def _unlike_others(scores: Mapping[str, Score]) -> dict[str, str]:
    """Press to what sets it apart from the others of the folder."""
    from casr.stretch import stretch_of, unlike_others

    stretches = {name: stretch_of(score) for name, score in scores.items()}
    return unlike_others({name: stretch for name, stretch in stretches.items() if stretch is not None})


def _name(path: Path, root: Path) -> str:
    """The path below ``root`` with dashes, without a file's suffix."""
    return "-".join((path.with_suffix("") if path.is_file() else path).relative_to(root).parts)


def _score(arguments: argparse.Namespace, path: Path, settings: ScoreSettings) -> Score:
    from casr.scoring import score

    return score(open_sequence(arguments, path), settings)


def _write(arguments: argparse.Namespace, path: Path, score: Score, page: Path | None, figures: Path | None) -> None:
    """The page and the pictures, where they were asked for; few frames are decoded once more."""
    if page or figures:
        from casr.cli.pages import write_press

        write_press(open_sequence(arguments, path), score, page, figures)


def _write_tables(arguments: argparse.Namespace, score: Score) -> None:
    from casr.atomic import write_text_atomic
    from casr.press_tables import frames_csv, pins_csv

    for path, table in ((arguments.pins, pins_csv), (arguments.frames, frames_csv)):
        if path is not None:
            write_text_atomic(path, table(score))


def _check_outputs(arguments: argparse.Namespace, found: list[Path]) -> None:
    """Tables are of one press, and nothing is written among recordings."""
    tables = {"--pins": arguments.pins, "--frames": arguments.frames}
    for option, file in tables.items():
        if file is not None and found != [arguments.path]:
            raise SettingError(
                option,
                wanted="one press",
                found=f"{len(found)} presses in {arguments.path}",
                do="Score them one by one.",
            )
    if arguments.pins is not None and arguments.pins == arguments.frames:
        raise SettingError("--pins, --frames", wanted="two files", found=str(arguments.pins), do="Name them apart.")
    raw = arguments.path.resolve()
    for option, file in {**tables, "--page": arguments.page, "--figures": arguments.figures}.items():
        if file is not None and raw.is_dir() and raw in (file.resolve(), *file.resolve().parents):
            raise SettingError(
                option, wanted=f"a place outside {arguments.path}, which holds recordings", found=str(file),
                do="Raw data stay as they are: choose another folder.",
            )  # fmt: skip


def block_of(score: Score) -> str:
    """One press, a fact per line."""
    from casr.page.wording import (
        camera_lag,
        error_parts,
        first_areas,
        force_zero,
        growths,
        left_out,
        not_determined,
    )

    settings, frames = score.settings, score.frames
    span = f"{frames[0]} to {frames[-1]}"
    if score.force_n is not None:
        span += f", {score.force_n[0]:.2f} to {score.force_n[-1]:.2f} N"
    facts = [(f"CASR, {spread.quantity}", _rate(score, spread)) for spread in (score.chosen, score.other)]
    if score.front_spread is not None:
        ratio, low, high = score.front_spread.skin_over_front
        facts.append(("skin/front", f"{ratio:.3f} in growth, 95 %: {low:.3f} to {high:.3f}"))
    facts += [(f"A_c0, {quantity}", f"{area}, {of}") for quantity, area, of in first_areas(score)]
    facts.append(("growth", ", ".join(f"{quantity} {times}" for quantity, times in growths(score))))
    facts.append(("frames", f"{len(frames)} ({span}), rest frame {score.rest_frame}"))
    if score.force_n is not None:
        facts += [("force zero", force_zero(score)), ("camera lag", camera_lag(score))]
    if score.rate is not None:
        parts = ", ".join(f"{name} {share}" for name, share in error_parts(score.chosen))
        facts.append(("error", f"standard errors: {parts}"))
        facts.append(("left out", left_out(score.chosen)))
    method = (
        settings.flow.engine,
        f"area rule {settings.area_rule}",
        f"law {settings.area_law}",
        f"rate {settings.rate_rule}",
    )
    facts.append(("method", ", ".join(method)))
    return "\n".join([
        score.name + (", areas in px², not mm²" if score.area_unit == "px2" else ""),
        *(f"  Check this press: {doubt}" for doubt in score.doubts),
        *([f"  Not determined: {not_determined(score)}"] if score.first is None else []),
        *(f"  {name:<11} {value}" for name, value in facts),
    ])  # fmt: skip


def _head(width: int, quantity: str) -> str:
    """Names of the columns of ``_row``."""
    other = "front" if quantity == "skin" else "skin"
    return (
        f"{'press':<{width}} {quantity + ' CASR':>14} {'95 % interval':>18} {'forces, N':>13} {'determined':>10} "
        f"{other + ' CASR':>14} {'skin/front':>10} {'frames':>6} {'notes':>5}  unit"
    )


def _row(name: str, score: Score, width: int) -> str:
    """One press of many on a line."""
    rate, other, total, front = score.rate, score.other, score.interval, score.front_spread
    value = f"{rate.value:.4g}" if rate else "not determined" if score.first is None else "-"
    beside = f"{other.rate.value:.4g}" if other.rate else "not determined" if other.doubt else "-"
    interval = f"{total.low:.4g} to {total.high:.4g}" if total else "-"
    forces = "-" if score.force_n is None else f"{score.force_n[0]:.2f} to {score.force_n[-1]:.2f}"
    since = f"{front.first_n:.2f} N" if front and score.force_n is not None else "-"
    ratio = f"{front.skin_over_front[0]:.3f}" if front else "-"
    return (
        f"{name:<{width}} {value:>14} {interval:>18} {forces:>13} {since:>10} {beside:>14} {ratio:>10} "
        f"{len(score.frames):>6} {len(score.notes):>5}  {rate.unit if rate else score.area_unit}"
        f"{'  check this press' if score.doubts else ''}"
    )


def _rate(score: Score, spread: Spread) -> str:
    from casr.page.wording import forces_seen, interval, mean_over

    if spread.doubt:
        return f"not determined: {spread.doubt}"
    if spread.rate is None:
        return "none: no force belongs to these frames"
    said = f"{spread.rate.value:.4g} {spread.rate.unit}, {interval(spread)}; over {mean_over(score)}"
    return f"{said}, {forces_seen(score)}" if spread.quantity == score.settings.quantity else said
