"""``casr stream``: score a press frame by frame, also while somebody records it."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from casr.cli.arguments import add_frames, positive, say_notes
from casr.cli.score import add_lag, add_method, block_of, check_forces, settings_of
from casr.command_line import Commands, add_command, add_json, finite
from casr.errors import SettingError
from casr.terminal import note

if TYPE_CHECKING:
    from casr.frame_files.growing import GrowingPress, NewFrame
    from casr.scored import Score
    from casr.stream import StreamScorer, StreamState

_LOOK_S = 0.02
AFTER_FRAMES = 20
"""So many frames out of contact after a contact, and the press is over."""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "stream",
        run,
        "Score a press frame by frame: area and contact area spread rate (CASR) after each frame.",
        "With --follow the press may still be recorded: the command waits for more frames, answers each as soon as its "
        "force is known, and ends when the press is over or nothing new comes. The last lines are those of casr score. "
        "With --json each line is one JSON object: a frame, or at the end the score. Example: casr stream press-001 "
        "--follow",
    )
    add_frames(parser)
    parser.add_argument("--follow", action="store_true", help="wait for frames that are still to come")
    parser.add_argument(
        "--idle", type=positive, default=2.0, metavar="SECONDS",
        help="with --follow: end when, after the first frame or the force of one, nothing new has come for so long "
        "(default %(default)s)",
    )  # fmt: skip
    add_lag(add_method(parser))
    add_json(parser.add_argument_group("output"))


def run(arguments: argparse.Namespace) -> int:
    from casr.frame_files.growing import GrowingPress
    from casr.stream import StreamScorer

    check_forces(arguments)
    if arguments.follow and arguments.path.is_file():
        raise SettingError(
            "--follow", wanted="a folder that is recorded into", found=f"a file, {arguments.path}",
            do="Give the folder of the press, or leave out --follow.",
        )  # fmt: skip
    arguments.correct_lag = False
    settings = settings_of(arguments)
    press = GrowingPress(
        arguments.path,
        force=arguments.force,
        camera=arguments.camera,
        column=arguments.force_column,
        force_rule=arguments.force_rule,
        lag_s=arguments.camera_lag,
    )
    scorer: StreamScorer | None = None
    for frame in _frames(press, arguments):
        scorer = scorer or StreamScorer(press.camera(), settings)
        state = scorer.push(frame.image, frame.force_n)
        _say(arguments, frame, state, scorer)
        scorer.settle()
        if arguments.follow and (state.phase == "done" or scorer.rested >= AFTER_FRAMES):
            break
    if scorer is None:
        raise SettingError(
            arguments.path, wanted="a press with frames and forces", found="no frame that has a force",
            do="Give a press folder (frames, force.csv), or wait for its frames with --follow.",
        )  # fmt: skip
    _end(arguments, scorer.finish())
    return 0


def _frames(press: GrowingPress, arguments: argparse.Namespace) -> Iterator[NewFrame]:
    """Frames as they come; the last ones once nothing more does."""
    newest_s, told = None, False
    while arguments.follow:
        for frame in press.new_frames():
            newest_s = time.monotonic()
            yield frame
        if newest_s is None and not told:
            note(f"waiting for frames and forces in {arguments.path}")
            told = True
        if newest_s is None and press.behind:
            newest_s = time.monotonic()
        if newest_s is not None and time.monotonic() - newest_s > arguments.idle:
            break
        time.sleep(_LOOK_S)
    yield from press.new_frames(ended=True)


def _say(arguments: argparse.Namespace, frame: NewFrame, state: StreamState, scorer: StreamScorer) -> None:
    spread = scorer.spread()
    rate, interval = (spread.rate, spread.interval) if spread else (None, None)
    if arguments.json:
        line = {
            "frame": frame.index,
            "time_s": frame.time_s,
            "force_n": state.force_n,
            "phase": state.phase,
            "area": state.area,
            "area_unit": state.area_unit,
            "casr": rate and rate.value,
            "casr_low": interval and interval.low,
            "casr_high": interval and interval.high,
            "notes": list(state.notes),
        }
        print(json.dumps(finite(line)), flush=True)
        return
    parts = [f"frame {frame.index:4d}  {state.force_n:6.2f} N  {state.phase:<7}"]
    if state.phase != "rest":
        parts.append("not determined" if state.area is None else f"{state.area:.4g} {state.area_unit}")
    if rate is not None:
        within = f" ({interval.low:.4g} to {interval.high:.4g})" if interval else ""
        parts.append(f"CASR {rate.value:.4g}{within} {rate.unit}")
    print("  ".join((*parts, *state.notes)), flush=True)


def _end(arguments: argparse.Namespace, score: Score) -> None:
    say_notes(score.notes)
    if arguments.json:
        print(json.dumps(finite({"score": score.to_dict()})), flush=True)
    else:
        print(block_of(score))
