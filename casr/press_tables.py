"""A scored press as two tables for other programs: every pin of every frame, and every frame."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from casr.errors import SettingError
from casr.scored import Score
from casr.spread.intervals import CONFIDENCE, normal_quantile

PIN_COLUMNS = ("frame", "pin", "x_px", "y_px", "inside")
Value = float | int | None


def pins_csv(score: Score) -> str:
    """A row for each pin in the rest frame and in each scored frame.

    Pins are counted as in the rest frame; x and y are empty where one is not seen. ``inside`` is 1 where its root is
    inside the front, also in frames whose area is not determined.
    """
    rest = np.zeros((1, len(score.rest)), dtype=np.bool_)
    places = np.concatenate([score.rest.centroids_px[None], score.pins_px])
    rows = (
        (frame, pin, _rounded(x, 3), _rounded(y, 3), int(inside))
        for frame, points, within in zip(
            (score.rest_frame, *score.frames.tolist()), places, np.concatenate([rest, score.front.inside]), strict=True
        )
        for pin, ((x, y), inside) in enumerate(zip(points.tolist(), within.tolist(), strict=True))
    )
    return _csv(PIN_COLUMNS, rows)


def frame_columns(unit: str) -> tuple[str, ...]:
    """Names of the columns of ``frame_rows``; ``unit`` of areas."""
    return (
        "frame", "force_n", f"front_area_{unit}", f"front_area_low_{unit}", f"front_area_high_{unit}",
        f"skin_area_{unit}", "shear_x_px", "shear_y_px", "torsion_deg", "pins_inside", "determined",
    )  # fmt: skip


def frame_table(score: Score) -> dict[str, list[Value]]:
    """The columns of ``frame_rows`` by name, as a DataFrame or any other table takes them. SettingError: no score."""
    if not isinstance(score, Score):
        do = "Score the press first: casr.frame_table(casr.score(press))."
        raise SettingError("frame_table", wanted="a Score", found=type(score).__name__, do=do)
    names = frame_columns(score.area_unit)
    return dict(zip(names, map(list, zip(*frame_rows(score), strict=True)), strict=True))


def frame_rows(score: Score) -> list[tuple[Value, ...]]:
    """A row for each scored frame; None for what is not known.

    Low and high: 95 % of the area by all parts of its error. Shear and torsion: motion since rest of the pins inside,
    as a whole. ``determined`` is 1 where the front's area counts.
    """
    front = score.front
    reach = np.exp(normal_quantile(CONFIDENCE) * front.relative_sd)
    determined = front.determined & (score.front_doubt == "")
    force_n = np.full(len(score.frames), np.nan) if score.force_n is None else score.force_n
    columns = (
        force_n, front.area, front.area / reach, front.area * reach, score.skin.area, *front.shear_px.T,
        front.torsion_deg,
    )  # fmt: skip
    return [
        (frame, *(_rounded(value, 6) for value in values), inside, int(counts))
        for frame, values, inside, counts in zip(
            score.frames.tolist(),
            np.column_stack(columns).tolist(),
            front.pins_inside.tolist(),
            determined,
            strict=True,
        )
    ]


def frames_csv(score: Score) -> str:
    """``frame_rows`` as text."""
    return _csv(frame_columns(score.area_unit), frame_rows(score))


def _rounded(value: float, digits: int) -> float | None:
    return round(value, digits) if np.isfinite(value) else None


def _csv(heads: Sequence[str], rows: Iterable[Sequence[Value]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    return text.getvalue()
