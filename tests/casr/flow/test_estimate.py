"""Every engine behind the front door, on simulated presses whose growth is known."""

from __future__ import annotations

import subprocess
import sys
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.tactile.flow_pairs import linear_pair
from benchmarks.tactile.flow_scores import LOOKS, growing_contact, growth_error_percent
from casr.errors import ImageError, SettingError
from casr.flow.estimate import ENGINES, LOST_PERCENT, FlowSettings, FlowStep, FlowTracker, doubt_of
from casr.flow.region import Region
from casr.flow.step import notes_by_frame
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import TACTIP_127, Appearance, ContactEllipse, ContactWorld, PressSettings, simulate_press

WORST = {"pin-affine": 0.003, "horn-schunck": 0.10, "dis": 0.16}
"Share of the total log growth; the smallest contact, of stiff specimens at 45 degrees, is the hardest for dense flow."


@cache
def press(specimen: str, angle_deg: float, **look: float) -> tuple[list[NDArray[np.uint8]], list[ContactEllipse]]:
    made = simulate_press(
        PressSettings(
            stiffness_n_per_mm=SPECIMENS[specimen],
            angle_deg=angle_deg,
            appearance=Appearance(**look),  # type: ignore[arg-type]
            world=ContactWorld(),  # in which the skin inside the contact grows as the contact
        )
    )
    frames = made.truth.loading_frames[::2]
    return (
        [made.frames.read(int(frame)) for frame in frames],
        [made.scene.contact(float(made.truth.force_n[frame])) for frame in frames],
    )


def region_of(contact: ContactEllipse, scale: float = 1.0) -> Region:
    return Region(contact.polygon_px(64)).scaled(scale)


def total_growth(
    engine: str, images: list[NDArray[np.uint8]], region: Region, **settings: object
) -> tuple[float, Region, set[str]]:
    tracker = FlowTracker(FlowSettings(engine=engine, **settings))  # type: ignore[arg-type]
    tracker.start(images[0], region)
    steps = [tracker.step(image) for image in images[1:]]
    return sum(step.log_growth for step in steps), steps[-1].region, {note for step in steps for note in step.notes}


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 45.0])
@pytest.mark.parametrize("specimen", ["S1", "S5"])
def test_total_growth_and_tracked_region(engine: str, angle_deg: float, specimen: str) -> None:
    images, contacts = press(specimen, angle_deg)
    true = np.log(contacts[-1].area_px2 / contacts[0].area_px2)
    found, region, notes = total_growth(engine, images, region_of(contacts[0]))
    assert found == pytest.approx(true, rel=WORST[engine])
    assert region.area_px2 == pytest.approx(region_of(contacts[0]).area_px2 * np.exp(found), rel=1e-9)
    assert np.hypot(*(region.centre_px - contacts[-1].centre_px)) < (0.3 if engine == "pin-affine" else 6)
    assert notes == ({doubt_of(engine)} if engine in LOST_PERCENT else set())


@pytest.mark.parametrize("engine", LOST_PERCENT)
@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize(("pitches", "which"), [(1.25, 0), (2.0, 1)])
def test_dense_flow_loses_what_it_says_at_most(engine: str, look: str, pitches: float, which: int) -> None:
    contact = growing_contact(pitches * TACTIP_127.pitch_px, 100, power=2, look=LOOKS[look])
    assert -LOST_PERCENT[engine][which] < growth_error_percent(engine, contact) < 3


@pytest.mark.parametrize(("engine", "worst_percent"), [("pin-affine", 0.5), ("horn-schunck", 1.0), ("dis", 1.5)])
def test_growth_of_a_contact_of_three_pitches(engine: str, worst_percent: float) -> None:
    contact = growing_contact(3 * TACTIP_127.pitch_px, 101, power=1, look=LOOKS["clean"])
    assert abs(growth_error_percent(engine, contact)) < worst_percent


def test_a_note_of_many_steps_is_said_once() -> None:
    region = Region.circle(0, 0, 1)
    steps = [FlowStep(0.0, 0.0, region, 3, notes) for notes in ((), ("lost",), ("lost", "jump"), ("lost",))]
    assert notes_by_frame([9, 8, 7, 6], steps) == ["3 frames from 6 to 8: lost", "frame 7: jump"]


