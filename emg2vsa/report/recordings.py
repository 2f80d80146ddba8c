"""Recordings as ``inspect`` and ``fit`` tell them: channels and presses in lines, for programs, and as a page."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from casr.html import bullets, details, figure, page, paragraph, pictures, section, table
from casr.svg import Axes, thinned
from emg2vsa import __version__
from emg2vsa.arrays import Floats
from emg2vsa.errors import RecordingError
from emg2vsa.figures.palette import BLUE, INK, YELLOW
from emg2vsa.readers.opened import StoredChannel
from emg2vsa.readers.survey import ChannelFacts, FileFacts
from emg2vsa.recordings import ChannelInfo

if TYPE_CHECKING:
    from emg2vsa.extraction import Trials
    from emg2vsa.fits import Fits

HEADS = ("channel", "unit", "rate, Hz", "lowest", "highest", "clipped", "noise floor", "mains", "probably")
_TRACE_POINTS = 1600
_MOST_DRAWN = 24
_COLOURS = {"EMG": BLUE, "force": YELLOW, "other": INK}


def cells(channel: ChannelFacts) -> tuple[str, ...]:
    """A channel's row of the table, in the order of ``HEADS``."""
    return (
        channel.name,
        channel.unit or "none",
        f"{channel.fs_hz:.6g}" if channel.fs_hz > 0 else "unknown",
        _number(channel.low),
        _number(channel.high),
        _percent(channel.clip_share),
        _number(channel.noise),
        _percent(channel.mains_share) if channel.role != "force" else "",
        channel.fault or channel.guess,
    )


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.3g}"


def _percent(share: float) -> str:
    return "" if math.isnan(share) else f"{100 * share:.2g} %"


def recording_page(files: Sequence[FileFacts], refused: Sequence[str]) -> str:
    """The whole page. refused : one sentence for each file that could not be read."""
    one = len(files) == 1
    title = files[0].path.name if one else f"{len(files)} recordings"
    header = f"<h1>{escape(title)}</h1>"
    body = "".join(
        _section(number, "Channels" if one else file.path.name, file) for number, file in enumerate(files, 1)
    )
    if refused:
        body += section("refused", "Files that could not be read", bullets(refused))
    nav = [] if one else [(f"#file{number}", file.path.name) for number, file in enumerate(files, 1)]
    return page(title, header, nav, body, paragraph(f"Made by emg2vsa {__version__}.", "small"))


def _section(number: int, title: str, file: FileFacts) -> str:
    rows = [(f"{name}: {guess}", *numbers) for name, *numbers, guess in map(cells, file.channels)]
    parts = [
        paragraph(f"{file.format}, {len(file.channels)} channels. Values have the unit that the file states."),
        table(f"Channels of {file.path.name}", HEADS[:-1], rows),
    ]
    if file.notes:
        parts.append(bullets(file.notes))
    drawn = [(c, s) for c, s in zip(file.channels, file.stored, strict=True) if s is not None and s.fs_hz > 0]
    told = [(c, s) for c, s in drawn if c.role != "other"] or drawn
    parts += [_pictures(number, i, c, s) for i, (c, s) in enumerate(told[:_MOST_DRAWN])]
    others = [(c, s) for c, s in drawn if c.role == "other" and (c, s) not in told][:_MOST_DRAWN]
    if others:
        start = len(told)
        more = "".join(_pictures(number, start + i, c, s) for i, (c, s) in enumerate(others))
        parts.append(details(f"{len(others)} other channels", more))
    return section(f"file{number}", title, *parts)


def _pictures(number: int, index: int, facts: ChannelFacts, channel: StoredChannel) -> str:
    name = f"f{number}c{index}"
    shown = [figure(_trace(facts, channel, f"{name}t"), f"{facts.name} over time: {facts.guess}.")]
    if facts.role == "EMG" and channel.samples.size >= 2 * channel.fs_hz:
        caption = f"Spectrum of {facts.name}. Mains hum shows as peaks at multiples of 50 or 60 Hz."
        shown.append(figure(_spectrum(facts, channel, f"{name}s"), caption))
    return pictures(shown)


def _trace(facts: ChannelFacts, channel: StoredChannel, name: str) -> str:
    scale, unit = _readable(facts)
    time_s = channel.start_s + np.arange(channel.samples.size) / channel.fs_hz
    known = np.isfinite(channel.samples)
    x, y = thinned(time_s[known], channel.samples[known] * scale, _TRACE_POINTS)
    return _drawing(x, y, _COLOURS[facts.role], "time (s)", unit, name, f"{facts.name} over time")


