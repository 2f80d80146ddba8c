"""Recordings against the others of their study.

Logarithms of a trait are residuals from the medians of the person and of the specimen; what a whole session has in
common is compared between people. A residual counts by its size and by the study's own spread (median absolute
residual), which must not be taken for smaller than people vary at all.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.extraction import Trials
from emg2vsa.screening import Screened, Screening, Verdict
from emg2vsa.screening.copies import Found, Key, copies
from emg2vsa.settings import PressJudgement
from emg2vsa.signals.overview import EMG_FROM_HZ
from emg2vsa.signals.traits import Traits

FEWEST = 3
"So many recordings, or people, must be there to say what is normal."
FAR = 5.0
"Spreads from what is normal."
GAIN = np.log(1.5) - 0.08
"Least jump of a level within a person's recordings that is told."
COMMON_GAIN = np.log(1.2)
"... where noise and levels of all muscles jumped alike."
TO_NOISE, TO_PEOPLES_NOISE = 0.3, 0.4
"""A gain changes the amplifier's noise as it changes presses, within this logarithm; beside other people, whose levels
differ, presses must go by this share of it the same way."""
GONE, GONE_BESIDE = 0.1, 1 / 40
"Power density of noise, over the study's, and over the largest such ratio, that only a filter leaves."
PEOPLE_GAIN = np.log(8.0)
"Least difference of a whole session's levels from those of other people, where noise at rest is no witness."
BAND = 0.2
"Least logarithm by which an edge of a band moves where a filter moved it."
CLOCK = 0.05
"A line at the mains is known so well, as a share."
UNITS = {"lbf": 4.448, "ozf": 3.597, "kgf": 9.807, "gf": 101.97}
"The force in these units is smaller than in newtons by the factor; ounces: 3.597 to the newton."
UNIT_WITHIN = 0.1
SPREAD = {"level": 0.08, "noise": 0.05, "band": 0.03, "duration": 0.1, "peak": 0.02}
"Least spreads of the logarithms."
LATE_S = 0.15
"Force that is further from the study's lag leaves rest in the presses and presses in the rest: no trait holds."
HARMLESS = 0.08
"Filters that change b by a smaller share are told, and the recording is used."
HOLE = 0.15
"Least power in the middle of the spectrum, as a share of what the study has there; sampling leaves 0.4 and more."


@dataclass(frozen=True)
class _Apart:
    """(n,) logarithm of what a trait of each recording is, over what it should be; z : in spreads."""

    size: Floats
    z: Floats

    def beyond(self, least: float) -> NDArray[np.bool_]:
        return (np.abs(self.size) > least) & (np.abs(self.z) > FAR)


def traits_by_recording(trials: Iterable[Trials]) -> dict[Key, Traits]:
    """(participant, specimen) to the traits of each; copied, so that the rest of the trials need not stay in memory."""
    return {(each.participant, each.specimen): _copied(each.traits) for each in trials}


def _copied(traits: Traits) -> Traits:
    values = {field.name: getattr(traits, field.name) for field in fields(traits)}
    arrays: dict[str, Any] = {name: each.copy() for name, each in values.items() if isinstance(each, np.ndarray)}
    return replace(traits, **arrays)


def visits_of(trials: Trials) -> tuple[str, ...]:
    """Labels of the visits at which presses were recorded that are not rejected."""
    return tuple(dict.fromkeys(trials.visit[trials.verdict[: trials.visit.size] != "rejected"].tolist()))


def screen(
    traits: Mapping[Key, Traits], judgements: Sequence[PressJudgement] = (), visits: Mapping[Key, Sequence[str]] = {}
) -> Screening:
    """What is unlike the rest of a study.

    traits : (participant, specimen) to those of the recording. judgements : of people; a recording that is accepted as
    a whole stays, with what was found. visits : (participant, specimen) to what `visits_of` tells.
    """
    accepted = {(j.participant, j.specimen) for j in judgements if j.repetition is None and not j.excludes}
    found: dict[Key, Screened] = {}
    for key, cause, text, share, verdict in (*copies(traits), *_unlike(traits, visits)):
        if key not in found:
            found[key] = Screened(*key, cause, text, share, "ok" if key in accepted else verdict)
    return Screening(tuple(found[key] for key in traits if key in found), tuple(_unequal(visits)))


def _unequal(visits: Mapping[Key, Sequence[str]]) -> Iterator[tuple[str, str, str]]:
    of_person: dict[str, dict[str, Sequence[str]]] = {}
    for (who, what), at in visits.items():
        of_person.setdefault(who, {}).update({what: at} if at else {})
    for who, own in of_person.items():
        for visit in sorted({visit for at in own.values() for visit in at}):
            if lacks := [what for what, at in own.items() if visit not in at]:
                yield who, visit, ", ".join(lacks)


def _unlike(traits: Mapping[Key, Traits], visits: Mapping[Key, Sequence[str]]) -> Iterator[Found]:
    if len(traits) < FEWEST:
        return
    keys, own = list(traits), list(traits.values())
    muscles = own[0].muscles
    if any(each.muscles != muscles for each in own):
        return  # levels of other muscles are other levels
    study = _Study(keys, own, visits)
    for i, key in enumerate(keys):
        yield from ((key, *said) for said in study.said(i))


class _Study:
    """All recordings by their traits, and how far each is from what is normal."""

    def __init__(self, keys: Sequence[Key], own: Sequence[Traits], visits: Mapping[Key, Sequence[str]]) -> None:
        self.own, self.muscles = own, own[0].muscles
        # recordings of a person compare where they are of the same visits: electrodes are placed anew at each
        self._people = np.unique([f"{key[0]} {visits.get(key, ())}" for key in keys], return_inverse=True)[1]
        self._specimens = np.unique([what for _, what in keys], return_inverse=True)[1]
        m = range(len(self.muscles))
        self.level = [self._apart("level", [each.press_v[k] for each in own]) for k in m]
        self.noise = [self._apart("noise", [each.noise_v[k] for each in own]) for k in m]
        self.press_band = [[self._apart("band", [t.press_band_hz[k, e] for t in own]) for e in range(3)] for k in m]
        self.duration = self._apart("duration", [each.duration_s for each in own])
        self.peak = self._apart("peak", [each.peak_n for each in own])
        lags_s = np.array([each.lag_s for each in own])
        known = lags_s[np.isfinite(lags_s)]
        self.late_s = np.abs(lags_s - (np.median(known) if known.size else np.nan))
        lines = np.array([each.line_hz for each in own])
        self.mains_hz = float(np.nanmedian(lines)) if np.isfinite(lines).sum() >= FEWEST else np.nan
        self.hz, self.spectrum, self.rest_density = self._typical()

    def _typical(self) -> tuple[Floats, Floats, Floats]:
        """Frequencies (F,), spectrum (F,) and density at rest (m, F): medians of recordings with most's frequencies."""
        sizes = [each.spectrum.size for each in self.own]
        most = max(set(sizes), key=sizes.count)
        alike = [each for each in self.own if each.spectrum.size == most and np.isfinite(each.spectrum).all()]
        if not alike:
            return np.empty(0), np.empty(0), np.empty((len(self.muscles), 0))
        densities = np.median([each.rest_density for each in alike], axis=0)
        return alike[0].frequency_hz, np.median([each.spectrum for each in alike], axis=0), densities

    def _silent(self, i: int, k: int) -> tuple[float, float]:
        """Band in Hz outside which the noise at rest of muscle k is gone: little beside the study's, and beside what
        is left of it in other frequencies, which muscle tone raises and a gain changes alike. 0 and infinity: none."""
        own, typical = self.own[i].rest_density[k], self.rest_density[k]
        if own.size != typical.size or not typical.all():
            return 0.0, np.inf
        ratio = np.where(self.hz >= EMG_FROM_HZ, own / typical, np.nan)
        here = np.flatnonzero(~(ratio < min(GONE, np.nanmax(ratio) * GONE_BESIDE)) & np.isfinite(ratio))
        inside = np.flatnonzero(np.isfinite(ratio))
        if not here.size:
            return 0.0, np.inf
        # the cut of a filter that ran forwards and backwards is where a quarter of the power is left
        kept = np.flatnonzero(ratio > np.median(ratio[here]) / 4)
        low = self.hz[kept[0]] if here[0] > inside[0] + 1 else 0.0
        return float(low), float(self.hz[kept[-1]]) if here[-1] < inside[-1] - 5 else np.inf

    def _apart(self, kind: str, values: Sequence[float]) -> tuple[_Apart, _Apart]:
        """Within the person's recordings, and of the recording against other people's."""
        with np.errstate(divide="ignore", invalid="ignore"):
            log = np.log(np.array(values, dtype=np.float64))
        log[~np.isfinite(log)] = np.nan
        person = _medians(log, self._people)
        specimen = _medians(log - person, self._specimens)
        person = _medians(log - specimen, self._people)
        within = log - specimen - person
        counts = np.bincount(self._people, np.isfinite(log))[self._people]
        within[counts < FEWEST] = np.nan
        apart = log - specimen
        own = [apart[self._people == one] for one in np.unique(self._people)]
        of_people = np.array([np.nanmedian(each) if np.isfinite(each).any() else np.nan for each in own])
        known = of_people[np.isfinite(of_people)]
        between = apart - np.median(known) if known.size >= FEWEST + 2 else np.full(log.size, np.nan)
        least = SPREAD[kind]
        spread = max(least, _spread(between))
        return _Apart(within, within / max(least, _spread(within))), _Apart(between, between / spread)

    def said(self, i: int) -> Iterator[tuple[str, str, float, Verdict]]:
        """What is wrong with recording i, the most certain first."""
        if not np.isfinite(self.own[i].press_v).all():
            return  # without presses even the rest may hold something else
        if (factor := self._clock(i)) is not None:
            line = self.own[i].line_hz
            seen = (
                f"mains at {line:.1f} Hz"
                if np.isfinite(line) and self._line_off(i)
                else "all frequencies and durations"
            )
            text = f"its time runs {factor:.3g} times as long as in the other recordings ({seen}); is its rate right?"
            yield "time scale", text, np.nan, "doubtful"
        elif self.late_s[i] > LATE_S:
            return
        elif (unit := self._unit(i)) is not None:
            peak = self.own[i].peak_n
            text = f"its presses peak at {peak:.3g} N, unlike all others; is its unit {unit}?"
            yield "unit of force", text, np.nan, "doubtful"
        elif (filtered := self._filtered(i)) is not None:
            yield "filters in the file", *filtered
        elif (gain := self._gain(i)) is not None:
            off, share = gain
            if self._exchanged(i, off):
                text = f"{' and '.join(self.muscles)} are as loud as each other elsewhere; were they exchanged?"
                yield "muscles exchanged", text, share, "told"
                return
            named = [(m, np.exp(each)) for m, each in zip(self.muscles, off.tolist(), strict=True) if each]
            who = ", ".join(f"{muscle} {factor:.2g}" for muscle, factor in named)
            text = f"its EMG is unlike the other recordings by a factor ({who}); is its gain right?"
            yield "gain", text, share, "doubtful"

    def _exchanged(self, i: int, off: Floats) -> bool:
        """Whether each of two muscles is as loud as the other should be."""
        level = np.log(self.own[i].press_v)
        return off.size == 2 and bool(np.all(off)) and bool(np.all(np.abs((level - off)[::-1] - level) < TO_NOISE))

    def _line_off(self, i: int) -> bool:
        line = self.own[i].line_hz
        if not np.isfinite(line) or not np.isfinite(self.mains_hz):
            return False
        ratio = line / self.mains_hz
        nearest = round(ratio)
        return abs(ratio / nearest - 1) > CLOCK if nearest else abs(ratio - 1) > CLOCK

    def _scaled(self, i: int) -> float:
        """Median logarithm by which the bands of all muscles moved; NaN where they did not move together."""
        moved = [self._size(one, i) for bands in self.press_band for one in bands]
        known = [each for each in moved if np.isfinite(each)]
        if not known or np.ptp(known) > max(0.12, 0.25 * abs(np.median(known))):
            return np.nan
        return float(np.median(known))

    def _size(self, pair: tuple[_Apart, _Apart], i: int) -> float:
        """Within the person where that is known, unless the whole session is off."""
        within, between = pair
        return float(between.size[i] if np.isfinite(between.size[i]) else within.size[i])

    def _clock(self, i: int) -> float | None:
        """How many times longer its time runs."""
        if self._line_off(i):
            return float(self.mains_hz / self.own[i].line_hz)
        moved = self._scaled(i)
        longer = self._size(self.duration, i)
        middles = [bands[1] for bands in self.press_band]
        clear = all(_either(each, i, BAND) for each in middles)
        if clear and abs(moved) > BAND and np.isfinite(longer) and abs(longer + moved) < 0.35 and longer * moved < 0:
            return float(np.exp(-moved))
        return None

    def _unit(self, i: int) -> str | None:
        if not _either(self.peak, i, 0.3):
            return None
        off = self._size(self.peak, i)
        for unit, factor in UNITS.items():
            if abs(abs(off) - np.log(factor)) < UNIT_WITHIN:
                return unit
        return None

    def _filtered(self, i: int) -> tuple[str, float, Verdict] | None:
        """What the band of the file is, where its edges moved in a muscle."""
        own = self.own[i]
        for k, muscle in enumerate(self.muscles):
            press = self.press_band[k]
            bottom, middle, top = (self._moved(each, i) for each in press)
            bottom_hz, _, top_hz = own.press_band_hz[k]
            low_hz, high_hz = self._silent(i, k)
            if low_hz == 0 and high_hz == np.inf and self._like_own(press, i):
                continue
            if top < 0 and middle < -0.7:
                text = f"{muscle} lies below {top_hz:.0f} Hz, unlike all others; is it an envelope?"
                return text, self._share_of_level(i), "doubtful"
            ends, begins = top < 0 or high_hz < np.inf, bottom > 0 or (low_hz > 0 and self._lacks(i, low_hz))
            if ends or begins:
                seen = high_hz < np.inf if ends else low_hz > 0
                hz = (high_hz if seen else top_hz) if ends else (low_hz if seen else bottom_hz)
                filtered = (
                    "ends at {:.0f} Hz{}; was it low-passed or resampled?"
                    if ends
                    else ("begins at {:.0f} Hz{}; was it high-passed?")
                )
                text = f"{muscle} {filtered.format(hz, ', unlike all others')}"
                share = self._share_of_band(i, k) if seen else np.nan
                if abs(share) < HARMLESS and not (top or middle or bottom):
                    return text, share, "told"
                # where presses lie elsewhere though little was taken from their band, more was done than a filter
                return self._counted(text, share if abs(share) >= HARMLESS else self._share_of_level(i))
            if middle:
                hz = own.press_band_hz[k, 1]
                said = f"{muscle} has its median frequency at {hz:.0f} Hz, unlike all others"
                return self._counted(f"{said}; was it filtered or rectified?", self._share_of_level(i))
        return self._hole(i)

    def _like_own(self, bands: Sequence[tuple[_Apart, _Apart]], i: int) -> bool:
        """Whether the person's other recordings have the same band: people's muscles and skin differ."""
        return all(np.isfinite(within.z[i]) and not within.beyond(BAND)[i] for within, _ in bands)

    def _counted(self, text: str, share: float) -> tuple[str, float, Verdict]:
        """What changes b by little is told: electrodes differ too. What is not known counts."""
        return text, share, "told" if abs(share) < HARMLESS else "doubtful"

    def _lacks(self, i: int, below_hz: float) -> bool:
        """Whether presses lack what the study's have below a frequency: a relaxed hand lacks it at rest only."""
        own = self.own[i].spectrum
        low = (self.hz >= EMG_FROM_HZ) & (self.hz < below_hz)
        return own.size == low.size and bool(own[low].sum() < HOLE * self.spectrum[low].sum())

    def _hole(self, i: int) -> tuple[str, float, Verdict] | None:
        """Frequencies amid the study's spectrum that the recording lacks."""
        own = self.own[i].spectrum
        if own.size != self.spectrum.size or not np.isfinite(own).all():
            return None
        amid = self.spectrum > 0.3 * self.spectrum.max(initial=0.0)
        hole = amid & (own < HOLE * self.spectrum)
        if not np.any(hole[1:] & hole[:-1]):
            return None  # one bin alone is chance
        hz = self.hz[hole]
        share = float(np.sqrt(1 - self.spectrum[hole].sum() / self.spectrum.sum()) - 1)
        text = f"its EMG has nothing at {hz.min():.0f} to {hz.max():.0f} Hz, unlike all others; was a notch filter run?"
        return self._counted(text, share)

    def _moved(self, pair: tuple[_Apart, _Apart], i: int) -> float:
        """The size where it is off, else 0."""
        return self._size(pair, i) if _either(pair, i, BAND) else 0.0

    def _share_of_band(self, i: int, k: int) -> float:
        """What a filter leaves of the amplitude of the study's typical spectrum, minus 1.

        Noise of muscle k at rest over that of the study is the square of its gain, which is 1 where most is left.
        """
        own, typical = self.own[i].rest_density[k], self.rest_density[k]
        known = self.hz >= EMG_FROM_HZ
        ratio = own[known] / typical[known]
        left = np.minimum(ratio / np.quantile(ratio[ratio > ratio.max() / 4], 0.75), 1.0)
        return float(np.sqrt(left @ self.spectrum[known] / self.spectrum[known].sum()) - 1)

    def _share_of_level(self, i: int) -> float:
        """The level of all muscles over what it should be, minus 1."""
        off = np.array([self._size(each, i) for each in self.level])
        level_v = self.own[i].press_v
        with np.errstate(invalid="ignore", divide="ignore"):
            return float(level_v.sum() / np.sum(level_v * np.exp(-off)) - 1)

    def _gain(self, i: int) -> tuple[Floats, float] | None:
        """Logarithms (m,) by which levels jumped, 0 where they did not, and the share of b: within a person, or in a
        whole session whose noise at rest jumped alike."""
        off = np.zeros(len(self.muscles))
        beside = np.array([between.size[i] for _, between in self.level])
        for k, ((within, between), (rest_within, rest_between)) in enumerate(zip(self.level, self.noise, strict=True)):
            with_noise = rest_within.beyond(GAIN)[i] and abs(within.size[i] - rest_within.size[i]) < TO_NOISE
            if within.beyond(GAIN)[i] or with_noise:
                off[k] = within.size[i]
            elif rest_between.beyond(GAIN)[i]:
                # beside other people, or beside the person's other muscles, whose loudness goes with it
                least, others = TO_PEOPLES_NOISE * abs(rest_between.size[i]), np.delete(beside, k)
                apart = beside[k] - np.array([0.0, others.mean() if others.size else 0.0])
                if np.any(apart * np.sign(rest_between.size[i]) > least):
                    off[k] = rest_between.size[i]
            elif between.beyond(PEOPLE_GAIN)[i]:
                off[k] = between.size[i]
        if not off.any():
            off[:] = self._common_gain(i)
        if not off.any():
            return None
        level_v = self.own[i].press_v
        return off, float(level_v.sum() / np.sum(level_v * np.exp(-off)) - 1)

    def _common_gain(self, i: int) -> float:
        """Logarithm by which levels and noise of all muscles jumped together within a person; 0 where they did not."""
        levels = np.array([within.size[i] for within, _ in self.level])
        noise = np.array([[within.size[i], within.z[i]] for within, _ in self.noise])
        jump, z = noise.mean(axis=0)
        alike = abs(levels.mean() - jump) < TO_NOISE / 2 and abs(jump) > COMMON_GAIN and len(levels) > 1
        return float(jump) if alike and abs(z) * len(levels) ** 0.5 > FAR else 0.0


def _either(pair: tuple[_Apart, _Apart], i: int, least: float) -> bool:
    """Whether a recording is off within its person, or beside other people."""
    return any(bool(each.beyond(least)[i]) for each in pair)


def _medians(values: Floats, groups: NDArray[np.intp]) -> Floats:
    """(n,) median of the group of each, of what is known."""
    found = np.full(values.size, np.nan)
    for group in np.unique(groups):
        own = values[groups == group]
        if np.isfinite(own).any():
            found[groups == group] = np.nanmedian(own)
    return found


def _spread(residuals: Floats) -> float:
    """Standard deviation by the median size of those that are no median themselves."""
    sizes = np.sort(np.abs(residuals[np.abs(residuals) > 1e-12]))
    return 1.4826 * float(sizes[(sizes.size - 1) // 2]) if sizes.size else 0.0
