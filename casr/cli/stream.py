"""``casr stream``: score a press frame by frame, also while somebody records it."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

from casr.cli import arguments as shared
from casr.command_line import Commands, add_command, add_json, finite
from casr.errors import SettingError
from casr.terminal import note

if TYPE_CHECKING:
    from casr.frame_files.growing import NewFrame
    from casr.scored import Spread
    from casr.stream import StreamState

FOLLOW = """
--follow  wait for frames that are still to come
--idle SECONDS = 2.0  with --follow: end when, after the first frame or the force of one, nothing new has come for so
    long (default %(default)s)
"""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "stream", run,
        "Score a press frame by frame: area and contact area spread rate (CASR) after each frame.",
        "With --follow the press may still be recorded: the command waits for more frames, answers each as soon as its "
        "force is known, and ends when the press is over or nothing new comes. The last lines are those of casr score. "
        "With --json each line is one JSON object: a frame, or at the end the score. Example: casr stream press-001 "
        "--follow",
    )  # fmt: skip
    shared.add_frames(parser)
    shared.add_shared(parser, FOLLOW)
    shared.add_shared(shared.add_method(parser), shared.LAG)
    add_json(parser.add_argument_group("output"))


def run(arguments: argparse.Namespace) -> int:
    """Score a press frame by frame and print each.

    SettingError : no frame with a force, or ``--follow`` with a file.
    """
    shared.check_forces(arguments)
    from casr.frame_files.growing import GrowingPress
    from casr.page import text
    from casr.stream import StreamScorer

    path, follow, told = arguments.path, arguments.follow, _json_line if arguments.json else text.frame
    if follow and path.is_file():
        do = "Give the folder of the press, or leave out --follow."
        raise SettingError("--follow", wanted="a folder that is recorded into", found=f"a file, {path}", do=do)
    settings = shared.score_settings(arguments)
    press, scorer = GrowingPress(path, **shared.files_of(arguments), lag_s=arguments.camera_lag or 0.0), None
    waiting = f"waiting for frames and forces in {path}"
    for frame in press.follow(arguments.idle, lambda: note(waiting)) if follow else press.new_frames(ended=True):
        scorer = scorer or StreamScorer(press.camera(), settings)
        state = scorer.push(frame.image, frame.force_n)
        print(told(frame, state, scorer.spread()), flush=True)
        scorer.settle()
        if follow and scorer.over:
            break
    if scorer is None:
        do = "Give a press folder (frames, force.csv), or wait for its frames with --follow."
        raise SettingError(path, wanted="a press with frames and forces", found="no frame that has a force", do=do)
    score = scorer.finish()
    shared.say_notes(score.notes)
    print(json.dumps(finite({"score": score.to_dict()})) if arguments.json else text.block(score), flush=True)
    return 0


def _json_line(frame: NewFrame, state: StreamState, spread: Spread | None) -> str:
    rate, interval = (spread.rate, spread.interval) if spread else (None, None)
    line = {
        "frame": frame.index, "time_s": frame.time_s, "force_n": state.force_n, "phase": state.phase,
        "area": state.area, "area_unit": state.area_unit, "casr": rate and rate.value,
        "casr_low": interval and interval.low, "casr_high": interval and interval.high, "notes": list(state.notes),
    }  # fmt: skip
    return json.dumps(finite(line))
