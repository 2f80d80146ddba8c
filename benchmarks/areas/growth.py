"""Growth of a contact followed through a press by every engine."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.bench.case import Area, Case, Size


def followed_growth(size: Size) -> Iterator[Case]:
    """Ten steps of a contact of some pitches' radius."""
    from benchmarks.tactile.flow_cases import growth_cases

    return growth_cases(size)


AREA = Area(
    name="growth",
    question="How much of a contact's growth does each engine find, by the contact's size?",
    parts=(followed_growth,),
    peers={"cv2": "opencv-contrib-python-headless"},
    meaning=(
        "The engine dis is OpenCV's; horn-schunck and pin-affine are ours. The smaller a contact is, the more a "
        "dense flow loses at its edge."
    ),
)
