"""The first area of a contact, from pins at rest and in contact."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.bench.case import Area, Case, Size


def first_area(size: Size) -> Iterator[Case]:
    """Equal work: one area for each press, pins known."""
    from benchmarks.tactile.press_scores import area_cases

    return area_cases(size)


AREA = Area(
    name="area",
    question="What does the first area of a contact cost by each rule, and how far is it off?",
    parts=(first_area,),
    peers={"cv2": "opencv-contrib-python-headless"},
    meaning=(
        "The rule paper is Algorithm 1 with its pins paired one to one; circle is that of earlier work and does "
        "not depend on the contact. The hull of moved pins is what a few lines of OpenCV give."
    ),
)
