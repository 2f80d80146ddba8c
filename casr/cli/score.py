"""``casr score``: one press or a folder of presses to contact area and its spread rate."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from casr.cli import arguments as shared
from casr.command_line import JSON, Commands, add_command, print_json
from casr.errors import SettingError

if TYPE_CHECKING:
    from casr.frames import FrameSequence
    from casr.press_files import PressFiles
    from casr.scored import ScoreSettings

OUTPUT = f"""
--page FILE.html  write a page; of several presses, an index and a page for each
--pins FILE.csv  write the way of every pin, of one press
--frames FILE.csv  write force, areas, shear and torsion of every frame, of one press
{shared.FIGURES}"""
CORRECT = "--correct-lag  find that lag, from when the pins begin to move and the force to rise, and take it off"


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands, "score", run,
        "Score a press: initial contact area, its growth and the contact area spread rate (CASR).",
        "A larger CASR means a softer specimen. Without a force log the command computes area and growth, but no "
        "CASR. In a folder of presses the command scores each press, and names those that it cannot score. "
        "Exit status 1: one of several presses could not be scored. Example: casr score press --page press.html",
    )  # fmt: skip
    shared.add_frames(parser, f"a press: {shared.PATH_HELP}; or a folder of presses")
    shared.add_shared(shared.add_method(parser).add_mutually_exclusive_group(), shared.LAG, CORRECT)
    shared.add_shared(parser.add_argument_group("output"), JSON, OUTPUT)


def run(arguments: argparse.Namespace) -> int:
    """Score one press or a folder of presses. Returns 1 where one is not scored.

    SettingError : one force log for several presses.
    """
    shared.check_forces(arguments)
    from casr.frame_files import find_presses
    from casr.page import text
    from casr.press_files import PressFiles, named_presses
    from casr.scoring import score

    root = arguments.path
    found = find_presses(root)
    if len(found) > 1 and arguments.force:
        several, do = f"{len(found)} presses in {root}", "Put a force.csv into each press folder."
        raise SettingError("--force", wanted="one press", found=several, do=do)
    files = PressFiles(**shared.of_fields(arguments, PressFiles))
    files.check(root, found)
    settings, open_press = shared.score_settings(arguments), partial(shared.open_sequence, arguments)
    if found == [root]:
        scored = score(open_press(root), settings)
        files.write(partial(open_press, root), scored)
        shared.say_notes(scored.notes)
        print_json(scored.to_dict()) if arguments.json else print(text.block(scored))
        return 0
    return _several(arguments, named_presses(root, found), files, settings, open_press)


def _several(
    arguments: argparse.Namespace, presses: Mapping[str, Path], files: PressFiles, settings: ScoreSettings,
    open_press: Callable[[Path], FrameSequence],
) -> int:  # fmt: skip
    """Score a folder of presses, each told as it is done."""
    from casr.page import text
    from casr.press_files import score_presses
    from casr.scored import Score

    say, width = not arguments.json, max(map(len, presses))

    def tell(name: str, scored: Score | Exception) -> None:
        if not isinstance(scored, Score):
            print(f"not scored: {name}: {scored}", file=sys.stderr)
        elif say:
            print(text.row(name, scored, width), flush=True)

    if say:
        print(text.head(width, settings.quantity))
    scores = score_presses(presses, settings, open_press, tell)
    for name, scored in scores.scores.items():
        files.of(name).write(partial(open_press, presses[name]), scored)
        shared.say_notes((*(f"check this press: {doubt}" for doubt in scored.doubts), *scored.notes), name)
    files.write_index(arguments.path.resolve().name, scores.scores, scores.not_scored)
    if arguments.json:
        every = {name: scored.to_dict() for name, scored in scores.scores.items()}
        print_json({"presses": every, "not_scored": scores.not_scored})
    else:
        for name, reason in scores.unlike.items():
            print(f"check this press: {name}: {reason}")
    return int(bool(scores.not_scored))
