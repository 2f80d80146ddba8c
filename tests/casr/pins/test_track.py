from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.tactile.flow_pairs import contact_pair
from casr.flow.pin_engine import fit_affine
from casr.pins import PinTracker, detect_pins, match_pins
from emg2vsa.worlds.tactile import Skin

CENTRE = np.array([149.5, 149.5])
SharedData = Callable[[str], Path]


def started(frame, true_px, settings=None):
    """A tracker, and the ids of the true pins."""
    tracker = PinTracker(settings)
    pins = tracker.start(frame)
    true_rows, ids = match_pins(true_px, pins.centroids_px, max_distance_px=3)
    assert len(true_rows) == len(true_px)
    return tracker, ids


def worst_px(tracked_px, true_px):
    return np.hypot(*(tracked_px - true_px).T).max()


@pytest.mark.parametrize("rim_motion_px", [0.25, 1.0, 3.0])
def test_divergence_of_a_contact_is_unbiased(rim_motion_px):
    errors = []
    for seed in range(20):
        pair = contact_pair(rim_motion_px, seed)
        tracker = PinTracker()
        before = tracker.start(pair.first).centroids_px
        after = tracker.step(pair.second)
        assert len(before) == 127
        core = np.hypot(*(before - CENTRE).T) < 64
        errors.append(np.trace(fit_affine(before[core], after[core]).matrix) / pair.divergence - 1)
    standard_error = np.std(errors) / np.sqrt(len(errors))
    assert abs(np.mean(errors)) < 0.003 + 2 * standard_error
    # noise alone, which the motion dilutes
    assert np.std(errors) < 0.005 / rim_motion_px


def test_a_repeated_frame_moves_nothing_at_all(draw, hexagon_px):
    first, second = draw(hexagon_px), draw(hexagon_px + 0.4)
    tracker, _ = started(first, hexagon_px)
    moved = tracker.step(second)
    again = tracker.step(second.copy())
    assert np.array_equal(moved, again)
    assert not fit_affine(moved, again).matrix.any()


@pytest.mark.parametrize("angle_deg", [0, 30, 77])
@pytest.mark.parametrize("pitches", [0.2, 0.45, 0.6, 0.7])
def test_a_jump_of_the_whole_skin_is_followed(draw, hexagon_px, pitches, angle_deg):
    rest = CENTRE + 0.85 * (hexagon_px - CENTRE)
    jumped = rest + 17 * pitches * np.array([np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))])
    tracker, ids = started(draw(rest), rest)
    assert worst_px(tracker.step(draw(jumped))[ids], jumped) < 0.1


@pytest.mark.parametrize(
    "gradient", [[[0.1, 0], [0, 0.1]], [[0, 0.12], [0, 0]], [[0, -0.15], [0.15, 0]], [[-0.1, 0], [0, 0.1]]]
)
def test_motion_that_grows_beyond_half_a_pitch_is_followed(draw, hexagon_px, gradient):
    rest = CENTRE + 0.8 * (hexagon_px - CENTRE)
    strained = rest + (rest - CENTRE) @ np.array(gradient).T
    assert np.hypot(*(strained - rest).T).max() > 8.5
    tracker, ids = started(draw(rest), rest)
    assert worst_px(tracker.step(draw(strained))[ids], strained) < 0.1


def test_331_pins_sheared_far_beyond_half_a_pitch_step_by_step(draw):
    dense = Skin(rings=10, pitch_px=12.4, pin_radius_px=2.8)
    rest = dense.pins_px((140.0, 149.5)) * 0.95 + 7
    bump = np.exp(-((np.hypot(*(rest - CENTRE).T) / 60) ** 2))[:, None] * np.array([18.0, 4.0])
    tracker, ids = started(draw(rest, skin=dense), rest)
    for share in np.linspace(0, 1, 13)[1:]:
        now = tracker.step(draw(rest + share * bump, skin=dense))
    assert worst_px(now[ids], rest + bump) < 0.15


def test_hidden_pins_are_nan_and_come_back_to_their_ids(draw, hexagon_px):
    tracker, ids = started(draw(hexagon_px), hexagon_px)
    hidden = np.hypot(*(hexagon_px - (150, 150)).T) < 25
    for k in range(1, 9):
        true_px = hexagon_px + np.array([1.5, 0.5]) * k
        frame = draw(true_px)
        if 3 <= k <= 6:
            x, y = (149.5 + 1.5 * k, 149.5 + 0.5 * k)
            cv2.circle(frame, (round(x), round(y)), 31, 20, -1)
        now = tracker.step(frame)[ids]
        lost = np.isnan(now).any(axis=1)
        if 3 <= k <= 6:
            assert lost[hidden].all()
            assert worst_px(now[~lost], true_px[~lost]) < 1.0
        else:
            assert not lost.any()
            assert worst_px(now, true_px) < 0.1


def test_no_two_ids_share_a_pin_when_one_pin_goes(draw, hexagon_px):
    tracker, ids = started(draw(hexagon_px), hexagon_px)
    gone = hexagon_px.copy()
    gone[63] = -50.0, -50.0
    for _ in range(3):
        now = tracker.step(draw(gone))[ids]
        assert np.isnan(now[63]).all()
        assert worst_px(np.delete(now, 63, axis=0), np.delete(hexagon_px, 63, axis=0)) < 0.1


