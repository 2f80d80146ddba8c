"""Where points of the skin go: exact maps, exact divergence, nothing folds or leaves the image."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from casr.errors import SettingError
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import (
    ContactEllipse,
    ContactWorld,
    PressSettings,
    Rim,
    Scene,
    TabulatedWorld,
    lever,
    spread,
)

RIM = Rim((149.5, 149.5), 140.0)
PRESSES = [(kappa, angle) for kappa in SPECIMENS.values() for angle in (0.0, 30.0, 45.0)]


def _scene(**settings: float) -> Scene:
    return Scene(PressSettings(world=ContactWorld(), **settings))  # type: ignore[arg-type]


def _tilted(scale: float) -> ContactEllipse:
    return ContactEllipse((210.0, 153.0), (22.0 * scale, 31.0 * scale))


def _disc(n_points: int, seed: int = 0, radius_px: float = 139.9) -> np.ndarray:
    rng = np.random.default_rng(seed)
    angle, distance = rng.uniform(0, 2 * np.pi, n_points), radius_px * np.sqrt(rng.uniform(size=n_points))
    return np.column_stack([np.cos(angle), np.sin(angle)]) * distance[:, None] + RIM.centre_px


@pytest.mark.parametrize(("kappa", "angle_deg"), PRESSES)
def test_nothing_folds_or_leaves_the_image(kappa: float, angle_deg: float) -> None:
    for repetition in range(5):
        scene = _scene(stiffness_n_per_mm=kappa, angle_deg=angle_deg, repetition=repetition)
        start, peak = scene.contact(0.5), scene.contact(7.0)
        assert peak.gap_px(scene.rim) > 2
        points = _disc(4000, repetition, 139.0)
        across, down = np.array([[1e-5, 0.0], [0.0, 1e-5]])
        dx = (spread(points + across, start, peak, RIM) - spread(points - across, start, peak, RIM)) / 2e-5
        dy = (spread(points + down, start, peak, RIM) - spread(points - down, start, peak, RIM)) / 2e-5
        assert (dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0]).min() > 0.05
        for force_n in (0.1, 0.5, 2.0, 7.0):
            pins = scene.pins_px(force_n)
            assert np.hypot(*(pins - RIM.centre_px).T).max() < RIM.radius_px
            apart = np.hypot(*(pins[:, None] - pins[None]).transpose(2, 0, 1))[np.triu_indices(len(pins), 1)]
            assert apart.min() > 5
            # between a wide tilted contact and the rim a few pins may touch, never at 0 degrees
            assert (apart < 2 * scene.settings.skin.pin_radius_px).sum() <= (3 if angle_deg else 0)


def test_pins_inside_show_their_place_on_the_skin_and_those_far_away_rest() -> None:
    contact = ContactEllipse(RIM.centre_px, (40.0, 40.0))
    rest = np.array([[149.5 + 18.0, 149.5], [149.5, 149.5 - 36.0], [149.5 + 139.9, 149.5]])
    moved = lever(rest, contact, RIM, 0.1) - RIM.centre_px
    np.testing.assert_allclose(moved[:2], [[20.0, 0.0], [0.0, -40.0]], rtol=0, atol=1e-9)
    assert abs(moved[2, 0] - 139.9) < 0.01


def test_displacement_at_the_edge_is_the_lever_ratio() -> None:
    contact, ratio = ContactEllipse(RIM.centre_px, (30.0, 30.0)), 0.15
    just = np.array([[149.5 + 30 * (1 - ratio) * (1 + side), 149.5] for side in (-1e-9, 1e-9)])
    moved = lever(just, contact, RIM, ratio)[:, 0] - just[:, 0]
    np.testing.assert_allclose(moved, ratio * 30, rtol=1e-3)


def test_pins_move_smoothly_from_rest_through_first_contact() -> None:
    scene = _scene(angle_deg=30.0)
    forces = np.concatenate([[-0.1, 0.0], np.geomspace(1e-12, 7, 400)])
    steps = np.diff([scene.pins_px(force) for force in forces.tolist()], axis=0)
    assert np.abs(steps).max() < 1.5
    stick_n = scene.settings.world.stick_force_n
    assert np.abs(scene.pins_px(stick_n + 1e-9) - scene.pins_px(stick_n)).max() < 1e-6
    np.testing.assert_array_equal(scene.pins_px(0.0), scene.rest_px)


def test_pin_motion_in_loading_is_the_true_flow() -> None:
    scene = _scene(angle_deg=30.0)
    expected = spread(scene.pins_px(2.0), scene.contact(2.0), scene.contact(3.0), scene.rim)
    np.testing.assert_allclose(scene.pins_px(3.0), expected, rtol=0, atol=1e-9)


def test_skin_grows_from_the_force_on_at_which_it_sticks() -> None:
    scene = _scene()
    assert scene.skin_growth(0.1, 0.4) == 0
    assert scene.skin_growth(0.2, 2.0) == pytest.approx(np.log(scene.area_mm2(2.0) / scene.area_mm2(0.43)), rel=1e-12)


def test_contact_that_reaches_the_rim_is_refused() -> None:
    with pytest.raises(SettingError, match="rim"):
        Scene(PressSettings(stiffness_n_per_mm=1.11, angle_deg=45.0, world=ContactWorld(sensor_modulus_mpa=0.02)))


def test_overload_grows_the_contact_no_further_than_the_rim() -> None:
    scene = _scene(stiffness_n_per_mm=1.11, angle_deg=45.0)
    assert scene.contact(1000.0).gap_px(scene.rim) > 1.9
    assert scene.contact(7.0).area_px2 < scene.contact(1000.0).area_px2


@pytest.mark.parametrize("angle_deg", [0.0, 45.0])
@pytest.mark.parametrize("world", [ContactWorld(), TabulatedWorld()], ids=["sticking", "finite-elements"])
def test_friction_pulls_the_skin_of_the_contact_the_way_the_surface_climbs(world, angle_deg: float) -> None:
    scene = Scene(PressSettings(world=world, angle_deg=angle_deg, centre_sd_mm=0.0, stiffness_n_per_mm=1.11))
    state = scene.skin.state(5.0)
    free_px, pulled_px = scene.pins_px(state), scene.pins_px(replace(state, tangential_mm=0.5))
    moved_px = pulled_px - free_px
    contact = scene.contact(state)
    inside, far = contact.depth(free_px) < 0.4, contact.depth(free_px) > 2
    assert np.count_nonzero(inside) > 0
    along_px = 0.5 * np.cos(np.radians(angle_deg)) / scene.settings.camera.mm_per_px[0]
    # tips of a tilted dome come nearer to the camera as well, and so seem to go farther
    most = 1.001 if isinstance(world, ContactWorld) else 1.2 if angle_deg == 0 else 2.0
    assert np.all((moved_px[inside, 0] > 0.96 * along_px) & (moved_px[inside, 0] < most * along_px))
    assert np.abs(moved_px[inside, 1]).max() < 0.3 * along_px
    assert np.all(np.hypot(*moved_px[far].T) < 0.35 * along_px)
    farthest = np.hypot(*(free_px - contact.centre_px).T).argmax()
    assert np.hypot(*moved_px[farthest]) < 0.2 * along_px
    assert scene.area_mm2(replace(state, tangential_mm=0.5)) == scene.area_mm2(state)


@settings(max_examples=50, deadline=None)
@given(st.floats(0.5, 2.0), st.floats(0.5, 2.0), st.integers(0, 10**6))
def test_maps_compose_and_the_same_contact_moves_nothing(first: float, second: float, seed: int) -> None:
    """So the inverse is the map with the contacts exchanged."""
    points = np.vstack([_disc(500, seed), [_tilted(1.0).centre_px, (0.0, 0.0), (299.0, 10.0)]])
    there = spread(spread(points, _tilted(1.0), _tilted(first), RIM), _tilted(first), _tilted(second), RIM)
    np.testing.assert_allclose(there, spread(points, _tilted(1.0), _tilted(second), RIM), rtol=0, atol=1e-9)
    back = spread(there, _tilted(second), _tilted(1.0), RIM)
    np.testing.assert_allclose(back, points, rtol=0, atol=1e-9)


def test_the_edge_becomes_the_edge_and_the_rim_rests() -> None:
    angle = np.linspace(0, 2 * np.pi, 100)
    on_rim = np.column_stack([np.cos(angle), np.sin(angle)]) * RIM.radius_px + RIM.centre_px
    beyond = 1.2 * (on_rim - RIM.centre_px) + RIM.centre_px
    for resting in (on_rim, beyond):
        np.testing.assert_allclose(spread(resting, _tilted(1.0), _tilted(1.8), RIM), resting, rtol=0, atol=1e-9)
    moved = spread(_tilted(1.0).polygon_px(), _tilted(1.0), _tilted(1.8), RIM)
    np.testing.assert_allclose(_tilted(1.8).depth(moved), 1.0, rtol=1e-12)


def test_inside_the_skin_stretches_evenly() -> None:
    before, after = ContactEllipse(RIM.centre_px, (40.0, 55.0)), ContactEllipse(RIM.centre_px, (42.0, 57.75))
    points = _disc(500)
    inside = points[before.depth(points) < 1]
    from_centre = inside - before.centre_px
    np.testing.assert_allclose(spread(inside, before, after, RIM) - inside, 0.05 * from_centre, rtol=1e-9, atol=1e-12)
