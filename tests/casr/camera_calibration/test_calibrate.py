"""Cameras found again from pictures of boards, and sets of pictures that tell no camera."""

from __future__ import annotations

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from casr.camera_calibration import Charuco, Chessboard, View, calibrate, unusable
from casr.camera_calibration.boards import DICTIONARIES
from casr.errors import CameraError

CHARUCO = Charuco(7, 5, square_mm=6.0, marker_mm=4.5)
CHESSBOARD = Chessboard(7, 5, square_mm=4.0)
NAMES = ("fx", "fy", "cx", "cy")


def views_of(board, pictures):
    views = [View(str(number), *board.find(picture)) for number, picture in enumerate(pictures)]
    return [view for view in views if unusable(view, board.n_corners) is None]


def errors_in_se(found, camera):
    return np.array([
        (getattr(found, f"{name}_px") - getattr(camera, f"{name}_px")) / getattr(found, f"{name}_se_px")
        for name in NAMES
    ])  # fmt: skip


@pytest.fixture(scope="module")
def charuco_views(studio):
    return views_of(CHARUCO, studio.pictures(studio.charuco(7, 5, 6.0, 4.5), 12, seed=1))


@pytest.mark.parametrize("kind", ["charuco", "chessboard"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_known_camera_is_found_within_a_few_of_its_standard_errors(studio, kind, seed):
    if kind == "charuco":
        board, pictures = CHARUCO, studio.pictures(studio.charuco(7, 5, 6.0, 4.5), 12, seed)
    else:
        board, pictures = CHESSBOARD, studio.pictures(studio.chessboard(8, 6, 4), 12, seed, distance_mm=40, reach=0.25)
    found = calibrate(views_of(board, pictures), 320, 240)
    assert np.abs(errors_in_se(found, studio.camera)).max() < 3.5
    assert found.fx_se_px / found.fx_px < 0.003
    assert found.rms_px < 0.3
    assert found.covered > 0.4
    assert len(found.views) == 12
    assert all(0 < view.rms_px < 0.3 and 10 < view.tilt_deg < 34 for view in found.views)
    # what counts in the end: where pins are seen, over the part of the image that boards covered
    there_px = np.mgrid[60:261:50, 50:191:35].reshape(2, -1).T.astype(float)
    again = replace(studio.camera, **{f"{n}_px": getattr(found, f"{n}_px") for n in NAMES}, distortion=found.distortion)
    rays = [
        (camera.undistorted_px(there_px) - (camera.cx_px, camera.cy_px)) / (camera.fx_px, camera.fy_px)
        for camera in (studio.camera, again)
    ]
    assert np.abs(rays[0] - rays[1]).max() * studio.camera.fx_px < 0.6


def test_standard_errors_are_the_scatter_of_many_calibrations(studio):
    """Exact corners with noise of 0.1 px, again and again: errors in units of their standard error have size one."""
    rng = np.random.default_rng(0)
    scaled = []
    for _ in range(40):
        found = calibrate(projected(studio.camera, rng, noise_px=0.1, tilt_deg=(12, 32)), 320, 240)
        scaled.append(errors_in_se(found, studio.camera))
    size = np.sqrt(np.mean(np.square(scaled), axis=0))
    # of 40 draws: 1 within 3 x 1/sqrt(80); the larger of two estimates makes it a little smaller
    assert (size > 0.6).all()
    assert (size < 1.34).all()


def projected(camera, rng, *, noise_px, tilt_deg, count=10, one_way=False):
    """Views by projection alone; ``one_way``: all boards parallel to each other."""
    corners = np.zeros((24, 3), np.float32)
    corners[:, :2] = np.mgrid[:6, :4].reshape(2, -1).T * 6.0
    views = []
    for number in range(count):
        way, tilt = (0.3, tilt_deg[1]) if one_way else (rng.uniform(0, 2 * np.pi), rng.uniform(*tilt_deg))
        turn = np.deg2rad(tilt) * np.array([np.cos(way), np.sin(way), 0.0])
        middle = np.array([*rng.uniform(-0.6, 0.6, 2) * (20, 15), rng.uniform(38, 46)])
        shift = middle - cv2.Rodrigues(turn)[0] @ corners.astype(float).mean(axis=0)
        seen = cv2.projectPoints(corners.astype(float), turn, shift, camera.matrix, np.array(camera.distortion))[0]
        image_px = seen[:, 0] + rng.normal(0, noise_px, (len(corners), 2))
        views.append(View(str(number), corners, image_px.astype(np.float32)))
    return views


@pytest.mark.parametrize(("noise_px", "tilt_deg"), [(0.0, 0.0), (0.1, 0.0), (0.1, 15.0)])
def test_parallel_views_are_refused_however_small_opencv_calls_the_error(studio, noise_px, tilt_deg):
    rng, tilts = np.random.default_rng(3), (tilt_deg, tilt_deg)
    views = projected(studio.camera, rng, noise_px=noise_px, tilt_deg=tilts, one_way=True)
    with pytest.raises(
        CameraError, match=r"focal length: expected standard errors .* 1% or less, but found .*tilt the board"
    ):
        calibrate(views, 320, 240)


def test_too_few_views(charuco_views):
    with pytest.raises(CameraError, match="pictures: expected 5 or more that show the board, but found 4"):
        calibrate(charuco_views[:4], 320, 240)


def test_boards_in_the_middle_of_a_larger_image(charuco_views):
    with pytest.raises(CameraError, match=r"expected boards over 40% of the image or more, but found 1\d%"):
        calibrate(charuco_views, 640, 480)


def test_corners_that_no_camera_sees_so(charuco_views):
    rng = np.random.default_rng(0)
    moved = [
        View(view.name, view.board_mm, view.image_px + rng.normal(0, 3, view.image_px.shape).astype(np.float32))
        for view in charuco_views
    ]
    with pytest.raises(CameraError, match=r"reprojection error: expected 1 px rms or less, but found 3\.\d\d px"):
        calibrate(moved, 320, 240)


def test_a_picture_that_stands_out_is_named(charuco_views):
    assert calibrate(charuco_views, 320, 240).notes == ()
    (note,) = calibrate(with_one_bent(charuco_views, 0.5), 320, 240).notes
    assert note.startswith("bent fits worse than the others, 0.")
    with pytest.raises(CameraError, match=r"focal length: .*, but found 1\.\d.* bent fits worse than the others, "):
        calibrate(with_one_bent(charuco_views, 5.0), 320, 240)
    with pytest.raises(CameraError, match=r"reprojection error: .*, but found 1\.0\d px\. bent fits worse"):
        calibrate(with_one_bent(charuco_views, 8.0), 320, 240)


def with_one_bent(views, bow_px):
    """A board whose rim lies up to ``bow_px`` beside where a flat one has it."""
    across = views[3].image_px - views[3].image_px.mean(axis=0)
    bow = (across / np.abs(across).max(axis=0)) ** 2 * np.float32(bow_px)
    return [*views[:3], View("bent", views[3].board_mm, views[3].image_px + bow), *views[4:]]


@pytest.mark.parametrize("n_distortion", [0, 4, 5, 8])
def test_as_many_coefficients_as_asked_for(studio, n_distortion):
    straight = type(studio.camera)(width_px=320, height_px=240, fx_px=262, fy_px=266, cx_px=164, cy_px=116)
    views = projected(straight, np.random.default_rng(0), noise_px=0.05, tilt_deg=(12, 32), count=14)
    found = calibrate(views, 320, 240, n_distortion=n_distortion)
    assert len(found.distortion) == n_distortion
    assert np.abs(errors_in_se(found, straight)).max() < 3.5


def test_a_board_of_old_is_found_too(studio):
    drawing = studio.charuco(7, 6, 6.0, 4.5, legacy=True)
    (picture,) = studio.pictures(drawing, 1, seed=0, distance_mm=45, reach=0.0)
    board = Charuco(7, 6, square_mm=6.0, marker_mm=4.5)
    board_mm, image_px = board.find(picture)
    assert len(board_mm) == board.n_corners
    assert len(image_px) == board.n_corners


def test_corners_are_where_the_board_is(studio):
    """Both kinds against the projection of what was drawn."""
    rng = np.random.default_rng(0)
    turn, middle_mm, camera = np.array([0.3, -0.2, 0.0]), np.array([1.0, -2.0, 42.0]), studio.camera
    boards = [(CHARUCO, studio.charuco(7, 5, 6.0, 4.5), 0.0), (CHESSBOARD, studio.chessboard(8, 6, 4), 4.0)]
    for board, drawing, rim_mm in boards:
        board_mm, image_px = board.find(studio.picture(drawing, turn, middle_mm, rng))
        drawn_mm = board_mm.astype(float) + np.array([rim_mm, rim_mm, 0.0])
        shift = middle_mm - cv2.Rodrigues(turn)[0] @ np.array([*drawing.size_mm, 0.0]) / 2
        both = [
            cv2.projectPoints(mm, turn, shift, camera.matrix, np.array(camera.distortion))[0][:, 0]
            for mm in (drawn_mm, np.array([*drawing.size_mm, 0.0]) - drawn_mm)
        ]
        # a chessboard looks the same turned by half a turn
        assert min(np.abs(image_px - px).max() for px in both) < 0.35
        assert len(image_px) == board.n_corners


def test_views_that_say_too_little():
    def view(columns, rows):
        corners = np.zeros((columns * rows, 3), np.float32)
        corners[:, :2] = np.mgrid[:columns, :rows].reshape(2, -1).T
        return View("a", corners, corners[:, :2] * 10)

    assert unusable(view(0, 0), 24) == "it shows no board"
    assert unusable(view(7, 1), 24) == "it shows 7 of 24 corners, fewer than 8"
    assert unusable(view(9, 1), 24) == "its corners lie on one line"
    assert unusable(view(4, 2), 24) is None


def test_they_are_all_square_ones_of_opencv() -> None:
    known = [name.removeprefix("DICT_") for name in dir(cv2.aruco) if re.match("DICT_[4-7]", name)]
    assert sorted(DICTIONARIES) == sorted(known)
