"""What a file holds and what each of its channels probably is, judged by unit, name and the samples themselves."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import open_recording
from emg2vsa.readers.opened import OpenRecording, StoredChannel
from emg2vsa.readers.units import seconds_per, si_factor
from emg2vsa.settings import ReadingSettings
from emg2vsa.signals.quality import mains_ratios, raw_qualities

Role = Literal["EMG", "force", "other"]

BLOCK_S = 0.05
"""Means over blocks of this length follow a force and hardly an EMG."""
_SLOW_SHARE = 0.5
"""A signal with more of its variance in these means is slow: white noise at 1 kHz keeps 2 %, a force nearly all."""
_REST_SHARE = 0.05
"""The noise floor is the level that the quietest blocks of a quarter of a second stay below: this share of them."""
_REST_BLOCK_S = 0.25
_HUM_SHARE = 0.6
"""A channel with a larger share of mains shows nothing of a muscle."""
_RISES_WITH_EMG = 0.4
"""Least correlation with the level of the EMG that tells a force, where neither unit nor name does."""
_MOST_ACCELERATION_G = 20
"""No arm reaches it: larger values in g are grams."""
_FORCE_NAME = re.compile(r"(^|[^a-z])(f[xyz]?|forces?|load([ _-]?cell)?|kraft|grip|loadcell)([^a-z]|$)", re.IGNORECASE)
_EMG_NAME = re.compile(r"emg|(^|[^a-z])(edc|fds|fcr|fcu|ecr|ecu|fdp|biceps|triceps)([^a-z]|$)", re.IGNORECASE)
_NOT_EMG = re.compile(r"(^|[^a-z])(acc|gyro|mag|angle|temp|trig|sync|e[ck]g|eog|eeg|mic(?![a-z]))", re.IGNORECASE)
_SMALLEST, _LARGEST = 1e-60, 1e60
"""No instrument writes values beyond these in any unit, and their fourth powers still fit into a float."""
_MEANT = {
    "acceleration": ("g", "G", "m/s^2", "m/s²"), "turning rate": ("deg/s", "°/s", "dps", "rad/s"),
    "angle": ("deg", "°", "rad"), "length": ("mm", "cm", "m"), "torque": ("Nm", "Nmm", "N.m", "N·m"),
    "temperature": ("C", "°C"), "pressure": ("Pa", "kPa", "hPa"), "magnetic field": ("uT", "mT"),
}  # fmt: skip


NO_RATE = "rate not known: state it with --fs"
"End of the guess of a channel that would tell more at a known rate."
_BY_EMG = "it changes with the EMG"
"Tells a force whose unit and name do not."
_DEAD = ("empty", "flat", "mains hum", "no signal")


@dataclass(frozen=True)
class ChannelFacts:
    """One channel, values in its ``unit`` (None where the file states none) and NaN where they cannot be known.

    low, high : smallest and largest sample. clip_share : of samples held at either. noise : rms of the quietest quarter
    seconds. mains_share : of the power at 50 or 60 Hz and harmonics. missing : samples that are no numbers.
    role, guess : what it probably is, for programs and in words. sign : -1 where pressing lowers the force.
    may_press : whether it may be the force. fault : why it cannot be read, or "".
    """

    name: str
    unit: str | None
    fs_hz: float
    n_samples: int
    low: float = math.nan
    high: float = math.nan
    clip_share: float = math.nan
    noise: float = math.nan
    mains_share: float = math.nan
    missing: int = 0
    role: Role = "other"
    guess: str = ""
    sign: int = 1
    may_press: bool = False
    fault: str = ""

    @property
    def duration_s(self) -> float:
        """Length of the channel, s; NaN where its rate is not known."""
        return self.n_samples / self.fs_hz if self.fs_hz > 0 else math.nan


@dataclass(frozen=True)
class FileFacts:
    """format : of the file. stored : the channels' samples as the file holds them, None where they cannot be read.

    untimed : names of channels whose rate the file does not state.
    """

    path: Path
    format: str
    channels: tuple[ChannelFacts, ...]
    notes: tuple[str, ...]
    stored: tuple[StoredChannel | None, ...]
    untimed: tuple[str, ...] = ()

    @property
    def emg(self) -> list[ChannelFacts]:
        return [channel for channel in self.channels if channel.role == "EMG"]

    @property
    def lost(self) -> list[ChannelFacts]:
        """Channels that unit or name would let be EMG, and whose samples do not."""
        return [each for each in self.channels if each.role == "other" and _is_lost(each)]

    @property
    def rivals(self) -> list[ChannelFacts]:
        """Channels that may be the force as well as the one that was taken for it.

        A force across the pressing that is less than half as large is none: F/T sensors have two of these.
        """
        taken = self.force
        found = [each for each in self.channels if each.may_press and taken and each.name != taken.name]
        if taken is None or _BY_EMG in taken.guess:
            return found
        return [each for each in found if not each.guess.startswith("slow") and not _is_sideways(each, taken)]

    @property
    def hint(self) -> str:
        """What to do about channels that unit or name tell to be EMG or force, and whose rate is not known; or ""."""
        named = [
            each.name for each in self.channels
            if each.guess.endswith(NO_RATE) and each.guess.startswith(("EMG", "force", "a force"))
        ]  # fmt: skip
        more = f" and {len(named) - 4} more" if len(named) > 4 else ""
        return f"{', '.join(named[:4])}{more}: {NO_RATE}" if named else ""

    @property
    def force(self) -> ChannelFacts | None:
        """The channel that is most probably the pressing force."""
        return next((channel for channel in self.channels if channel.role == "force"), None)


def _is_lost(facts: ChannelFacts) -> bool:
    known, words = si_factor(facts.unit), _by_words(facts)
    if _NOT_EMG.search(facts.name) or (facts.unit is not None and (known is None or known[0] != "V")):
        return False
    if facts.guess.startswith(_DEAD):
        return not words.startswith("force") and (known is not None or words.startswith("EMG") or words == "unknown")
    return words.startswith("EMG") and not facts.guess.endswith(NO_RATE)


def _is_sideways(facts: ChannelFacts, taken: ChannelFacts) -> bool:
    across = re.search(r"f[ _-]?\d*[ _-]?[xy](?![a-z])", facts.name, re.IGNORECASE) is not None
    return across and facts.unit == taken.unit and 2 * (facts.high - facts.low) < taken.high - taken.low


def survey(path: Path, reading: ReadingSettings | None = None, fs_hz: float | None = None) -> FileFacts:
    """Read a whole file and judge its channels.

    fs_hz : rate, Hz, of channels whose file states none.
    Raises RecordingError where the file cannot be opened; a channel that cannot be read has its fault.
    """
    name, opened = open_recording(path, reading or ReadingSettings())
    stored, faults = _loaded(opened)
    stored = [s and _without_infinities(s) for s in stored]
    untimed = tuple(s.name for s in stored if s is not None and not s.fs_hz > 0)
    if fs_hz is not None:
        stored = [replace(s, fs_hz=fs_hz) if s is not None and not s.fs_hz > 0 else s for s in stored]
    facts = [
        _facts(channel) if channel is not None else ChannelFacts(label, None, math.nan, 0, fault=fault)
        for channel, label, fault in zip(stored, opened.contents.names, faults, strict=True)
    ]
    notes = [*opened.contents.notes, *(note for channel in stored if channel for note in channel.notes)]
    return FileFacts(
        Path(path), name, tuple(_with_force(facts, stored)), tuple(dict.fromkeys(notes)), tuple(stored), untimed
    )  # fmt: skip


def _without_infinities(channel: StoredChannel) -> StoredChannel:
    """Infinite samples are missing ones: no mean of the others can hold them."""
    infinite = np.isinf(channel.samples)
    if not infinite.any():
        return channel
    return replace(channel, samples=np.where(infinite, np.nan, channel.samples))


def _loaded(opened: OpenRecording) -> tuple[list[StoredChannel | None], list[str]]:
    """All channels at once; where that fails, one by one, so that a faulty one costs only itself."""
    n = len(opened.contents.names)
    try:
        return list(opened.load(range(n))), [""] * n
    except RecordingError:
        pass
    stored: list[StoredChannel | None] = []
    faults = []
    for index in range(n):
        try:
            stored += opened.load([index])
            faults.append("")
        except RecordingError as error:
            if n == 1:
                raise
            stored.append(None)
            faults.append(f"found {error.found}. {error.do}")
    return stored, faults


def _facts(channel: StoredChannel) -> ChannelFacts:
    gone = ~np.isfinite(channel.samples)
    samples = channel.samples[~gone]
    facts = ChannelFacts(channel.name, channel.unit, channel.fs_hz, channel.samples.size, missing=int(gone.sum()))
    if samples.size < 2:
        return replace(facts, guess="empty: hardly a sample is a number")
    facts = replace(facts, low=float(samples.min()), high=float(samples.max()))
    if facts.low == facts.high:
        return replace(facts, guess="flat: nothing was connected")
    largest = max(abs(facts.low), abs(facts.high))
    if not _SMALLEST < largest < _LARGEST:
        return replace(facts, guess=f"no signal: values up to {_short(largest)}")
    kind = _by_shape(samples)
    if kind or not channel.fs_hz > 0:
        return replace(facts, guess=kind or f"{_by_words(facts)}; {NO_RATE}")
    quality = raw_qualities([samples], [np.zeros(samples.size, dtype=bool)], channel.fs_hz)[0]
    facts = replace(
        facts,
        clip_share=quality.clip_share,
        mains_share=float(mains_ratios([samples], channel.fs_hz)[0]),
        noise=_noise(samples, channel.fs_hz),
    )
    return _judged(facts, samples)


def _by_shape(samples: Floats) -> str:
    step = np.diff(samples)
    if step[0] > 0 and np.all(np.abs(step - step[0]) <= 1e-3 * step[0]):
        return "a count or a time: it rises evenly"
    if np.unique(samples[:: max(1, samples.size // 2000)]).size <= 2 and np.unique(samples).size <= 3:
        return "a trigger: it holds two values"
    return ""


def _by_words(facts: ChannelFacts) -> str:
    """What unit and name say."""
    known = si_factor(facts.unit)
    if known is not None and known[0] == "N":
        return "a force, by its unit"
    meant = next((what for what, units in _MEANT.items() if facts.unit in units), None)
    is_weight = facts.unit == "g" and max(abs(facts.low), abs(facts.high)) > _MOST_ACCELERATION_G
    if meant is not None and not is_weight:
        return f"{meant}, by its unit"
    if facts.unit and seconds_per(facts.unit) is not None:
        return "a time, by its unit"
    if _EMG_NAME.search(facts.name) and not _NOT_EMG.search(facts.name):
        return "EMG, by its name"
    return "force, by its name" if _FORCE_NAME.search(facts.name) else "unknown"


def _judged(facts: ChannelFacts, samples: Floats) -> ChannelFacts:
    """EMG by its unit, name and spectrum; a force is chosen among all channels later."""
    words, known = _by_words(facts), si_factor(facts.unit)
    is_slow = _slow_share(samples, facts.fs_hz) > _SLOW_SHARE
    is_hum = facts.mains_share > _HUM_SHARE
    may_be_emg = (known is None or known[0] == "V") and not _NOT_EMG.search(facts.name)
    if facts.unit not in (None, "counts") and known is None and not words.startswith("EMG"):
        may_be_emg = False
    if words.startswith("force"):  # volts of a muscle with a name such as F1
        may_be_emg = may_be_emg and known is not None and not is_hum
    if may_be_emg and not is_slow and facts.fs_hz >= 100:
        if is_hum:
            if words.startswith("EMG"):
                hum = f"EMG, by its name, but {100 * facts.mains_share:.0f} % of its power is mains"
                return replace(facts, role="EMG", guess=hum)
            return replace(facts, guess="mains hum: was anything connected?")
        unit = f"unit ({facts.unit}) and " if known is not None else ""
        return replace(facts, role="EMG", guess=f"looks like EMG, by its {unit}spectrum")
    if words == "unknown":
        words = "slow: no EMG" if is_slow else "unknown: fast"
    elif words.startswith("EMG") and is_slow:
        words += ", but slow as an envelope is"
    return replace(facts, guess=words)


def _block_means(samples: Floats, size: int) -> Floats:
    return np.asarray(samples[: samples.size // size * size].reshape(-1, size).mean(axis=1))


def _slow_share(samples: Floats, fs_hz: float) -> float:
    """Share of the variance that means over 50 ms keep; 1 where they are single samples."""
    size = max(1, round(BLOCK_S * fs_hz))
    blocks = _block_means(samples, size)
    return float(blocks.var() / samples.var()) if blocks.size > 1 else 1.0


def _noise(samples: Floats, fs_hz: float) -> float:
    size = max(2, round(_REST_BLOCK_S * fs_hz))
    if samples.size < size:
        return math.nan
    blocks = samples[: samples.size // size * size].reshape(-1, size)
    return float(np.quantile(blocks.std(axis=1), _REST_SHARE))


def _level(channel: StoredChannel, every_s: float, grid: Floats) -> Floats:
    """Mean of ``every_s``, at the times ``grid`` (n,) in seconds, of the rectified samples less their mean."""
    size = max(1, round(every_s * channel.fs_hz))
    samples = np.nan_to_num(channel.samples - np.nanmean(channel.samples))
    levels = _block_means(np.abs(samples), size)
    return np.asarray(np.interp(grid, channel.start_s + (np.arange(levels.size) + 0.5) * size / channel.fs_hz, levels))


def _with_force(facts: list[ChannelFacts], stored: Sequence[StoredChannel | None]) -> list[ChannelFacts]:
    """The facts with the channel named that is most probably the force, and which way it goes."""
    pairs = [(f, s) for f, s in zip(facts, stored, strict=True) if s is not None]
    emg = [s for f, s in pairs if f.role == "EMG"]
    scored = [(_force_score(f, s, emg), f) for f, s in pairs if f.role == "other" and f.fs_hz > 0 and f.noise >= 0]
    (score, together), best = max(scored, key=lambda item: item[0][0], default=((0.0, 0.0), None))
    if best is None or score <= 0:
        return facts
    samples = next(s for f, s in pairs if f is best).samples
    why = "" if best.guess.startswith(("a force", "force")) else f" ({_BY_EMG}, r = {together:+.2f})"
    force = _as_force(best, samples, together, why)
    likely = {id(f) for (each, _), f in scored if each > 0}
    return [force if f is best else replace(f, may_press=id(f) in likely) for f in facts]


def force_by_file(facts: FileFacts) -> FileFacts:
    """A file that is named after the force: where no channel looks like one, its only slow channel is the force."""
    slow = [i for i, each in enumerate(facts.channels) if each.role == "other" and each.guess.startswith("slow")]
    stored = facts.stored[slow[0]] if len(slow) == 1 else None
    if facts.force is not None or stored is None:
        return facts
    channels = list(facts.channels)
    channels[slow[0]] = _as_force(channels[slow[0]], stored.samples, 0.0, " (the slow channel of a force file)")
    return replace(facts, channels=tuple(channels))


def _as_force(facts: ChannelFacts, samples: Floats, together: float, why: str) -> ChannelFacts:
    """The channel as the force. together : its correlation with the EMG, which tells which way it goes."""
    low, middle, high = np.nanquantile(samples, [0.001, 0.5, 0.999])
    falls = together < 0 if abs(together) > _RISES_WITH_EMG else middle - low > high - middle
    unit = f" {facts.unit}" if facts.unit else ""
    way = ", and pressing lowers it: sign = -1" if falls else ""
    said = f"looks like the force: {_short(facts.low)} to {_short(facts.high)}{unit}{way}{why}"
    return replace(facts, role="force", sign=-1 if falls else 1, guess=said)


def _force_score(facts: ChannelFacts, channel: StoredChannel, emg: Sequence[StoredChannel]) -> tuple[float, float]:
    """How likely a channel is the force, and how it goes with the level of the EMG."""
    together = _correlation(channel, emg)
    score = abs(together) if abs(together) > _RISES_WITH_EMG and facts.guess.startswith("slow") else 0.0
    if facts.guess.startswith("a force"):
        score = 2.0 + abs(together)
    elif facts.guess.startswith("force"):
        score = 1.0 + abs(together)
    upright = re.search(r"f[ _-]?\d*[ _-]?z(?![a-z])", facts.name, re.IGNORECASE) is not None
    return score + (0.5 if score and upright else 0.0), together


def _correlation(channel: StoredChannel, emg: Sequence[StoredChannel]) -> float:
    """Between the channel and the summed level of the EMG, in steps of 0.1 s; 0 where it cannot be known."""
    if not emg:
        return 0.0
    begin_s = min(c.start_s for c in (channel, *emg))  # a clock may count from 1970
    stop_s = min(c.start_s + c.samples.size / c.fs_hz for c in (channel, *emg))
    if stop_s - begin_s < 1:
        return 0.0
    grid = np.arange(begin_s, stop_s, 0.1)
    scaled = [_level(c, 0.1, grid) for c in emg]
    activity = np.sum([level / level.mean() for level in scaled if level.mean() > 0], axis=0)
    size = max(1, round(0.1 * channel.fs_hz))
    means = _block_means(np.nan_to_num(channel.samples, nan=float(np.nanmedian(channel.samples))), size)
    times = channel.start_s + (np.arange(means.size) + 0.5) * size / channel.fs_hz
    slow = np.interp(grid, times, means)
    if np.ndim(activity) == 0 or slow.std() == 0 or np.std(activity) == 0:
        return 0.0
    return float(np.corrcoef(slow, activity)[0, 1])


def _short(value: float) -> str:
    return f"{value:.3g}"
