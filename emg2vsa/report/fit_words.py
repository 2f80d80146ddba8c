"""The presses of one recording and their fits, and the channels of a file: in lines for people, and for programs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from emg2vsa.extraction import Trials
from emg2vsa.fits import Fits
from emg2vsa.recordings import ChannelInfo

_COLUMNS = (
    "repetition", "verdict", "start_s", "a_v", "b_v", "a_se_v", "b_se_v", "b_lo_v", "b_hi_v", "n_points", "adj_r2",
    "r2_bins", "adj_r2_bins", "r2_samples", "adj_r2_samples", "n_effective", "lag1",
)  # fmt: skip


def rows(trials: Trials, fits: Fits) -> list[dict[str, Any]]:
    """One a press."""
    found = [{name: getattr(fits, name)[i].item() for name in _COLUMNS} for i in range(fits.repetition.size)]
    for row, reason, stop_s in zip(found, trials.reasons, trials.stop_s, strict=True):
        row |= {"reason": reason, "stop_s": float(stop_s), "unit": trials.activity_unit}
    return found


def fit_lines(trials: Trials, fits: Fits) -> Iterator[str]:
    """A line a press, with the reason beneath where it is not ok."""
    found = rows(trials, fits)
    ok = sum(row["verdict"] == "ok" for row in found)
    yield f"{len(found)} press{'es' if len(found) != 1 else ''} found, {ok} ok; v = a + b ln(F / 1 N), in microvolts"
    if found:
        head = ("press", "from s", "to s", "verdict", "a", "b", "b 95 % interval", "adj R2 bins", "samples", "n eff")
        yield "{:>5} {:>8} {:>8} {:<9} {:>8} {:>8} {:>20} {:>11} {:>8} {:>6}".format(*head)
    for row in found:
        interval = f"{row['b_lo_v'] * 1e6:.3g} to {row['b_hi_v'] * 1e6:.3g}"
        yield (
            f"{row['repetition']:>5} {row['start_s']:>8.3f} {row['stop_s']:>8.3f} {row['verdict']:<9} "
            f"{row['a_v'] * 1e6:>8.4g} {row['b_v'] * 1e6:>8.4g} {interval:>20} "
            f"{row['adj_r2_bins']:>11.3f} {row['adj_r2_samples']:>8.3f} {row['n_effective']:>6.0f}"
        )
        if row["reason"]:
            yield f"      {row['reason']}"
    yield from (f"note: {note}" for note in trials.notes)


def channel_lines(
    path: Path, format: str, channels: Sequence[ChannelInfo], notes: Sequence[str], absent: Sequence[str]
) -> Iterator[str]:
    """A line a channel. absent : options that a fit needs too."""
    yield f"{path}: {format}, {len(channels)} channel{'s' if len(channels) != 1 else ''}"
    width = max((len(channel.name) for channel in channels), default=0)
    for channel in channels:
        rate = f"{channel.fs_hz:.4f} Hz" if channel.fs_hz > 0 else "rate unknown"
        yield f"  {channel.name:<{width}}  {channel.unit or 'no unit':<10} {rate:>14} {channel.n_samples:>9} samples"
    yield from (f"note: {note}" for note in notes)
    yield f"To fit, add {' and '.join(absent)}; more muscles: --emg again"
