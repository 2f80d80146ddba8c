"""A press to its contact area spread rate."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.bench.case import Area, Case, Size


def spread_rate(size: Size) -> Iterator[Case]:
    """Frames in memory to dA/dF, by front and by skin."""
    from benchmarks.tactile.press_scores import scoring_cases

    return scoring_cases(size)


AREA = Area(
    name="scoring",
    question="What does a press cost from frames to its spread rate, and how far is the rate off?",
    parts=(spread_rate,),
    peers={},
    meaning=(
        "No other library scores such presses: all ways are ours. The front is followed in every frame; the skin "
        "of the first contact, the paper's way, is stretched by the flow. Time grows with the number of frames."
    ),
)
