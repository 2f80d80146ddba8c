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
from casr.svg import plot, thinned
from emg2vsa import __version__
from emg2vsa.arrays import Floats
from emg2vsa.errors import RecordingError
from emg2vsa.figures.palette import BLUE, INK, YELLOW
from emg2vsa.readers.opened import StoredChannel
from emg2vsa.readers.survey import ChannelFacts, FileFacts
from emg2vsa.recordings import ChannelInfo
from emg2vsa.report.wording import aligned, count

if TYPE_CHECKING:
    from emg2vsa.extraction import Trials
    from emg2vsa.fits import Fits

_HEADS = ("channel", "unit", "rate, Hz", "lowest", "highest", "clipped", "noise floor", "mains", "probably")
_MOST_DRAWN = 24
_COLOURS = {"EMG": BLUE, "force": YELLOW, "other": INK}


def _row(channel: ChannelFacts) -> tuple[str, ...]:
    """A channel's row of the table, in the order of ``_HEADS``."""
    rate = f"{channel.fs_hz:.6g}" if channel.fs_hz > 0 else "unknown"
    low, high, noise = ("" if math.isnan(v) else f"{v:.3g}" for v in (channel.low, channel.high, channel.noise))
    mains_share = math.nan if channel.role == "force" else channel.mains_share
    clipped, mains = ("" if math.isnan(v) else f"{100 * v:.2g} %" for v in (channel.clip_share, mains_share))
    guess = channel.fault or channel.guess
    return channel.name, channel.unit or "none", rate, low, high, clipped, noise, mains, guess


def recording_page(files: Sequence[FileFacts], refused: Sequence[str]) -> str:
    """The whole page. refused : one sentence for each file that could not be read."""
    one = len(files) == 1
    title = files[0].path.name if one else f"{len(files)} recordings"
    body = "".join(
        file_section(number, "Channels" if one else file.path.name, file) for number, file in enumerate(files, 1)
    )
    if refused:
        body += section("refused", "Files that could not be read", bullets(refused))
    nav = [] if one else [(f"#file{number}", file.path.name) for number, file in enumerate(files, 1)]
    return page(title, f"<h1>{escape(title)}</h1>", nav, body, paragraph(f"Made by emg2vsa {__version__}.", "small"))


def file_section(number: int, title: str, file: FileFacts) -> str:
    """Channels of a file, each with a picture."""
    rows = [(f"{name}: {guess}", *numbers) for name, *numbers, guess in map(_row, file.channels)]
    said = f"{file.format}, {len(file.channels)} channels. Values have the unit that the file states."
    drawn = [(c, s) for c, s in zip(file.channels, file.stored, strict=True) if s is not None and s.fs_hz > 0]
    others = [each for each in drawn if each[0].role == "other"]
    told = drawn if len(others) == len(drawn) else [each for each in drawn if each[0].role != "other"]
    told, others = told[:_MOST_DRAWN], [] if told is drawn else others[:_MOST_DRAWN]
    shown = [_pictures(f"f{number}c{i}", *each) for i, each in enumerate([*told, *others])]
    more = details(f"{len(others)} other channels", "".join(shown[len(told) :])) if others else ""
    channels = table(f"Channels of {file.path.name}", _HEADS[:-1], rows)
    return section(f"file{number}", title, paragraph(said), channels, bullets(file.notes), *shown[: len(told)], more)


def _pictures(name: str, facts: ChannelFacts, channel: StoredChannel) -> str:
    time_s = channel.start_s + np.arange(channel.samples.size) / channel.fs_hz
    known, size = np.isfinite(channel.samples), max(abs(facts.low), abs(facts.high))
    scale, unit = 1.0, facts.unit or "stored value"
    if unit == "V" and size < 0.1:
        scale, unit = (1e6, "uV") if size < 0.01 else (1e3, "mV")
    x, y = thinned(time_s[known], channel.samples[known] * scale, 1600)
    trace = _drawing(x, y, _COLOURS[facts.role], ("time (s)", unit), f"{name}t", f"{facts.name} over time")
    shown = [figure(trace, f"{facts.name} over time: {facts.guess}.")]
    if facts.role == "EMG" and channel.samples.size >= 2 * channel.fs_hz:
        labels, title = ("frequency (Hz)", "power relative to the largest (dB)"), f"Spectrum of {facts.name}"
        spectrum = _drawing(*_spectrum(channel), _COLOURS["EMG"], labels, f"{name}s", title)
        shown.append(figure(spectrum, f"{title}. Mains hum shows as peaks at multiples of 50 or 60 Hz."))
    return pictures(shown)


