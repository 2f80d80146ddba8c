"""Motion of a contact's pins between two frames: found or followed by us, followed by Lucas and Kanade."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.bench.case import Area, Case, Size


def affine_motion(size: Size) -> Iterator[Case]:
    """Equal work: the affine motion of the same pins, from two frames."""
    from benchmarks.tactile.flow_cases import pin_cases

    return pin_cases(size)


AREA = Area(
    name="pins",
    question="What does the motion of a contact's pins cost, and how far is its divergence off?",
    parts=(affine_motion,),
    peers={"cv2": "opencv-contrib-python-headless"},
    meaning=(
        "All ways give one affine motion of the same pins, and use the same fit. Ours finds every pin anew by its "
        "light and so keeps its identity through large motions; Lucas and Kanade follow patches. Errors are the "
        "rms and the bias of the divergence over seeds, each in a case of its own."
    ),
)