def _spectrum(facts: ChannelFacts, channel: StoredChannel, name: str) -> str:
    """Mean power of pieces of one second, in decibels of the largest."""
    size = round(channel.fs_hz)
    samples = np.nan_to_num(channel.samples - np.nanmean(channel.samples))
    blocks = samples[: samples.size // size * size].reshape(-1, size) * np.hanning(size)
    power: Floats = np.mean(np.abs(np.fft.rfft(blocks, axis=1)) ** 2, axis=0)[1:]
    decibels = 10 * np.log10(np.maximum(power / power.max(), 1e-8))
    frequency: Floats = np.asarray(np.fft.rfftfreq(size, 1 / channel.fs_hz)[1:], dtype=np.float64)
    return _drawing(
        frequency, decibels, _COLOURS["EMG"], "frequency (Hz)", "power relative to the largest (dB)", name,
        f"Spectrum of {facts.name}",
    )  # fmt: skip


def _readable(facts: ChannelFacts) -> tuple[float, str]:
    """A factor and unit that give the axis readable numbers."""
    size = max(abs(facts.low), abs(facts.high))
    if facts.unit == "V" and size < 0.1:
        return (1e6, "uV") if size < 0.01 else (1e3, "mV")
    return 1.0, facts.unit or "stored value"


def _drawing(x: Floats, y: Floats, colour: str, x_label: str, y_label: str, name: str, title: str) -> str:
    low, high = float(y.min()), float(y.max())
    margin = 0.05 * (high - low) or max(abs(high), 1.0) * 0.05
    view = (float(x[0]), high + margin, float(x[-1]), low - margin)
    axes = Axes(view, (x_label, y_label), 840, 280)
    axes.line(np.column_stack([x, y]), colour, width=2)
    told = f"Values from {low:.3g} to {high:.3g}, with {x_label} from {x[0]:.3g} to {x[-1]:.3g}."
    return axes.svg(name, title, told)


_LONGEST_REASON, _LONGEST_NAME = 120, 24


def as_json(facts: FileFacts) -> dict[str, Any]:
    """One file."""
    channels = [{**vars(channel), "duration_s": channel.duration_s} for channel in facts.channels]
    return {"file": str(facts.path), "format": facts.format, "channels": channels, "notes": list(facts.notes)}


def file_lines(facts: FileFacts) -> Iterator[str]:
    """A line per channel."""
    n = len(facts.channels)
    yield f"{facts.path}: {facts.format}, {n} channel{'s' if n != 1 else ''}, {_longest_s(facts):.1f} s"
    yield from _table([HEADS, *(cells(channel) for channel in facts.channels)], left=(0, 1, len(HEADS) - 1))
    yield from (f"note: {note}" for note in facts.notes)
    if facts.emg and facts.force:
        emg = " ".join(f"--emg {shlex.quote(channel.name)}" for channel in facts.emg[:4])
        sign = " --sign -1" if facts.force.sign < 0 else ""
        yield f"To fit: emg2vsa fit {shlex.quote(str(facts.path))} {emg} --force {shlex.quote(facts.force.name)}{sign}"


def folder_lines(paths: Sequence[Path], outcomes: Sequence[FileFacts | RecordingError]) -> Iterator[str]:
    """A line per file; outcomes : what each holds, or why it cannot be read."""
    rows: list[Sequence[str]] = [("file", "format", "channels", "seconds", "force", "EMG")]
    for path, outcome in zip(paths, outcomes, strict=True):
        if isinstance(outcome, RecordingError):
            reason = f"{outcome.found}. {outcome.do}"
            rows.append((str(path), "not read", "", "", "", _shortened(reason, _LONGEST_REASON)))
        else:
            rows.append((str(path), *_cells(outcome)))
    yield from _table(rows, left=(0, 1, 4, 5))
    bad = sum(isinstance(outcome, RecordingError) for outcome in outcomes)
    yield f"{len(paths) - bad} of {len(paths)} files read"


def _cells(facts: FileFacts) -> tuple[str, ...]:
    longest_s, force, span = _longest_s(facts), facts.force, "none found"
    emg = [_shortened(channel.name, _LONGEST_NAME) for channel in facts.emg]
    listed = ", ".join(emg[:3]) + (f" and {len(emg) - 3} more" if len(emg) > 3 else "")
    if force is not None:
        name = _shortened(force.name, _LONGEST_NAME)
        span = f"{name}: {force.low:.3g} to {force.high:.3g} {force.unit or ''}".rstrip()
    seconds = f"{longest_s:.1f}" if longest_s == longest_s else "rate unknown"
    return facts.format, str(len(facts.channels)), seconds, span, listed or "none found"


def _longest_s(facts: FileFacts) -> float:
    return max((channel.duration_s for channel in facts.channels if channel.fs_hz > 0), default=float("nan"))


def _shortened(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 3] + "..."


def _table(rows: Sequence[Sequence[str]], left: Sequence[int]) -> Iterator[str]:
    """Columns as wide as their longest cell; ``left``: those that are no numbers."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        cut = (c.ljust(w) if i in left else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True)))
        yield "  ".join(cut).rstrip()


_FITTED = (
    "repetition", "verdict", "start_s", "a_v", "b_v", "a_se_v", "b_se_v", "b_lo_v", "b_hi_v", "n_points", "adj_r2",
    "r2_bins", "adj_r2_bins", "r2_samples", "adj_r2_samples", "n_effective", "lag1",
)  # fmt: skip


def rows(trials: Trials, fits: Fits) -> list[dict[str, Any]]:
    """One a press."""
    found = [{name: getattr(fits, name)[i].item() for name in _FITTED} for i in range(fits.repetition.size)]
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
