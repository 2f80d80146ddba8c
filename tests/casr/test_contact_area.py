"""Initial area: rules against the known contact of a simulated skin and a real press."""

from __future__ import annotations

import re

import numpy as np
import pytest

from casr.camera import Camera
from casr.contact_area import initial_area
from casr.contact_area.edge import DisplacementField, fit_edge
from casr.contact_area.motion import PinMotion, array_area_px2, check_area
from casr.errors import AreaError, NoContactError
from casr.flow.region import Region
from casr.pins import Pins, detect_pins, match_pins
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import TACTIP_127, ContactEllipse, ContactWorld, Rim, lever, spread

CENTRE = (149.5, 149.5)
RIM = Rim(CENTRE, 140.0)
REST = TACTIP_127.pins_px(CENTRE)
HEXAGON_PX2 = np.sqrt(3) / 2 * 20**2


def as_pins(points):
    return Pins(centroids_px=points, area_px=np.full(len(points), 64.0), notes=())


def first_contact(rng, specimen="S3", angle_deg=0.0, noise_px=0.02, force_n=0.5):
    """Pins at rest and in contact, and the true ellipse; the contact is off its place by half a millimetre."""
    world, tilt = ContactWorld(), np.deg2rad(angle_deg)
    centre = np.array([CENTRE[0] + 120 * np.sin(tilt), CENTRE[1]]) + 3 * rng.normal(size=2)

    def ellipse(force_n):
        radius_px = 6 * float(world.radius_mm(force_n, SPECIMENS[specimen]))
        return ContactEllipse((float(centre[0]), float(centre[1])), (radius_px * float(np.cos(tilt)), radius_px))

    touch, now = ellipse(world.stick_force_n), ellipse(force_n)
    contact = spread(lever(REST, touch, RIM, 0.1), touch, now, RIM)
    noise = noise_px * rng.normal(size=(2, *REST.shape))
    return as_pins(REST + noise[0]), contact + noise[1], now


def moved_by_3_px(*rows):
    contact = REST.copy()
    contact[list(rows)] += (3.0, 0.0)
    return contact


def ring_around(row):
    return np.flatnonzero(np.abs(np.hypot(*(REST - REST[row]).T) - 20) < 1)


MIDDLE = 63


@pytest.mark.parametrize("angle_deg", [0, 30, 45])
@pytest.mark.parametrize("specimen", ["S1", "S3", "S5"])
@pytest.mark.parametrize("force_n", [0.5, 0.65, 0.8])
def test_edge_finds_the_true_area_and_outline_whatever_is_touched_and_how_hard(specimen, angle_deg, force_n):
    rng = np.random.default_rng(11)
    errors, overlaps = [], []
    for _ in range(3):
        rest, contact, truth = first_contact(rng, specimen, angle_deg, force_n=force_n)
        found = initial_area(rest, contact, rule="edge", camera=Camera())
        assert found.rule == "edge"
        errors.append(found.area_px2 / truth.area_px2 - 1)
        grid = np.stack(np.meshgrid(*[np.arange(0.0, 300, 3)] * 2), axis=-1).reshape(-1, 2)
        ours, true = Region(found.polygon_px).contains(grid), truth.depth(grid) < 1
        overlaps.append((ours & true).sum() / (ours | true).sum())
    assert max(np.abs(errors)) < 0.03
    assert min(overlaps) > 0.95


def test_edge_follows_rotation_translation_and_scale_of_the_pins():
    rest, contact, _ = first_contact(np.random.default_rng(2), "S5", noise_px=0.0)
    area = initial_area(rest, contact, rule="edge").area_px2
    turn, scale = np.deg2rad(17), 1.3
    matrix = scale * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    moved = initial_area(as_pins(rest.centroids_px @ matrix.T + 40), contact @ matrix.T + 40, rule="edge").area_px2
    assert moved == pytest.approx(scale**2 * area, rel=0.01)