@pytest.mark.parametrize("engine", ENGINES)
def test_identical_frames_give_exactly_zero(engine: str) -> None:
    image = linear_pair(1.0).first
    tracker = FlowTracker(FlowSettings(engine=engine))
    region = Region.circle(150, 149, 61.7)
    tracker.start(image, region)
    for _ in range(2):
        step = tracker.step(image.copy())
        assert (step.divergence, step.log_growth) == (0.0, 0.0)
        np.testing.assert_array_equal(step.region.polygon_px, region.polygon_px)


@pytest.mark.parametrize("engine", ENGINES)
def test_divergence_and_growth_of_one_known_step(engine: str) -> None:
    pair = linear_pair(2.0)
    tracker = FlowTracker(FlowSettings(engine=engine))
    tracker.start(pair.first, Region.circle(*pair.contact.centre_px, 80))
    step = tracker.step(pair.second)
    tolerance = {"pin-affine": 0.01, "horn-schunck": 0.03, "dis": 0.08}[engine]
    assert step.divergence == pytest.approx(pair.divergence, rel=tolerance)
    assert step.log_growth == pytest.approx(2 * np.log1p(pair.divergence / 2), rel=tolerance)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_camera_that_reuses_its_buffer(engine: str) -> None:
    pair = linear_pair(2.0)
    buffer = pair.first.copy()
    tracker = FlowTracker(FlowSettings(engine=engine))
    tracker.start(buffer, Region.circle(150, 150, 70))
    buffer[:] = pair.second
    assert tracker.step(buffer).log_growth > 0.02


def test_pins_beside_a_region_found_too_large_do_harm_only_outside_its_core() -> None:
    images, contacts = press("S5", 0.0)
    true = np.log(contacts[-1].area_px2 / contacts[0].area_px2)
    larger = region_of(contacts[0], 1.3)
    assert total_growth("pin-affine", images, larger)[0] == pytest.approx(true, rel=0.03)
    assert total_growth("pin-affine", images, larger, core_fraction=1.0)[0] < 0.92 * true


def test_missing_pins_glare_and_dirt() -> None:
    images, contacts = press("S5", 30.0, n_missing=12, n_glare=3, dirt_grey=5.0, noise_grey=4.0)
    true = np.log(contacts[-1].area_px2 / contacts[0].area_px2)
    assert total_growth("pin-affine", images, region_of(contacts[0]))[0] == pytest.approx(true, rel=0.02)


def test_a_region_with_too_few_pins_takes_the_next_ones_and_says_so() -> None:
    images, contacts = press("S5", 0.0)
    *_, notes = total_growth("pin-affine", images[:3], region_of(contacts[0], 0.3))
    assert any("lie outside the region" in note for note in notes)


@pytest.mark.parametrize("engine", ENGINES)
def test_mistakes_are_named(engine: str) -> None:
    image = linear_pair(1.0).first
    tracker = FlowTracker(FlowSettings(engine=engine))
    with pytest.raises(ImageError, match="call start"):
        tracker.step(image)
    tracker.start(image, Region.circle(150, 150, 60))
    with pytest.raises(ImageError, match="one shape"):
        tracker.step(image[10:])
    if engine != "pin-affine":
        with pytest.raises(SettingError, match="meets the image"):
            tracker.start(image, Region.circle(900, 900, 60))


def test_the_default_engine_loads_neither_numba_nor_scipy() -> None:
    code = "import sys, casr.flow.estimate as e; e.FlowTracker(); sys.exit(bool({'numba', 'scipy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("engine", "said"),
    [
        ("pin-affine", ""),
        ("dis", ""),
        (
            "horn-schunck",
            "flow engine horn-schunck: expected the package numba, which compiles this engine, but found no such "
            "package. "
            'Install it (pip install ".[flow]" in the folder of the sources), or choose another engine: '
            "pin-affine or dis.\n",
        ),
    ],
)
def test_without_numba_only_its_own_engine_is_refused(engine: str, said: str) -> None:
    code = f"""
import sys
sys.modules["numba"] = None
from casr.errors import CasrError
from casr.flow.estimate import FlowSettings, FlowTracker
try:
    FlowTracker(FlowSettings(engine={engine!r}))
except CasrError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == said
