"""From views of a board to the camera that saw them, with what the fit leaves over and how well each number is known.

The standard errors are not those of ``cv2.calibrateCameraExtended``: it drops directions that the pictures do not
determine, and calls a focal length from parallel views known to 0.02 px when it is 95 px wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import CameraError


@dataclass(frozen=True, eq=False)
class View:
    """A picture in which the board was found.

    name : of the picture, as messages say it. board_mm : (N, 3) float32, corners on the board, z = 0.
    image_px : (N, 2) float32, the same corners in the picture; the centre of the first pixel is (0, 0).
    """

    name: str
    board_mm: NDArray[np.float32]
    image_px: NDArray[np.float32]

    def hull_px(self) -> NDArray[np.float32]:
        """(K, 2) convex outline of the corners in the picture, px."""
        hull: NDArray[np.float32] = cv2.convexHull(self.image_px)[:, 0, :].astype(np.float32)
        return hull


LEAST_CORNERS = 8
"In a view; fewer hardly tell its pose."


def unusable(view: View, n_corners: int) -> str | None:
    """Why the view says too little; None when it does not. n_corners : of the whole board."""
    seen = len(view.image_px)
    if seen == 0:
        return "it shows no board"
    if seen < LEAST_CORNERS:
        return f"it shows {seen} of {n_corners} corners, fewer than {LEAST_CORNERS}"
    spread = np.linalg.svd(view.board_mm[:, :2] - view.board_mm[:, :2].mean(axis=0), compute_uv=False)
    return "its corners lie on one line" if spread[1] < 1e-3 * spread[0] else None


def covered(views: list[View], width_px: int, height_px: int) -> float:
    """Part of the image, 0 to 1, that lies inside the corners of at least one view. Sizes of the image in px."""
    mask = np.zeros((height_px, width_px), dtype=np.uint8)
    for view in views:
        cv2.fillConvexPoly(mask, np.rint(view.hull_px()).astype(np.int32), 1)
    return float(mask.mean())


Array = NDArray[np.float64]

LEAST_VIEWS = 5
LEAST_COVERED = 0.4
"Least share of the image that boards must cover; outside of what boards covered, the distortion is a guess."
MOST_RELATIVE_SE = 0.01
"Largest relative standard error of fx and fy: 1 % is 2 % of every area."
MOST_RMS_PX = 1.0
STANDS_OUT = 3.0
"Times the median of all pictures."
OPENCV_FLAGS = {
    0: cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3,
    4: cv2.CALIB_FIX_K3,
    5: 0,
    8: cv2.CALIB_RATIONAL_MODEL,
}
"Number of distortion coefficients to what calibrateCamera wants."


@dataclass(frozen=True)
class Fitted:
    """One view after the fit.

    name : of the picture. corners : used. rms_px : distance of corners from where the camera puts them.
    tilt_deg : between the board's normal and the camera's axis.
    distance_mm : from the pinhole along the axis to the plane of the board.
    """

    name: str
    corners: int
    rms_px: float
    tilt_deg: float
    distance_mm: float


@dataclass(frozen=True)
class Calibration:
    """Intrinsics with their standard errors.

    fx_px, fy_px, cx_px, cy_px : camera matrix. distortion : OpenCV's coefficients, as many as asked for.
    fx_se_px, fy_se_px, cx_se_px, cy_se_px : standard errors; the corners of one picture may err together.
    rms_px : reprojection error over all corners. covered : part of the image that boards covered, 0 to 1.
    views : in the order given. notes : on those that fit far worse than most.
    """

    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    distortion: tuple[float, ...]
    fx_se_px: float
    fy_se_px: float
    cx_se_px: float
    cy_se_px: float
    rms_px: float
    covered: float
    views: tuple[Fitted, ...]
    notes: tuple[str, ...]


def calibrate(views: list[View], width_px: int, height_px: int, *, n_distortion: int = 5) -> Calibration:
    """The camera that saw these views (cv2.calibrateCamera, after Zhang 2000).

    views : none of them `unusable`.
    width_px, height_px : of every picture, px.
    n_distortion : coefficients to fit, a key of `OPENCV_FLAGS`; the others are 0.
    CameraError : too few views, too little of the image covered, a focal length that the views do not determine, or
        corners that no camera of this kind puts where they are.
    """
    if len(views) < LEAST_VIEWS:
        raise CameraError(
            "pictures", wanted=f"{LEAST_VIEWS} or more that show the board", found=str(len(views)),
            do="Take more pictures of the board, sharp, tilted by 20 to 40 degrees to different sides.",
        )  # fmt: skip
    part = covered(views, width_px, height_px)
    if part < LEAST_COVERED:
        raise CameraError(
            "pictures", wanted=f"boards over {LEAST_COVERED:.0%} of the image or more", found=f"{part:.0%}",
            do="Take pictures with the board in every corner of the image.",
        )  # fmt: skip
    boards, seen = [view.board_mm for view in views], [view.image_px for view in views]
    first, flags = np.eye(3), OPENCV_FLAGS[n_distortion]
    try:
        rms_px, *solved = cv2.calibrateCamera(boards, seen, (width_px, height_px), first, np.zeros(0), flags=flags)
    except cv2.error as error:
        raise _undetermined("no solution") from error
    matrix, coefficients = (np.asarray(each, dtype=np.float64) for each in solved[:2])
    distortion = coefficients.ravel()[:n_distortion]
    poses = [
        (np.asarray(turn, np.float64), np.asarray(shift, np.float64)) for turn, shift in zip(*solved[2:], strict=True)
    ]
    residuals, jacobians = _linearized(views, poses, matrix, distortion)
    fx_se, fy_se, cx_se, cy_se = standard_errors(residuals, jacobians)[:4].tolist()
    fx, fy = float(matrix[0, 0]), float(matrix[1, 1])
    fitted = tuple(_fitted(view, pose, r) for view, pose, r in zip(views, poses, residuals, strict=True))
    notes = _standing_out(fitted)
    if rms_px > MOST_RMS_PX:
        raise CameraError(
            "reprojection error", wanted=f"{MOST_RMS_PX:g} px rms or less", found=f"{rms_px:.2f} px",
            do=_first(notes, "Check the numbers of the board, and that it is flat; a wide lens needs --distortion 8."),
        )  # fmt: skip
    relative = [fx_se / fx, fy_se / fy]
    if not (fx > 0 and fy > 0 and all(each <= MOST_RELATIVE_SE for each in relative)):
        raise _undetermined(" and ".join(f"{100 * each:.3g} %" for each in relative), notes)
    return Calibration(
        fx_px=fx, fy_px=fy, cx_px=float(matrix[0, 2]), cy_px=float(matrix[1, 2]), distortion=tuple(distortion.tolist()),
        fx_se_px=fx_se, fy_se_px=fy_se, cx_se_px=cx_se, cy_se_px=cy_se, rms_px=float(rms_px), covered=part,
        views=fitted, notes=notes,
    )  # fmt: skip


def standard_errors(residuals: list[Array], jacobians: list[tuple[Array, Array]]) -> Array:
    """(P,) of the camera's parameters, free of the poses; the larger of two: corners err alone, or pictures as a whole.

    residuals : of each view, (2N,) px. jacobians : of each view, (2N, 6) by its pose and (2N, P) by the camera.
    """
    reduced = []
    for by_pose, by_camera in jacobians:
        basis = np.linalg.qr(by_pose)[0]
        reduced.append(by_camera - basis @ (basis.T @ by_camera))
    # columns of one size: a singular direction is one of the pictures, not of the units
    scale = np.linalg.norm(np.concatenate(reduced), axis=0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        _, sizes, directions = np.linalg.svd(np.concatenate(reduced) / scale, full_matrices=False)
        directions = directions / scale
        covariance = (directions.T / sizes**2) @ directions
    n_free = sum(map(len, residuals)) - len(scale) - 6 * len(residuals)
    alone = np.diag(covariance) * sum(float(r @ r) for r in residuals) / max(n_free, 1)
    pulls = np.array([covariance @ (by_camera.T @ r) for by_camera, r in zip(reduced, residuals, strict=True)])
    together = (pulls**2).sum(axis=0) * len(residuals) / (len(residuals) - 1)
    found: Array = np.sqrt(np.maximum(alone, together))
    return found


def _linearized(
    views: list[View], poses: list[tuple[Array, Array]], matrix: Array, distortion: Array
) -> tuple[list[Array], list[tuple[Array, Array]]]:
    """Residuals (2N,) px of each view, and what they change by with its pose and with the camera."""
    residuals: list[Array] = []
    jacobians: list[tuple[Array, Array]] = []
    for view, (turn, shift) in zip(views, poses, strict=True):
        points = view.board_mm.astype(np.float64)
        seen, derivatives = cv2.projectPoints(points, turn, shift, matrix, distortion if distortion.size else None)
        by_all = np.asarray(derivatives, dtype=np.float64)
        residuals.append(np.asarray(view.image_px - seen[:, 0, :], dtype=np.float64).ravel())
        jacobians.append((by_all[:, :6], by_all[:, 6 : 10 + distortion.size]))
    return residuals, jacobians


def _fitted(view: View, pose: tuple[Array, Array], residual: Array) -> Fitted:
    turn, shift = pose
    normal = cv2.Rodrigues(turn)[0][:, 2]
    return Fitted(
        name=view.name,
        corners=len(view.image_px),
        rms_px=float(np.sqrt((residual**2).sum() / len(view.image_px))),
        tilt_deg=float(np.degrees(np.arccos(min(abs(normal[2]), 1.0)))),
        distance_mm=float(normal @ shift.ravel() / normal[2]),
    )


def _standing_out(fitted: tuple[Fitted, ...]) -> tuple[str, ...]:
    usual_px = float(np.median([view.rms_px for view in fitted]))
    return tuple(
        f"{view.name} fits worse than the others, {view.rms_px:.2f} px rms, {usual_px:.2f} px usually: leave it out "
        "if it is blurred or its board bent"
        for view in fitted
        if view.rms_px > STANDS_OUT * usual_px
    )


def _undetermined(found: str, notes: tuple[str, ...] = ()) -> CameraError:
    tilt = "Views that are all parallel do not tell it: tilt the board by 20 to 40 degrees to different sides."
    return CameraError(
        "focal length", wanted=f"standard errors of fx and fy of {MOST_RELATIVE_SE:.0%} or less", found=found,
        do=_first(notes, tilt),
    )  # fmt: skip


def _first(notes: tuple[str, ...], advice: str) -> str:
    """Pictures that stand out are looked at before anything else."""
    return f"{'; '.join(notes)}. {advice}" if notes else advice