def test_edge_survives_lost_and_misplaced_pins():
    rest, contact, truth = first_contact(np.random.default_rng(3), "S5")
    contact[[5, 40, 66]] = np.nan
    contact[[20, 100]] += 15.0
    found = initial_area(rest, contact, rule="edge")
    assert found.rule == "edge"
    assert found.area_px2 == pytest.approx(truth.area_px2, rel=0.1)
    assert not np.isin([5, 40, 66], found.selected).any()
    assert "3 of 127 pins are lost" in " ".join(found.notes)


def test_edge_of_noise_is_no_edge():
    rng = np.random.default_rng(4)
    for _ in range(5):
        contact = REST + 0.1 * rng.normal(size=REST.shape)
        with pytest.raises(NoContactError):
            initial_area(as_pins(REST), contact, rule="edge")


def test_edge_falls_back_to_hexagons_and_says_so():
    found = initial_area(as_pins(REST), moved_by_3_px(*ring_around(MIDDLE)), rule="edge")
    assert found.rule == "hexagon"
    assert "No contact edge" in found.notes[0]


def test_hexagons_count_moved_pins_and_the_still_one_they_enclose():
    found = initial_area(as_pins(REST), moved_by_3_px(*ring_around(MIDDLE)), rule="hexagon")
    assert sorted(found.selected) == sorted([MIDDLE, *ring_around(MIDDLE)])
    assert found.area_px2 == pytest.approx(7 * HEXAGON_PX2)
    assert found.area_mm2 is None
    assert not found.saturated


def test_hexagons_leave_out_a_stray_pin_and_say_so():
    found = initial_area(as_pins(REST), moved_by_3_px(0, *ring_around(MIDDLE)), rule="hexagon")
    assert 0 not in found.selected
    assert "moved apart from the contact are left out: 1" in " ".join(found.notes)


def test_hexagon_area_in_mm2_takes_height_from_fy_and_width_from_fx():
    camera = Camera(fx_px=300, fy_px=250, depth_mm=50)
    found = initial_area(as_pins(REST), moved_by_3_px(*ring_around(MIDDLE)), camera=camera, rule="hexagon")
    radius = 20 / np.sqrt(3)
    apothem_mm, side_mm = radius * np.cos(np.pi / 6) * 50 / 250, 2 * radius * np.sin(np.pi / 6) * 50 / 300
    assert found.area_mm2 == pytest.approx(7 * 6 * side_mm * apothem_mm / 2)


def test_lens_distortion_is_taken_out_before_measuring():
    bent = Camera(distortion=(-0.2, 0.0, 0.0, 0.0))
    moved = moved_by_3_px(*ring_around(MIDDLE))
    pitch = np.sort(np.hypot(*(bent.undistorted_px(REST)[:, None] - bent.undistorted_px(REST)).transpose(2, 0, 1)))[
        :, 1
    ]
    expected = 7 * np.sqrt(3) / 2 * np.median(pitch) ** 2
    assert initial_area(as_pins(REST), moved, camera=bent, rule="hexagon").area_px2 == pytest.approx(expected)
    assert expected > 1.02 * initial_area(as_pins(REST), moved, camera=Camera(), rule="hexagon").area_px2


@pytest.mark.parametrize("rule", ["hexagon", "edge"])
def test_a_shift_of_the_whole_image_changes_nothing_but_the_place(rule):
    rest, contact, _ = first_contact(np.random.default_rng(5), "S5")
    still = initial_area(rest, contact, rule=rule)
    shaken = initial_area(rest, contact + np.array([4.0, -3.0]), rule=rule)
    assert shaken.area_px2 == pytest.approx(still.area_px2, rel=0.02)
    assert shaken.polygon_px.mean(axis=0) - still.polygon_px.mean(axis=0) == pytest.approx([4, -3], abs=0.5)
    assert "common shift" in " ".join(shaken.notes)


def test_saturation_is_flagged():
    found = initial_area(as_pins(REST), CENTRE + 1.3 * (REST - CENTRE), rule="hexagon")
    assert found.saturated
    assert "area of the array" in found.notes[-1]


