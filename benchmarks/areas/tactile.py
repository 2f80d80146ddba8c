"""The tactile areas: motion of pins, dense flow, growth of a contact, its first area, and a press to its rate."""

from __future__ import annotations

from benchmarks.bench.case import Area, part_of

PINS = Area(
    name="pins",
    question="What does the motion of a contact's pins cost, and how far is its divergence off?",
    parts=(part_of("benchmarks.tactile.flow_cases", "pin_cases"),),
    peers={"cv2": "opencv-contrib-python-headless"},
    meaning=(
        "All ways give one affine motion of the same pins, and use the same fit. Ours finds every pin anew by its "
        "light and so keeps its identity through large motions; Lucas and Kanade follow patches: on pins whose "
        "places are known they are faster, as exact from a pixel of motion on, and less exact below. Errors are the "
        "rms and the bias of the divergence over seeds, each in a case of its own."
    ),
)
FLOW = Area(
    name="flow",
    question="What does dense flow of a tactile frame cost, and how far is the divergence of the contact off?",
    parts=(part_of("benchmarks.tactile.flow_cases", "dense_cases"),),
    peers={"cv2": "opencv-contrib-python-headless", "skimage": "scikit-image"},
    meaning=(
        "The divergence of the contact is what a score takes from a flow. Fast presets smooth over the edge of a "
        "contact and lose divergence: a bias that no average over frames removes, so that bias and rms stand "
        "apart. DIS tuned for such frames is faster than Horn-Schunck, and as exact up to a pixel of motion."
    ),
)
GROWTH = Area(
    name="growth",
    question="How much of a contact's growth does each engine find, by the contact's size?",
    parts=(part_of("benchmarks.tactile.flow_cases", "growth_cases"),),
    peers={"cv2": "opencv-contrib-python-headless"},
    meaning=(
        "The engine dis is OpenCV's; horn-schunck and pin-affine are ours. The smaller a contact is, the more a "
        "dense flow loses at its edge. Patches of Lucas and Kanade on pins whose places are told find the growth as "
        "exactly in .1 to .4 of the time: ours finds the pins itself, keeps each through large motions, and "
        "believes no torn or noisy frame."
    ),
)
AREA = Area(
    name="area",
    question="What does the first area of a contact cost by each rule, and how far is it off?",
    parts=(part_of("benchmarks.tactile.press_scores", "area_cases"),),
    peers={"cv2": "opencv-contrib-python-headless"},
    meaning=(
        "The rule paper is Algorithm 1 with its pins paired one to one; circle is that of earlier work and does "
        "not depend on the contact. The hull and the moments of moved pins are what a few lines give: they are off by "
        "twice the area and more."
    ),
)
SCORING = Area(
    name="scoring",
    question="What does a press cost from frames to its spread rate, and how far is the rate off?",
    parts=(part_of("benchmarks.tactile.press_scores", "scoring_cases"),),
    peers={},
    meaning=(
        "No other library scores such presses, and no expert's lines do equal work: all ways are ours. The front is "
        "followed in every frame; the skin "
        "of the first contact, the paper's way, is stretched by the flow. Time grows with the number of frames."
    ),
)
