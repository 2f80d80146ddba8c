"""Options: what they accept is what the modules accept, and wrong ones are refused in words."""

from __future__ import annotations

import pytest

from casr.cli import arguments, bench, calibrate, main, simulate, values


def test_choices_are_those_of_the_modules() -> None:
    from benchmarks.tactile import KINDS
    from casr.camera_calibration.intrinsics import OPENCV_FLAGS
    from casr.contact_area import RULES
    from casr.flow.step import ENGINES
    from casr.frames import FORCE_RULES
    from casr.spread import AREA_LAWS, RATE_RULES, WINDOW_N

    assert values.ENGINES == ENGINES
    assert values.AREA_RULES == RULES
    assert values.FORCE_RULES == FORCE_RULES
    assert values.AREA_LAWS == AREA_LAWS
    assert values.RATE_RULES == RATE_RULES
    assert WINDOW_N[1] == arguments.PAPER_STOP_N
    assert bench.KINDS == KINDS
    assert tuple(OPENCV_FLAGS) == calibrate.DISTORTIONS


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