@pytest.mark.parametrize(("moved", "saturated"), [(114, False), (115, True)])
def test_the_papers_rule_is_saturated_from_nine_tenths_of_the_pins_on(moved, saturated):
    """115 of 127 pins are the first share of 0.9 and more."""
    contact = REST.copy()
    contact[np.argsort(np.linalg.norm(REST - CENTRE, axis=1))[:moved]] += (0.0, 8.0)
    found = initial_area(as_pins(REST), contact, rule="paper")
    assert found.selected.size == moved
    assert found.saturated is saturated


def test_circle_goes_through_the_farthest_pin_of_all_and_knows_no_contact():
    still, pressed = (initial_area(as_pins(REST), c, rule="circle") for c in (REST, moved_by_3_px(3, 4, 5)))
    assert still.area_px2 == pytest.approx(np.pi * 120**2)
    assert pressed.area_px2 == still.area_px2
    assert still.selected.size == 127


def algorithm_1(first, second, pitch_px, threshold_px=2.0):
    """The paper's Algorithm 1 as it must be meant, written out: lists of whole pixels, each pin beside itself."""
    signpin = []
    for (x0, y0), (x1, y1) in zip(first, second, strict=True):
        x0, y0, x1, y1 = int(x0), int(y0), int(x1), int(y1)
        if ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5 > threshold_px:
            signpin.append((x0, y0))
    apothem = pitch_px / 2
    side = 2 * apothem / 3**0.5
    return len(signpin) * 6 * side * apothem / 2


@pytest.mark.parametrize("specimen", SPECIMENS)
def test_paper_is_algorithm_1_with_pins_paired_one_to_one(specimen):
    rest, contact, _ = first_contact(np.random.default_rng(3), specimen, force_n=1.0)
    contact[5] = np.nan  # a lost pin is no pair
    found = initial_area(rest, contact, rule="paper")
    seen = np.isfinite(contact[:, 0])
    pitch_px = np.median(np.sort(np.hypot(*(rest.centroids_px[:, None] - rest.centroids_px).transpose(2, 0, 1)))[:, 1])
    written_out = algorithm_1(rest.centroids_px[seen].tolist(), contact[seen].tolist(), pitch_px)
    assert written_out > 0
    assert found.area_px2 == pytest.approx(written_out, rel=0.01)
    assert found.selected.size == round(found.area_px2 / HEXAGON_PX2)


def test_paper_cuts_centroids_to_whole_pixels():
    rest = np.floor(REST)
    moved = np.array(rest)
    moved[40:50] += np.array([2.9, 0.0])
    with pytest.raises(NoContactError, match=r"in whole pixels, but found at most 2\.00 px"):
        initial_area(as_pins(rest), moved, rule="paper")
    moved[40:50] += np.array([0.1, 0.0])
    assert initial_area(as_pins(rest), moved, rule="paper").selected.tolist() == list(range(40, 50))


def test_the_pin_array_is_the_hull_and_half_a_pitch():
    side, half = 120.0, 10.0
    hexagon = 3 * np.sqrt(3) / 2 * side**2 + 6 * side * half + np.pi * half**2
    assert array_area_px2(REST) == pytest.approx(hexagon, rel=1e-4)
    lost = np.vstack([REST, [np.nan, np.nan]])
    assert array_area_px2(lost) == pytest.approx(hexagon, rel=1e-4)


@pytest.mark.parametrize(("camera", "unit"), [(None, "px²"), (Camera(), "mm²")])
def test_an_area_above_that_of_the_array_is_an_error_that_says_so(camera, unit):
    array_px2 = array_area_px2(REST)
    check_area(0.999 * array_px2, REST, "area", camera)
    with pytest.raises(AreaError, match=f"at most the area of the pin array, .* {unit}"):
        check_area(1.001 * array_px2, REST, "area", camera)


