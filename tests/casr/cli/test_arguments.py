"""Options: what they accept is what the modules accept, and wrong ones are refused in words."""

from __future__ import annotations

import pytest

from casr.cli import PROGRAM, main
from casr.command_line import parsers_of


def test_choices_are_those_of_the_modules() -> None:
    from benchmarks.tactile import KINDS
    from casr.camera_calibration.intrinsics import OPENCV_FLAGS
    from casr.contact_area import RULES
    from casr.flow.step import ENGINES
    from casr.frames import FORCE_RULES
    from casr.scored import QUANTITIES
    from casr.spread import AREA_LAWS, RATE_RULES
    from emg2vsa.worlds.tactile import SCATTERS

    wanted = {
        "score": {
            "engine": ENGINES, "area": RULES, "force_rule": FORCE_RULES, "law": AREA_LAWS, "rate": RATE_RULES,
            "quantity": QUANTITIES,
        },
        "bench": {"what": KINDS},
        "calibrate": {"distortion": OPENCV_FLAGS},
        "simulate": {"scatter": SCATTERS},
    }  # fmt: skip
    parsers = {parser.prog: parser for parser in parsers_of(PROGRAM.parser())}
    for command, options in wanted.items():
        actions = {action.dest: action for action in parsers[f"casr {command}"]._actions}
        for option, known in options.items():
            assert tuple(actions[option].choices or ()) == tuple(known)


def test_what_is_not_given_is_the_default_of_the_modules() -> None:
    """Of scoring, of pins and of simulated presses; the window of the mean rate too."""
    from casr.cli.arguments import of_fields, score_settings
    from casr.scored import ScoreSettings
    from emg2vsa.worlds.tactile import Appearance, PressPlan

    parser = PROGRAM.parser()
    assert score_settings(parser.parse_args(["score", "x"])) == ScoreSettings()
    simulate = parser.parse_args(["simulate", "x"])
    assert PressPlan(**of_fields(simulate, PressPlan)) == PressPlan()
    assert Appearance(**of_fields(simulate, Appearance)) == Appearance()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["area", "x", "--frames", "3"], "2 numbers with commas"),
        (["area", "x", "--frames", "3,3"], "two different frame numbers"),
        (["area", "x", "--frames", "-1,3"], "--frames"),
        (["area", "x", "--threshold-px", "0"], "above 0"),
        (["score", "x", "--start-n", "nan"], "expected 1 number"),
        (["simulate", "x", "--repetitions", "0"], "whole number from 1"),
        (["simulate", "x", "--angles", "0;30"], "commas"),
        (["score", "x", "--engine", "lucas-kanade"], "pin-affine"),
        (["score", "x", "--pitch", "0"], "above 0"),
        (["area", "x", "--contrast", "-1"], "above 0"),
        (["flow", "x", "--min-area", "big"], "1 numbers"),
        (["flow", "x", "--expect-pins", "0"], "whole number from 1"),
    ],
)
def test_wrong_options_are_refused(words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 2
    assert complaint in capsys.readouterr().err