def _spectrum(channel: StoredChannel) -> tuple[Floats, Floats]:
    """Frequencies, and the mean power of pieces of one second in decibels of the largest."""
    size = round(channel.fs_hz)
    samples = np.nan_to_num(channel.samples - np.nanmean(channel.samples))
    blocks = samples[: samples.size // size * size].reshape(-1, size) * np.hanning(size)
    power: Floats = np.mean(np.abs(np.fft.rfft(blocks, axis=1)) ** 2, axis=0)[1:]
    frequency: Floats = np.asarray(np.fft.rfftfreq(size, 1 / channel.fs_hz)[1:], dtype=np.float64)
    return frequency, 10 * np.log10(np.maximum(power / power.max(), 1e-8))


def _drawing(x: Floats, y: Floats, colour: str, labels: tuple[str, str], name: str, title: str) -> str:
    axes = plot(labels, x, y, width=840, height=280)
    axes.line(np.column_stack([x, y]), colour, width=2)
    told = f"Values from {y.min():.3g} to {y.max():.3g}, with {labels[0]} from {x[0]:.3g} to {x[-1]:.3g}."
    return axes.svg(name, title, told)


def as_json(facts: FileFacts) -> dict[str, Any]:
    """One file."""
    channels = [{**vars(channel), "duration_s": channel.duration_s} for channel in facts.channels]
    return {"file": str(facts.path), "format": facts.format, "channels": channels, "notes": list(facts.notes)}


def file_lines(facts: FileFacts) -> Iterator[str]:
    """A line per channel."""
    yield f"{facts.path}: {facts.format}, {count(len(facts.channels), 'channel')}, {_longest_s(facts):.1f} s"
    yield from aligned([_HEADS, *map(_row, facts.channels)], left=(0, 1, len(_HEADS) - 1))
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
            rows.append((str(path), "not read", "", "", "", _shortened(f"{outcome.found}. {outcome.do}", 120)))
        else:
            rows.append((str(path), *_cells(outcome)))
    yield from aligned(rows, left=(0, 1, 4, 5))
    yield from dict.fromkeys(each.hint for each in outcomes if not isinstance(each, RecordingError) and each.hint)
    bad = sum(isinstance(outcome, RecordingError) for outcome in outcomes)
    yield f"{len(paths) - bad} of {len(paths)} files read"


def _cells(facts: FileFacts) -> tuple[str, ...]:
    longest_s, force, span = _longest_s(facts), facts.force, "none found"
    emg = [_shortened(channel.name, 24) for channel in facts.emg]
    listed = ", ".join(emg[:3]) + (f" and {len(emg) - 3} more" if len(emg) > 3 else "")
    if force is not None:
        span = f"{_shortened(force.name, 24)}: {force.low:.3g} to {force.high:.3g} {force.unit or ''}".rstrip()
    seconds = f"{longest_s:.1f}" if longest_s == longest_s else "rate unknown"
    return facts.format, str(len(facts.channels)), seconds, span, listed or "none found"


def _longest_s(facts: FileFacts) -> float:
    return max((channel.duration_s for channel in facts.channels if channel.fs_hz > 0), default=float("nan"))


def _shortened(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 3] + "..."


_FITTED = (
    "repetition", "verdict", "start_s", "a_v", "b_v", "a_se_v", "b_se_v", "b_lo_v", "b_hi_v", "b_bias", "b_bias_se",
    "b_corrected", "cause", "n_points", "adj_r2",
    "r2_bins", "adj_r2_bins", "r2_samples", "adj_r2_samples", "n_effective", "lag1",
)  # fmt: skip


def rows(trials: Trials, fits: Fits) -> list[dict[str, Any]]:
    """One a press."""
    found = [{name: getattr(fits, name)[i].item() for name in _FITTED} for i in range(fits.repetition.size)]
    for row, reason, stop_s in zip(found, fits.reason.tolist(), trials.stop_s, strict=True):
        row |= {"reason": reason, "stop_s": float(stop_s), "unit": trials.activity_unit}
    return found


_SHOWN = {
    "press": "{repetition}", "from s": "{start_s:.3f}", "to s": "{stop_s:.3f}", "verdict": "{verdict}",
    "a": "{a_v:.4g}", "b": "{b_v:.4g}", "b 95 % interval": "{b_lo_v:.3g} to {b_hi_v:.3g}",
    "bias": "{b_bias:+.1%}",
    "adj R2 bins": "{adj_r2_bins:.3f}", "samples": "{adj_r2_samples:.3f}", "n eff": "{n_effective:.0f}",
}  # fmt: skip
"""Columns of the presses, from their rows in microvolts."""


def fit_lines(trials: Trials, fits: Fits, *said: str) -> Iterator[str]:
    """A line a press, with the reason beneath where it is not ok; then what is said of all of them."""
    scaled = [{key: of * 1e6 if key.endswith("_v") else of for key, of in row.items()} for row in rows(trials, fits)]
    n, ok = len(scaled), sum(row["verdict"] == "ok" for row in scaled)
    yield f"{n} press{'es' * (n != 1)} found, {ok} ok; v = a + b ln(F / 1 N), in microvolts"
    told = aligned([[*_SHOWN], *([form.format(**row) for form in _SHOWN.values()] for row in scaled)], left=(3,))
    for line, reason in zip(told if n else (), ("", *fits.reason.tolist()), strict=False):
        yield from (line, f"      {reason}") if reason else (line,)
    yield from filter(None, said)
    yield from (f"note: {note}" for note in trials.notes)


def channel_lines(
    path: Path, format: str, channels: Sequence[ChannelInfo], notes: Sequence[str], absent: Sequence[str]
) -> Iterator[str]:
    """A line a channel. absent : options that a fit needs too."""
    yield f"{path}: {format}, {count(len(channels), 'channel')}"
    told = [
        (c.name, c.unit or "no unit", f"{c.fs_hz:.4f} Hz" if c.fs_hz > 0 else "rate unknown", f"{c.n_samples} samples")
        for c in channels
    ]
    yield from aligned(told, left=(0, 1))
    yield from (f"note: {note}" for note in notes)
    yield f"To fit, add {' and '.join(absent)}; more muscles: --emg again"
