"""The page of ``emg2vsa inspect``: a table of the channels, and each channel over time and frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np

from casr.html import bullets, details, figure, page, paragraph, section, table
from emg2vsa import __version__
from emg2vsa.arrays import Floats
from emg2vsa.figures.palette import BLUE, INK, YELLOW
from emg2vsa.readers.opened import StoredChannel
from emg2vsa.readers.survey import ChannelFacts, FileFacts
from emg2vsa.report.session_plots import PlotArea, thinned

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
    return f'<div class="pictures">{"".join(shown)}</div>\n'


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
    area = PlotArea((float(x[0]), float(x[-1])), (low - margin, high + margin), 960, 360, left=110)
    line = f'<path d="{area.line(x, y)}" stroke="{colour}"/>'
    told = f"Values from {low:.3g} to {high:.3g}, with {x_label} from {x[0]:.3g} to {x[-1]:.3g}."
    return area.svg(area.axes(x_label, y_label) + line, name, title, told)