@pytest.mark.parametrize(("bending", "stretching"), [(0.12, 0.0), (0.08, 0.08), (0.0, 0.12)])
def test_fit_is_exact_for_the_skin_it_assumes(bending, stretching):
    centre, size, rim_px, shift = np.array([160.0, 140.0]), 45.0, 150.0, np.array([0.3, -0.2])
    away = REST - centre
    distance = np.maximum(np.hypot(*away.T), 1e-9)
    inverse = 1 / np.maximum(distance / size, 1)
    bent = (2 / np.pi) * (np.arcsin(inverse) - inverse * np.sqrt(1 - inverse**2))
    along = ((CENTRE - centre) * away).sum(axis=1) / distance
    rim = along + np.sqrt(along**2 + rim_px**2 - ((CENTRE - centre) ** 2).sum())
    held = inverse * np.where(distance > size, (rim - distance) / (rim - size), 1.0)
    moved = shift + away * (bending * bent + stretching * held)[:, None]
    edge = fit_edge(PinMotion(np.arange(len(REST)), REST, REST + moved, moved, 20.0, ()))
    assert edge.centre_px == pytest.approx(centre, abs=0.05)
    assert edge.shift_px == pytest.approx(shift, abs=0.02)
    assert (edge.a_px, edge.b_px) == pytest.approx((size, size), rel=0.003)
    assert edge.stretch == pytest.approx(bending + stretching, rel=0.005)
    assert edge.explained > 0.9999


def test_a_real_flat_press(shared_data):
    import cv2

    folder = shared_data("tactile/tactip127_flat_press_640x480")
    paths = sorted(folder.glob("*.png"), key=lambda path: int(re.match(r"\d+", path.name)[0]))
    rest = detect_pins(cv2.imread(str(paths[0]), cv2.IMREAD_GRAYSCALE))

    def contact(frame):
        found = detect_pins(cv2.imread(str(paths[frame]), cv2.IMREAD_GRAYSCALE))
        tracked = np.full_like(rest.centroids_px, np.nan)
        before, after = match_pins(rest.centroids_px, found.centroids_px, max_distance_px=11.0)
        tracked[before] = found.centroids_px[after]
        return tracked

    with pytest.raises(NoContactError):
        initial_area(rest, contact(10), rule="hexagon")
    early, late = initial_area(rest, contact(19), rule="hexagon"), initial_area(rest, contact(60), rule="hexagon")
    assert early.area_px2 == pytest.approx(24_873, rel=0.06)
    assert not early.saturated
    assert late.area_px2 == pytest.approx(42_931, rel=0.03)
    assert late.saturated

    # plate h mm into a dome of about 140 px, and up to half a millimetre before h is 0: the Hertz radius is sqrt(R h)
    edges = [initial_area(rest, contact(frame), rule="edge") for frame in (24, 40, 90)]
    assert [edge.rule for edge in edges] == ["edge"] * 3
    radii = [np.sqrt(edge.area_px2 / np.pi) for edge in edges]
    assert radii == sorted(radii)
    for radius, depth_mm in zip(radii, (1, 2, 4), strict=True):
        assert 0.9 * 140 * np.sqrt(depth_mm / 20) < radius < 1.3 * 140 * np.sqrt((depth_mm + 0.5) / 20)


def test_edge_of_pins_drawn_together_is_no_edge():
    found = initial_area(as_pins(REST), CENTRE + 0.2 * (REST - CENTRE), rule="edge")
    assert found.rule == "hexagon"


def test_starts_that_are_followed_together_lead_where_each_leads_alone():
    rest = REST
    away = (rest - rest.mean(axis=0)) @ (1, 1j)
    moved = 0.3 * away * np.exp(-((np.abs(away) / 50) ** 2)) + np.random.default_rng(4).normal(size=away.size)
    field = DisplacementField(away, moved, 0j, np.ones(away.size))
    starts = np.array([[2.0, -3.0, np.log(size), 0.0, 0.0, np.log(140.0)] for size in (20.0, 40.0, 80.0)])
    alone = [field.minimised(start[None], 1e-5)[0] for start in starts]
    np.testing.assert_array_equal(field.minimised(starts, 1e-5), alone)
    assert field.cost(alone[0]) < field.cost(starts[0])