def test_a_black_frame_loses_all_pins_and_the_next_finds_them(draw, hexagon_px):
    tracker, ids = started(draw(hexagon_px), hexagon_px)
    assert np.isnan(tracker.step(np.zeros((300, 300), np.uint8))).all()
    assert worst_px(tracker.step(draw(hexagon_px))[ids], hexagon_px) < 0.1


def with_reflection(frame, at_px, radius_px=8):
    y, x = np.ogrid[:300, :300]
    return np.where(np.hypot(x - at_px[0], y - at_px[1]) <= radius_px, np.uint8(220), frame)


def test_a_reflection_on_one_pin_does_not_move_the_others_by_a_pitch(draw, hexagon_px):
    tracker, ids = started(draw(hexagon_px), hexagon_px)
    few = np.flatnonzero(np.hypot(*(hexagon_px - hexagon_px[63]).T) < 30)
    leftmost = few[hexagon_px[few, 0].argmin()]
    beside = np.hypot(*(hexagon_px - hexagon_px[leftmost]).T).argsort()[1:]
    outside = next(row for row in beside if hexagon_px[row, 0] < hexagon_px[leftmost, 0] - 15)
    for _ in range(2):
        now = tracker.step(with_reflection(draw(hexagon_px), hexagon_px[outside] + 3))[ids]
        assert worst_px(now[few], hexagon_px[few]) < 0.1


def test_a_pin_that_slides_under_a_reflection_is_lost_and_not_held_by_it(draw, hexagon_px):
    tracker, ids = started(draw(hexagon_px), hexagon_px)
    reflection_px = hexagon_px[63] + (16.0, 10.0)
    for k in range(1, 20):
        true_px = hexagon_px + np.array([0.8 * k, 0.0])
        now = tracker.step(with_reflection(draw(true_px), reflection_px))[ids]
        seen = np.isfinite(now[:, 0])
        assert worst_px(now[seen], true_px[seen]) < 1.0
    assert not seen[63]


def test_real_flat_press_keeps_every_pin_and_its_growth(shared_data: SharedData):
    folder = shared_data("tactile/tactip127_flat_press_640x480")
    paths = sorted(folder.glob("*.png"), key=lambda path: int(path.name.split("_")[0]))
    frames = [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in paths]
    tracker = PinTracker()
    rest = tracker.start(frames[0]).centroids_px
    places = np.stack([rest, *(tracker.step(frame) for frame in frames[1:])])
    assert np.isnan(places[:, :, 0]).sum(axis=1).max() <= 1
    for place, frame in zip(places[::10], frames[::10], strict=True):
        seen = place[np.isfinite(place[:, 0])]
        i, _ = match_pins(seen, detect_pins(frame).centroids_px, max_distance_px=0.05)
        assert len(i) == len(seen)
    core = np.hypot(*(rest - rest.mean(axis=0)).T) < 60
    summed = sum(np.log(np.linalg.det(np.eye(2) + fit_affine(a[core], b[core]).matrix)) for a, b in pairwise(places))
    hull_px2 = [cv2.contourArea(cv2.convexHull(place[core].astype(np.float32))) for place in (places[0], places[-1])]
    assert summed == pytest.approx(np.log(hull_px2[1] / hull_px2[0]), rel=0.02)


def torn(frame, by_px):
    whole = frame.copy()
    whole[130:] = np.roll(whole[130:], by_px, axis=1)
    return whole


@pytest.mark.parametrize("by_px", [6, 10, 20, 33])
def test_a_torn_frame_shows_no_pin_and_leaves_no_trace(draw, hexagon_px, by_px):
    tracker, ids = started(draw(hexagon_px), hexagon_px)
    tracker.step(draw(hexagon_px + 0.5))
    assert np.isnan(tracker.step(torn(draw(hexagon_px + 1.0), by_px))).all()
    assert worst_px(tracker.step(draw(hexagon_px + 1.5))[ids], hexagon_px + 1.5) < 0.1


def test_what_stays_torn_is_believed_in_the_end(draw, hexagon_px):
    tracker, _ = started(draw(hexagon_px), hexagon_px)
    tracker.step(draw(hexagon_px))
    seen = [np.isfinite(tracker.step(torn(draw(hexagon_px), 6))[:, 0]).mean() for _ in range(4)]
    assert seen[:2] == [0, 0]
    assert min(seen[2:]) > 0.8


def test_noise_in_place_of_pins_is_not_believed(draw, hexagon_px):
    tracker, ids = started(draw(hexagon_px), hexagon_px)
    noise = np.random.default_rng(0)
    for _ in range(4):
        assert np.isnan(tracker.step(noise.integers(0, 256, (300, 300)).astype(np.uint8))).all()
    assert worst_px(tracker.step(draw(hexagon_px))[ids], hexagon_px) < 0.1


@pytest.mark.parametrize("knock_px", [(40, 0), (20, 34.64), (-30, 17.32), (0, -60), (12, 5)])
def test_a_knock_by_whole_pitches_is_found_by_the_border(draw, hexagon_px, knock_px):
    wide = [np.pad(draw(hexagon_px), 100) for _ in range(3)]
    tracker, ids = started(wide[0], hexagon_px + 100)
    tracker.step(wide[1])
    shift = np.array(knock_px, float)
    moved = cv2.warpAffine(wide[2], np.array([[1, 0, shift[0]], [0, 1, shift[1]]]), (500, 500))
    for repeat in range(2):
        assert worst_px(tracker.step(moved)[ids], hexagon_px + 100 + shift) < 0.3
        assert tracker.knock_px == pytest.approx(shift, abs=0.1)
        assert bool(tracker.notes) == (repeat == 0)
