"""The contact region: a polygon of skin, followed from the first contact as it grows."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError, SettingError

Points = NDArray[np.float64]
ROUND_VERTICES = 64


@dataclass(frozen=True)
class Affine:
    """x' - x = offset_px + matrix (x - centre_px).

    matrix : (2, 2) displacement gradient per frame pair, [[du/dx, du/dy], [dv/dx, dv/dy]].
    offset_px : (2,) motion of the centre. centre_px : (2,) mean of the pins used. n : pins used. notes : pins left out.
    """

    matrix: NDArray[np.float64]
    offset_px: NDArray[np.float64]
    centre_px: NDArray[np.float64]
    n: int
    notes: tuple[str, ...] = ()

    def displacement_px(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Motion (N, 2) of points (N, 2)."""
        return self.offset_px + (points_px - self.centre_px) @ self.matrix.T


@dataclass(frozen=True, eq=False)
class Region:
    """Outline of the contact in one frame.

    polygon_px : (K, 2) vertices (x, y) in order, either way round, px.
    SettingError : fewer than three vertices, one that is not finite, or no area.
    """

    polygon_px: Points

    def __repr__(self) -> str:
        x_px, y_px = self.centre_px
        return f"Region({self.area_px2:.4g} px2 about ({x_px:.1f}, {y_px:.1f}) px, {len(self.polygon_px)} vertices)"

    def __post_init__(self) -> None:
        polygon = np.array(self.polygon_px, dtype=np.float64)
        usable = polygon.ndim == 2 and polygon.shape[0] >= 3 and polygon.shape[1] == 2 and np.isfinite(polygon).all()
        if not usable or abs(_signed_area(polygon)) < 1e-9:
            raise SettingError(
                "region", wanted="at least three finite vertices (x, y) around an area",
                found=f"{polygon.shape[0] if polygon.ndim else 0} vertices that enclose nothing",
                do="Give a region inside the image, e.g. 150,150,60 for x, y, radius.",
            )  # fmt: skip
        object.__setattr__(self, "polygon_px", polygon)

    @classmethod
    def circle(cls, x_px: float, y_px: float, radius_px: float) -> Region:
        """A circle; the polygon has exactly its area."""
        return cls.ellipse(x_px, y_px, radius_px, radius_px)

    @classmethod
    def ellipse(cls, x_px: float, y_px: float, a_px: float, b_px: float, *, turn_deg: float = 0.0) -> Region:
        """An ellipse with half axis ``a_px`` along the direction ``turn_deg`` (degrees) from x towards y and ``b_px``
        across.

        SettingError : a half axis that is not above 0 px.
        """
        if not (a_px > 0 and b_px > 0):
            raise SettingError(
                "region", wanted="half axes above 0 px", found=f"{a_px:g} and {b_px:g}", do="Give a radius in pixels."
            )
        step = 2 * np.pi / ROUND_VERTICES
        along = np.arange(ROUND_VERTICES) * step
        equal_area = np.sqrt(step / np.sin(step))
        turn = np.deg2rad(turn_deg)
        axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        unturned = equal_area * np.column_stack([a_px * np.cos(along), b_px * np.sin(along)])
        return cls(unturned @ axes + (x_px, y_px))

    @classmethod
    def from_points(cls, points_px: Points) -> Region:
        """Convex hull of (N, 2) points."""
        points_px = np.asarray(points_px, dtype=np.float64).reshape(-1, 2)
        if len(points_px) < 3:
            return cls(points_px)
        order = cv2.convexHull(points_px.astype(np.float32), returnPoints=False)[:, 0]
        return cls(points_px[order])

    @classmethod
    def parse(cls, text: str) -> Region:
        """A circle written ``x,y,radius`` in pixels, as the command line takes it. SettingError : other text."""
        try:
            x_px, y_px, radius_px = (float(part) for part in text.split(","))
        except ValueError:
            raise SettingError(
                "region", wanted="three numbers x,y,radius in pixels", found=repr(text), do="Write e.g. 150,150,60."
            ) from None
        return cls.circle(x_px, y_px, radius_px)

    @property
    def area_px2(self) -> float:
        """Enclosed area, px^2."""
        return abs(_signed_area(self.polygon_px))

    @property
    def centre_px(self) -> Points:
        """(2,) centroid of the enclosed area, px."""
        corner = self.polygon_px[0]  # a near origin keeps the differences small
        here = self.polygon_px - corner
        there = np.roll(here, -1, axis=0)
        doubled = here[:, 0] * there[:, 1] - there[:, 0] * here[:, 1]
        return np.asarray(corner + ((here + there) * doubled[:, None]).sum(axis=0) / (3 * doubled.sum()))

    def scaled(self, factor: float) -> Region:
        """The region scaled about its centroid."""
        centre = self.centre_px
        return Region(centre + factor * (self.polygon_px - centre))

    def advanced(self, motion: Affine) -> Region:
        """The same piece of skin after an affine motion."""
        return Region(self.polygon_px + motion.displacement_px(self.polygon_px))

    def growth_to(self, after: Region) -> tuple[float, float]:
        """Mean divergence of the motion to the same piece of skin in the next frame, and ln of the ratio of the areas.

        Both are exact for a motion that is linear along each side of the polygon: the first is the flux of the
        displacement through the border over the area (Gauss), the second holds for steps of any size.

        PinsError : the motion turns the region inside out.
        """
        area, grown = _signed_area(self.polygon_px), _signed_area(after.polygon_px)
        if grown / area <= 0:
            raise PinsError(
                "contact region", wanted="a motion that keeps it a region", found="one that turns it inside out",
                do="Are the frames one press, in order? Look at how its pins were followed.",
            )  # fmt: skip
        turned = _signed_area(after.polygon_px - self.polygon_px)
        return (grown - area - turned) / area, float(np.log(grown / area))

    def depth(self, points_px: Points) -> NDArray[np.float64]:
        """(N,) factor by which the region, scaled about its centroid, just holds each point: 0 there, 1 on the border.

        For a polygon that is not convex, that of a larger one may be given.
        """
        centre = self.centre_px
        corner = self.polygon_px - centre
        edge = np.roll(corner, -1, axis=0) - corner
        outward = np.column_stack([edge[:, 1], -edge[:, 0]]) * np.sign(_signed_area(self.polygon_px))
        height = (outward * corner).sum(axis=1)
        long = height > 1e-12 * self.area_px2
        reach = (np.asarray(points_px) - centre) @ outward[long].T / height[long]
        return np.asarray(reach.max(axis=1))

    def contains(self, points_px: Points) -> NDArray[np.bool_]:
        """(N,) whether each (x, y) lies inside, by the crossing number, so for any simple polygon."""
        x, y = np.asarray(points_px, dtype=np.float64).reshape(-1, 2).T[:, :, None]
        (x0, y0), (x1, y1) = self.polygon_px.T, np.roll(self.polygon_px, -1, axis=0).T
        between = (y0 > y) != (y1 > y)
        rise = np.where(y1 == y0, 1.0, y1 - y0)
        crossings = between & (x < x0 + (y - y0) * (x1 - x0) / rise)
        return np.asarray(crossings.sum(axis=1) % 2 == 1)

    def box(self, shape: tuple[int, ...], *, margin_px: float = 0.0) -> tuple[int, int, int, int]:
        """Smallest box (x0, y0, x1, y1), px, half open, around the region and a margin, clipped to an image of this
        shape.

        SettingError : the region lies outside the image.
        """
        x0, y0 = np.maximum(np.floor(self.polygon_px.min(axis=0) - margin_px).astype(int), 0).tolist()
        x1, y1 = np.minimum(np.ceil(self.polygon_px.max(axis=0) + margin_px).astype(int) + 1, shape[1::-1]).tolist()
        if x1 <= x0 or y1 <= y0:
            raise SettingError(
                "region", wanted=f"a region that meets the image of {shape[1]} x {shape[0]} px",
                found=f"one around ({self.centre_px[0]:.0f}, {self.centre_px[1]:.0f})",
                do="Give the region in pixels of these frames.",
            )  # fmt: skip
        return x0, y0, x1, y1


def _signed_area(polygon_px: Points) -> float:
    """Shoelace area, px^2, positive clockwise on the screen (y down)."""
    x, y = (polygon_px[1:] - polygon_px[0]).T  # from the first vertex, whose own terms are 0
    return 0.5 * float(x[:-1] @ y[1:] - x[1:] @ y[:-1])
