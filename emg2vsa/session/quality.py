"""Signal quality before a session: muscles at rest, then at maximum contraction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from scipy import signal

from emg2vsa.arrays import Floats, bridge_gaps
from emg2vsa.errors import Emg2vsaError
from emg2vsa.extraction.contractions import contraction_levels_v, mean_levels_v
from emg2vsa.extraction.remedies import remedy_of
from emg2vsa.recordings import Channel
from emg2vsa.session.views import SignalView
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.quality import MAINS_HZ, raw_qualities
from emg2vsa.signals.verdicts import MAINS_WARNING

REST_S, CONTRACTION_S = 10.0, 3.0
"How long each is measured."
HIGH_PASS_HZ = 20.0
"Noise and bridges are looked for above this frequency."
NOISE_V, LOUD_V = 5e-6, 15e-6
"Root mean square at rest above which the electrodes, or the muscle's tone, are doubtful; and bad."
FLAT_V = 0.5e-6
"Root mean square of a channel that is connected to nobody."
HUM_V = 1e-3
"Hum above this root mean square is an electrode that is off."
BRIDGED = 0.95
"Correlation of two channels whose electrodes touch, or are joined by gel."
AT_RANGE, CLIPPED = 0.99, 1e-3
"Samples above this share of the source's range are clipped, and so many of them are a problem."
CONTRAST_DB = 12.0
"A muscle that a maximum contraction makes less loud than this over its rest is hardly measured."


def measured(
    rest: Mapping[str, Channel] | None,
    contraction: Mapping[str, Channel] | None,
    filters: FilterSettings,
    range_max_v: float | None,
) -> tuple[SignalView, ...]:
    """Levels and problems of every muscle, from what has been measured so far; channels in volts, by muscle."""
    muscles = tuple(rest or contraction or ())
    try:
        rest_v = {} if rest is None else mean_levels_v(rest, filters)
        contraction_v = {} if contraction is None else contraction_levels_v([contraction], filters)
    except Emg2vsaError as error:
        return tuple(SignalView(muscle, problems=((str(error), "measure again"),)) for muscle in muscles)
    problems: dict[str, list[tuple[str, str]]] = {muscle: [] for muscle in muscles}
    for channels, resting in ((rest, True), (contraction, False)):
        if channels is None:
            continue
        samples = {muscle: _bridged(muscle, channel) for muscle, channel in channels.items()}
        fs_hz = {muscle: channel.fs_hz for muscle, channel in channels.items()}
        for muscle, own in samples.items():
            problems[muscle] += _of_channel(muscle, own, fs_hz[muscle], resting, range_max_v)
        for one, other in _touching(samples, fs_hz):
            said = f"{one} and {other} are one signal above {HIGH_PASS_HZ:g} Hz"
            problems[one].append((said, "wipe the gel away between their electrodes; move the electrodes apart"))
    views = []
    for muscle in muscles:
        snr_db = snr_db_of(rest_v.get(muscle), contraction_v.get(muscle))
        own_problems = problems[muscle]
        if snr_db is not None and snr_db < CONTRAST_DB:
            said = f"{muscle} is {snr_db:.1f} dB over rest at maximum contraction"
            own_problems.append((said, "check the electrode's place over the muscle; ask for a harder contraction"))
        found = tuple(dict.fromkeys(own_problems))
        views.append(SignalView(muscle, rest_v.get(muscle), contraction_v.get(muscle), snr_db, found))
    return tuple(views)


def _bridged(muscle: str, channel: Channel) -> Floats:
    return bridge_gaps(channel.samples, muscle)[0]


def muscle_of(problem: str, muscles: Sequence[str]) -> str:
    """The muscle that a problem is about: its name begins the sentence, or ends it."""
    named = [own for own in muscles if problem.startswith(f"{own} ") or problem.endswith(f" {own}")]
    return max(named, key=len, default="")


def snr_db_of(rest_v: float | None, contraction_v: float | None) -> float | None:
    """dB of a muscle at maximum contraction, V, over rest, V; None where either is not known or 0."""
    if not rest_v or not contraction_v:
        return None
    return float(20 * np.log10(contraction_v / rest_v))


def _of_channel(
    muscle: str, samples: Floats, fs_hz: float, resting: bool, range_max_v: float | None
) -> Sequence[tuple[str, str]]:
    (quality,) = raw_qualities([samples], [np.zeros(samples.size, dtype=np.bool_)], fs_hz)
    rms_v = float(np.sqrt(np.mean(_fast(samples, fs_hz) ** 2)))
    if quality.flat or rms_v < FLAT_V:
        return [(said := f"{muscle} is flat", remedy_of(said))]
    found = []
    clipped = quality.clip_share
    if range_max_v is not None:
        clipped = max(clipped, float(np.mean(np.abs(samples) >= AT_RANGE * range_max_v)))
    if clipped > CLIPPED:
        found.append(said := f"{muscle} clips in {100 * clipped:.2g} % of samples")
    if resting and quality.mains_ratio > MAINS_WARNING:
        found.append(f"mains is {100 * quality.mains_ratio:.0f} % of the power of {muscle}")
    told = [(said, remedy_of(said)) for said in found]
    hum_v = rms_v * float(np.sqrt(quality.mains_ratio))
    if hum_v > HUM_V:
        told.append((f"{muscle} holds {1e3 * hum_v:.1f} mV of hum", "the electrode is off: clean the skin, attach it"))
    noise_v = _noise_v(samples, fs_hz) if resting else 0.0
    if noise_v > NOISE_V:
        much = "far too loud" if noise_v > LOUD_V else "loud"
        do = "ask to relax the arm; clean the skin, check electrode and cable"
        told.append((f"{muscle} is {much} at rest: {1e6 * noise_v:.1f} uV", do))
    return told


def _fast(samples: Floats, fs_hz: float) -> Floats:
    sections = signal.butter(2, HIGH_PASS_HZ, "highpass", fs=fs_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(sections, samples), dtype=np.float64)


def _noise_v(samples: Floats, fs_hz: float) -> float:
    """Root mean square (V) of the quieter pieces of half a second: a movement within the rest is no noise."""
    size = round(fs_hz / 2)
    fast = _fast(samples, fs_hz)
    pieces = fast[: fast.size // size * size].reshape(-1, size)
    return float(np.median(np.sqrt(np.mean(pieces**2, axis=1)))) if pieces.size else 0.0


def _touching(samples: Mapping[str, Floats], fs_hz: Mapping[str, float]) -> list[tuple[str, str]]:
    """Pairs of muscles that hold one signal, the mains that all share aside."""
    fast = {muscle: _without_mains(_fast(own, fs_hz[muscle]), fs_hz[muscle]) for muscle, own in samples.items()}
    found = []
    for one, other in combinations(fast, 2):
        n = min(fast[one].size, fast[other].size)
        x, y = fast[one][:n], fast[other][:n]
        norm = float(np.sqrt((x @ x) * (y @ y)))
        if norm > 0 and abs(float(x @ y)) > BRIDGED * norm:
            found.append((one, other))
    return found


def _without_mains(samples: Floats, fs_hz: float) -> Floats:
    for hz in MAINS_HZ:
        if hz < fs_hz / 2:
            samples = np.asarray(signal.filtfilt(*signal.iirnotch(hz, 10, fs_hz), samples), dtype=np.float64)
    return samples
