"""Dense flow between two frames, at every pixel."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.bench.case import Area, Case, Size


def dense_flow(size: Size) -> Iterator[Case]:
    """Equal work: the flow of the whole frame; solvers without a whole frame say so."""
    from benchmarks.tactile.flow_cases import dense_cases

    return dense_cases(size)


AREA = Area(
    name="flow",
    question="What does dense flow of a tactile frame cost, and how far is the divergence of the contact off?",
    parts=(dense_flow,),
    peers={"cv2": "opencv-contrib-python-headless", "skimage": "scikit-image", "pyoptflow": "pyoptflow"},
    meaning=(
        "The divergence of the contact is what a score takes from a flow. Fast presets smooth over the edge of a "
        "contact and lose divergence: a bias that no average over frames removes, so that bias and rms stand "
        "apart."
    ),
)
