"""Frames: pins where they should be, noise as stated, texture that moves with the skin, dirt that does not."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from casr.camera import Camera
from emg2vsa.worlds.tactile import (
    TACTIP_127,
    Appearance,
    ContactWorld,
    PressSettings,
    Scene,
    Skin,
    draw_surface,
    drawn,
    exposed,
    read_noise,
    spread,
)

QUIET = Appearance(noise_grey=0.0)
CENTRE = (149.5, 149.5)


def _scene(**look: float) -> Scene:
    return Scene(PressSettings(appearance=Appearance(**{"noise_grey": 0.0, **look})))


def _centroids(image: np.ndarray, pins: np.ndarray, background: float, half: int = 8) -> np.ndarray:
    """Weighted centroid of the window around each pin."""
    found = np.empty_like(pins)
    for i, (x, y) in enumerate(np.rint(pins).astype(int)):
        window = image[y - half : y + half + 1, x - half : x + half + 1].astype(float) - background
        rows, columns = np.mgrid[-half : half + 1, -half : half + 1]
        found[i] = (columns * window).sum() / window.sum() + x, (rows * window).sum() / window.sum() + y
    return found


@pytest.mark.parametrize(("skin", "n_pins"), [(TACTIP_127, 127), (Skin(rings=10, pitch_px=12.4), 331)])
def test_pins_lie_on_a_hexagonal_grid(skin: Skin, n_pins: int) -> None:
    pins = skin.pins_px(CENTRE)
    assert pins.shape == (n_pins, 2) == (skin.n_pins, 2)
    np.testing.assert_allclose(pins.mean(axis=0), CENTRE, atol=1e-9)
    apart = np.hypot(*(pins[:, None] - pins[None]).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    np.testing.assert_allclose(apart.min(axis=1), skin.pitch_px, rtol=1e-9)
    assert sorted((apart < 1.01 * skin.pitch_px).sum(axis=1))[-1] == 6


def test_rendered_centroids_are_the_positions() -> None:
    shifted = TACTIP_127.pins_px(CENTRE) + np.random.default_rng(0).uniform(-0.5, 0.5, (127, 2))
    surface = draw_surface(QUIET, TACTIP_127, Camera(), *np.random.default_rng(1).spawn(2))
    error = _centroids(exposed(drawn(shifted, surface, TACTIP_127), 0.0, None), shifted, 20.0) - shifted
    assert np.sqrt((error**2).sum(axis=1).mean()) < 0.005


def test_half_brightness_at_the_pin_radius_and_full_inside() -> None:
    skin = Skin(rings=1, pin_radius_px=6.0)
    pins = skin.pins_px((150.0, 150.0))
    pins[np.arange(7) != 3] = -100.0
    surface = draw_surface(Appearance(pin_grey=(120.0, 120.0)), skin, Camera(), *np.random.default_rng(1).spawn(2))
    image = exposed(drawn(pins, surface, skin), 0.0, None)
    assert image[150, 150] == 140
    assert image[150, 156] == image[144, 150] == 80
    assert image[150, 166] == 20
    assert image[3, 3] == 0


def test_spots_over_the_border_are_cut_not_wrapped() -> None:
    skin = Skin(mask_radius_px=1000.0)
    surface = draw_surface(QUIET, skin, Camera(), *np.random.default_rng(1).spawn(2))
    at = skin.pins_px(CENTRE)
    at[:6] = [[0, 0], [-3, 200], [302, 100], [200, 303], [-40, -40], [400, 150]]
    image = exposed(drawn(at, surface, skin), 0.0, None).astype(int)
    assert min(image[0, 0], image[200, 0], image[100, 299], image[299, 200]) > 60
    assert image[200, 299] == image[100, 0] == 20


def test_noise_has_the_stated_spread_and_is_new_in_every_frame() -> None:
    scene, clean = Scene(PressSettings()), _scene().image(2.0, 0).astype(float)
    first, second = (scene.image(2.0, frame).astype(float) for frame in (0, 1))
    seen = scene.surface.visible > 0
    noise, other = (first - clean)[seen], (second - clean)[seen]
    # rounding to whole grey levels adds 1/12, twice: the clean frame is rounded too
    assert noise.std() == pytest.approx(np.sqrt(4 + 2 / 12), rel=0.01)
    assert abs(noise.mean()) < 0.03
    assert abs(np.corrcoef(noise, other)[0, 1]) < 0.02


def test_texture_moves_with_the_skin() -> None:
    look = {"texture_grey": 12.0, "pin_grey": (0.0, 0.0), "background_grey": 100.0}
    scene = Scene(PressSettings(appearance=Appearance(noise_grey=0.0, **look), world=ContactWorld()))  # type: ignore[arg-type]
    before, after = 3.0, 3.4
    first, second = (scene.image(force, 0).astype(np.float32) for force in (before, after))
    rows, columns = np.mgrid[:300, :300].astype(np.float32)
    grid = np.stack([columns, rows], axis=-1).astype(np.float64)
    flow = (spread(grid, scene.contact(before), scene.contact(after), scene.rim) - grid).astype(np.float32)
    pulled = cv2.remap(second, columns + flow[..., 0], rows + flow[..., 1], cv2.INTER_LINEAR)
    inside = np.hypot(rows - 149.5, columns - 149.5) < 130
    assert first[inside].std() > 6
    still, moved = ((image - first)[inside].std() for image in (second, pulled))
    assert moved < 0.25 * still


def test_missing_pins_are_dark_and_the_same_in_all_presses_of_a_sensor() -> None:
    scenes = [Scene(PressSettings(repetition=r, appearance=Appearance(noise_grey=0, n_missing=5))) for r in (0, 1)]
    gone = [np.flatnonzero(scene.surface.pin_grey == 0) for scene in scenes]
    assert len(gone[0]) == 5
    np.testing.assert_array_equal(*gone)
    x, y = np.rint(scenes[0].rest_px[gone[0][0]]).astype(int)
    assert scenes[0].image(0.0, 0)[y, x] == 20
    assert (scenes[0].surface.pin_grey != scenes[1].surface.pin_grey).any()


NOISE_SHAPE = (301, 299)
N = math.prod(NOISE_SHAPE)


def noise(seed: int, bits: type[np.random.BitGenerator] = np.random.PCG64) -> np.ndarray:
    return read_noise(NOISE_SHAPE, np.random.Generator(bits(seed)))


@pytest.mark.parametrize("bits", [np.random.PCG64, np.random.MT19937])
def test_it_is_normal(bits: type[np.random.BitGenerator]) -> None:
    """Moments within four of their standard errors, and as many beyond each of several limits as there should be.

    The bits come from a generator of 64 bits at a time, and from one of 32.
    """
    drawn = noise(1, bits).astype(np.float64).ravel()
    assert abs(drawn.mean()) < 4 / math.sqrt(N)
    assert abs(drawn.std() - 1) < 4 / math.sqrt(2 * N)
    assert abs((drawn**3).mean()) < 4 * math.sqrt(15 / N)
    assert abs((drawn**4).mean() - 3) < 4 * math.sqrt(96 / N)
    for limit in (-3.0, -1.5, -0.2, 0.4, 1.0, 2.5):
        expected = math.erfc(-limit / math.sqrt(2)) / 2
        assert abs(np.mean(drawn < limit) - expected) < 4 * math.sqrt(expected * (1 - expected) / N)
    assert 3.9 < np.abs(drawn).max() < 4.4


def test_pixels_and_frames_are_independent() -> None:
    first, second = noise(1), noise(2)
    pairs = [(first, second), (first[:, 1:], first[:, :-1]), (first[1:], first[:-1]), (first[:, 4:], first[:, :-4])]
    for one, other in pairs:
        assert abs(np.mean(one * other)) < 4 / math.sqrt(one.size)
        assert abs(np.mean(one**2 * other**2) - 1) < 4 * math.sqrt(8 / one.size)


def test_dirt_and_glare_stay_and_have_the_rms_that_was_asked_for() -> None:
    look = {"dirt_grey": 10.0, "pin_grey": (0.0, 0.0), "background_grey": 60.0}
    scene = _scene(**look)
    first = scene.image(1.0, 0)
    assert first[scene.surface.visible > 0].std() == pytest.approx(10.0, rel=0.1)
    assert (_scene(**look, n_glare=4).image(5.0, 0) > 200).sum() > 50
    np.testing.assert_array_equal(first, scene.image(5.0, 0))
    textured = _scene(texture_grey=10.0, pin_grey=(0.0, 0.0), background_grey=120.0)
    assert textured.image(0.0, 0)[textured.surface.visible > 0].std() == pytest.approx(10.0, rel=0.1)


def test_frames_depend_on_force_and_number_alone() -> None:
    settings = PressSettings(stiffness_n_per_mm=1.11, angle_deg=45.0, repetition=7, seed=3)
    scene = Scene(settings)
    expected = scene.image(2.0, 40)
    scene.image(6.0, 1)
    np.testing.assert_array_equal(scene.image(2.0, 40), expected)
    np.testing.assert_array_equal(Scene(settings).image(2.0, 40), expected)
    assert (scene.image(2.0, 41) != expected).any()
