"""One recording: from a file or a table to its presses, their samples and their fits v = a + b ln F."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from emg2vsa import __version__
from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import fit_edges
from emg2vsa.curves.press_fits import fit_presses
from emg2vsa.errors import DataError, SettingError, StudyError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, fit_trials
from emg2vsa.public.given import (
    LABELS,
    column,
    file_of,
    numbers_of,
    of_kind,
    plain,
    refuse_missing_labels,
    settings_or_default,
)
from emg2vsa.public.headers import clock, headed, unit_of
from emg2vsa.readers.front_door import inspect
from emg2vsa.readers.opened import StoredChannel, usable
from emg2vsa.readers.roles import (
    SLOWEST_EMG_HZ,
    SLOWEST_FORCE_HZ,
    RoleChannels,
    emg_in_v,
    force_in_n,
    read_roles,
    refuse_rate,
)
from emg2vsa.recordings import Channel
from emg2vsa.settings import ChannelSettings, StageSettings
from emg2vsa.study_file.problems import checked, shown

Source = str | PathLike[str]
"""A file."""


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """EMG of named muscles in volts and the pressing force in newtons, each at its own rate, as `read` makes it."""

    name: str
    roles: RoleChannels
    channels: ChannelSettings

    def __repr__(self) -> str:
        muscles = ", ".join(f"{role} {channel.fs_hz:g} Hz" for role, channel in self.roles.emg.items())
        force = self.roles.force
        return f"Recording({self.name!r}: {muscles}, force {force.fs_hz:g} Hz, {force.duration_s:.1f} s)"

    def to_frame(self) -> pd.DataFrame:
        """Columns ``time_s``, ``<muscle>_v`` and ``force_n`` at the instants of the first muscle's samples.

        The others are interpolated linearly where their samples lie elsewhere, for looking at; fits do better.
        """
        emg = self.roles.emg
        first = next(iter(emg.values()))
        time_s = first.start_s + np.arange(first.samples.size) / first.fs_hz
        columns = {f"{role}_v": _at(time_s, channel) for role, channel in emg.items()}
        frame = pd.DataFrame({"time_s": time_s, **columns, "force_n": _at(time_s, self.roles.force)})
        frame.attrs = {"recording": self.name, "notes": list(self.roles.notes), "emg2vsa": __version__}
        return frame


def _at(time_s: Floats, channel: Channel) -> Floats:
    own_s = channel.start_s + np.arange(channel.samples.size) / channel.fs_hz
    same = own_s.size == time_s.size and np.array_equal(own_s, time_s)
    return channel.samples if same else np.interp(time_s, own_s, channel.samples, left=np.nan, right=np.nan)


def channels(file: Source) -> pd.DataFrame:
    """The channels of a recording: ``name``, ``unit``, ``fs_hz``, ``n_samples``. RecordingError: it cannot be read."""
    name, found = inspect(file_of(file, "channels"))
    frame = pd.DataFrame([vars(one) for one in found], columns=["name", "unit", "fs_hz", "n_samples"])
    frame.attrs = {"file": str(file), "format": name, "emg2vsa": __version__}
    return frame


def read(
    source: Source | pd.DataFrame,
    *,
    emg: Sequence[str] | Mapping[str, str],
    force: str,
    force_file: Source | None = None,
    fs_hz: float | None = None,
    emg_unit: str | None = None,
    gain: float = 1.0,
    force_unit: str | None = None,
    newtons_per_unit: float | None = None,
    sign: int = 1,
    tare: bool = True,
    settings: StageSettings | None = None,
) -> Recording:
    """Read a recording from a file of any known format, or from a table of samples.

    Parameters
    ----------
    source : a file, or a DataFrame with a column for each channel, evenly sampled at ``fs_hz``. Headers may be those of
        a file: ``EDC (mV)``, ``Fz [N]``, ``time [s]``.
    emg : names of the EMG channels, or muscle to name. force : name of the force channel. Columns of a DataFrame may
        have whole numbers for names.
    force_file : second file that holds the force, on the same clock.
    fs_hz : sampling rate, where the file does not state it; of a DataFrame it is needed unless it has times.
    emg_unit, force_unit, newtons_per_unit, gain : where file or headers do not say; a DataFrame is then in V and N.
        newtons_per_unit is for a unit that is no force. A header that states another unit is an error.
    sign : -1 where the sensor reports a press as a negative force. tare : take the force at rest off.
    settings : its table ``reading`` limits decoders.

    Raises
    ------
    RecordingError : the file, or a channel, cannot be used. DataError : a column cannot. StudyError, SettingError : an
    option that cannot be.
    """
    reading = settings_or_default(settings).reading
    table = source if isinstance(source, pd.DataFrame) else None
    path = Path("DataFrame") if table is not None else file_of(source, "read", "a file or a DataFrame")
    muscles, force = _muscles(emg, plain(force), table is not None, force_file is None), plain(force)
    units = dict.fromkeys(muscles.values(), emg_unit)
    if table is not None:
        units = {name: unit_of(table, name, emg_unit, "V", "emg_unit") for name in muscles.values()}
        force_unit = unit_of(table, force, force_unit, "N" if newtons_per_unit is None else None, "force_unit")
    spelt = {name: name if table is None else str(name) for name in (*muscles.values(), force)}
    asked = plain({
        "emg": {
            role: {"name": spelt[name], "unit": units[name], "gain": gain, "fs_hz": fs_hz}
            for role, name in muscles.items()
        },
        "force": {
            "name": spelt[force], "unit": force_unit, "newtons_per_unit": newtons_per_unit, "sign": sign,
            "tare": "rest" if tare else "none", "fs_hz": fs_hz,
        },
    })  # fmt: skip
    made, problems = checked(ChannelSettings, asked, ("channels",))
    if problems:
        raise StudyError(tuple(f"read: {problem}" for problem in problems))
    second = None if force_file is None else file_of(force_file, "read, force_file")
    if table is None:
        return Recording(path.stem, read_roles(path, second, made, reading), made)
    if second is not None:
        do = "Put the force into a column of the table."
        raise SettingError("read, force_file", wanted="none beside a DataFrame", found=str(second), do=do)
    return _of_table(table, path, muscles, force, made)


def _muscles(emg: Any, force: Any, is_table: bool, one_file: bool) -> dict[str, Any]:
    """Muscle to the name of its channel. SettingError: names that are none, or one name for two channels."""
    emg = plain(emg)
    named = [emg] if isinstance(emg, str) else emg
    if not isinstance(named, (Mapping, list, tuple)):
        do = 'Write emg=["EDC", "FDS"].'
        raise SettingError("read, emg", wanted="names, or muscle to name", found=shown(emg), do=do)
    names = [*(named.values() if isinstance(named, Mapping) else named), force]
    kinds, wanted = ((str, int), "names of columns") if is_table else ((str,), "names as text")
    for index, name in enumerate(names):
        where = "read, force" if index == len(names) - 1 else "read, emg"
        if not isinstance(name, kinds) or isinstance(name, bool):
            do = "Give the name of the channel."
            raise SettingError(where, wanted=wanted, found=shown(name), do=do)
        if name in names[:index] and (one_file or index < len(names) - 1):
            do = "Name each channel once."
            raise SettingError(where, wanted="a channel of its own for each role", found=f"{name!r} twice", do=do)
    return (
        {str(role): name for role, name in named.items()} if isinstance(named, Mapping) else {str(n): n for n in named}
    )


def _of_table(
    table: pd.DataFrame, path: Path, muscles: Mapping[str, Any], force: Any, asked: ChannelSettings
) -> Recording:
    """A recording from columns of samples, by the rules for those of a file that states no unit."""
    columns = {name: numbers_of(table, headed(table, name)[0]) for name in (*muscles.values(), force)}
    fs_hz, start_s = asked.force.fs_hz, 0.0
    if (times := clock(table, has_rate=fs_hz is not None)) is not None:
        label, unit_s = times
        fs_hz, start_s = _rate_and_start(numbers_of(table, label, wanted="seconds as numbers") * unit_s, fs_hz, label)
    if fs_hz is None:
        do = "Give the sampling rate: fs_hz=1000."
        raise SettingError("read, fs_hz", wanted="a rate in Hz for a DataFrame without times", found="none", do=do)

    def stored(name: Any, unit: str | None, slowest_hz: float) -> StoredChannel:
        unit = unit or headed(table, name)[1]
        channel = usable(path, str(name), StoredChannel(str(name), columns[name], unit, fs_hz, start_s))
        refuse_rate(path, channel, slowest_hz)
        return channel

    emg = {
        role: emg_in_v(path, stored(muscles[role], one.unit, SLOWEST_EMG_HZ), one) for role, one in asked.emg.items()
    }
    pressing = stored(force, asked.force.unit, SLOWEST_FORCE_HZ)
    notes = pressing.notes
    return Recording("DataFrame", RoleChannels(emg, force_in_n(path, pressing, asked.force), "DataFrame", notes), asked)


_REPEATING = 0.02
"""Fewer steps of another length than the usual are lost or repeated samples, and no rounding."""
_DRIFT = 0.5
"""Most that times may wander about even spacing, in steps. One lost sample makes them wander by a whole step."""
_RATES_DIFFER = 0.01


def _rate_and_start(time_s: Floats, fs_hz: float | None, label: str) -> tuple[float, float]:
    """Rate (Hz) and start (s) of times (n,) in seconds; ``fs_hz`` goes before the measured rate where it is given.

    label : of their column.

    Times are judged as a whole: about the straight line through them they may wander by their rounding and half a step.
    DataError: they are not evenly spaced. SettingError: ``fs_hz`` is another rate.
    """
    even = time_s.size > 1 and bool(np.isfinite(time_s).all())
    steps = np.diff(time_s) if even else np.zeros(1)
    rounding_s = _rounding_s(time_s, steps) if even else 0.0
    even = even and bool(np.all(steps >= 0 if rounding_s else steps > 0)) and bool(time_s[-1] > time_s[0])
    if even:
        counts = np.arange(time_s.size) - (time_s.size - 1) / 2
        since_s = time_s - time_s.mean()
        step_s = float(counts @ since_s / (counts @ counts))
        even = bool(np.ptp(since_s - step_s * counts) <= rounding_s * (1 + 1e-9) + _DRIFT * step_s)
    if not even:
        raise DataError(
            f"DataFrame, {label}", wanted="times that rise by one step", found="other steps",
            do="Resample the table, split it at gaps, or give fs_hz and drop the column.",
        )  # fmt: skip
    measured_hz = (time_s.size - 1) / float(time_s[-1] - time_s[0])
    # the ends are rounded too: a short table does not tell its rate better than that
    slack = _RATES_DIFFER + 2 * rounding_s / float(time_s[-1] - time_s[0])
    if fs_hz is not None and abs(fs_hz - measured_hz) > slack * measured_hz:
        do = f"Leave fs_hz out, or drop the column {label}."
        found = f"{fs_hz:g} Hz"
        raise SettingError("read, fs_hz", wanted=f"{measured_hz:.6g} Hz, as {label} says", found=found, do=do)
    return fs_hz or measured_hz, float(time_s[0])


def _rounding_s(time_s: Floats, steps: Floats) -> float:
    """Worth of the last decimal of times whose steps differ by it; 0 where they hardly do, or no decimal is seen."""
    usual = float(np.median(steps))
    for decimals in range(7):
        if np.allclose(time_s, np.round(time_s, decimals), rtol=1e-14, atol=1e-12):
            last_s = 10.0**-decimals
            return last_s if np.mean(np.abs(steps - usual) > 0.5 * last_s) > _REPEATING else 0.0
    return 0.0


def _extracted(recording: Recording, settings: StageSettings | None, participant: str, specimen: str) -> Trials:
    settings = settings_or_default(settings)
    do = "Read the file first: emg2vsa.read(file, emg=[...], force=...)."
    of_kind(recording, Recording, "recording", "a Recording", do)
    return extract_trials(
        recording.roles.emg,
        recording.roles.force,
        participant=participant,
        specimen=specimen,
        filters=settings.filters,
        cocontraction=settings.cocontraction,
        window=settings.window,
        force_channel=recording.channels.force,
        notes=recording.roles.notes,
    )


def trials(
    recording: Recording, settings: StageSettings | None = None, *, participant: str = "", specimen: str = ""
) -> pd.DataFrame:
    """The presses of a recording, one row each: when, how hard, how good, and why not.

    Columns: participant, specimen, repetition, start_s, stop_s, duration_s, peak_force_n, falling_share, snr_db,
    verdict (ok, rejected), reason. SignalError : the recording cannot be conditioned.
    """
    return trials_frame(_extracted(recording, settings, participant, specimen))


def samples(
    recording: Recording, settings: StageSettings | None = None, *, participant: str = "", specimen: str = ""
) -> pd.DataFrame:
    """The conditioned samples within the presses: repetition, force_n, activity_v, and <muscle>_v of each envelope."""
    return samples_frame(_extracted(recording, settings, participant, specimen))


def fit(
    source: Recording | pd.DataFrame,
    settings: StageSettings | None = None,
    *,
    participant: str = "",
    specimen: str = "",
) -> pd.DataFrame:
    """Fit v = a + b ln(F / 1 N), equation (6), to every press; one row each.

    source : a `Recording`, or a DataFrame with ``force_n`` and ``activity_v``: samples that are conditioned already, as
    `samples` gives them. Every participant, specimen and repetition that its columns of these names tell is a press;
    presses keep the order in which they first appear.

    Columns of a recording: those of `trials` that tell the press, and ``a_v``, ``b_v`` with standard errors, the
    interval ``b_lo_v`` to ``b_hi_v``, ``n_points``, ``adj_r2`` and more.
    SignalError, DataError : what cannot be fitted.
    """
    settings = settings_or_default(settings)
    if isinstance(source, pd.DataFrame):
        return _fit_table(source, settings)
    return fits_frame(fit_trials(_extracted(source, settings, participant, specimen), settings.fit, settings.window))


def _fit_table(table: pd.DataFrame, settings: StageSettings) -> pd.DataFrame:
    force_n, activity = (numbers_of(table, name) for name in ("force_n", "activity_v"))
    if not (force_n.size and np.isfinite(force_n).all() and np.isfinite(activity).all() and (force_n > 0).all()):
        found, do = "others" if force_n.size else "no row", "Leave such rows out."
        raise DataError("DataFrame", wanted="finite samples with a force above 0 N", found=found, do=do)
    refuse_missing_labels(table, "DataFrame")
    told = pd.DataFrame({name: column(table, name).to_numpy() for name in LABELS if name in table.columns})
    told = told if "repetition" in told else told.assign(repetition=np.ones(len(table), np.int64))
    press = told.groupby(list(told.columns), sort=False, observed=True).ngroup().to_numpy()
    order = np.argsort(press, kind="stable")
    counts = np.bincount(press)
    force_n, activity = force_n[order], activity[order]
    presses = told.drop_duplicates(ignore_index=True)
    offsets = np.concatenate([[0], np.cumsum(counts)])
    edges = fit_edges(*settings.window.force_n, settings.fit.bin_n)
    fitted = fit_presses(force_n, activity, offsets, edges, settings.fit).reported
    frame = presses.assign(
        **{
            "a_v": fitted.a, "b_v": fitted.b, "a_se_v": fitted.a_se, "b_se_v": fitted.b_se,
            "b_lo_v": fitted.b_lo, "b_hi_v": fitted.b_hi, "n_points": fitted.n, "adj_r2": fitted.adj_r2,
        }
    )  # fmt: skip
    frame.attrs = {"points": settings.fit.points, "confidence": settings.fit.confidence, "emg2vsa": __version__}
    return frame


def trials_frame(found: Trials) -> pd.DataFrame:
    """`Trials` as `trials` gives them."""
    names = ("repetition", "start_s", "stop_s", "duration_s", "peak_force_n", "falling_share", "snr_db", "verdict")
    frame = pd.DataFrame({name: getattr(found, name) for name in names} | {"reason": list(found.reasons)})
    frame.insert(0, "participant", found.participant)
    frame.insert(1, "specimen", found.specimen)
    frame.attrs = {"notes": [*found.notes], "remarks": [*found.remarks], "emg2vsa": __version__}
    return frame


def samples_frame(found: Trials) -> pd.DataFrame:
    """`Trials` as `samples` gives them; samples that are left out, for the electrode moved, have no row."""
    counts = np.diff(found.offsets)
    unit = "_v" if found.activity_unit == "V" else ""
    columns: dict[str, Any] = {
        "participant": found.participant,
        "specimen": found.specimen,
        "repetition": np.repeat(found.repetition, counts),
        "force_n": found.force_n,
        f"activity{unit}": found.activity,
    }
    columns |= {f"{name}_v": found.envelopes_v[i] for i, name in enumerate(found.muscles)}
    frame = pd.DataFrame(columns)[np.isfinite(found.activity)].reset_index(drop=True)
    frame.attrs = {"fs_hz": found.fs_hz, "activity_unit": found.activity_unit, "emg2vsa": __version__}
    return frame


def fits_frame(found: Fits) -> pd.DataFrame:
    """`Fits`, one row a press; bins are left out."""
    frame = _frame_of(found, found.repetition.size)
    frame.attrs = {
        "points": found.points, "weights": found.weights, "confidence": found.confidence,
        "activity_unit": found.activity_unit, "emg2vsa": __version__,
    }  # fmt: skip
    return frame


def _frame_of(product: Any, rows: int) -> pd.DataFrame:
    """The fields of a dataclass that hold ``rows`` values each, (rows,), as columns of their names."""
    columns = {}
    for field in dataclasses.fields(product):
        value = getattr(product, field.name)
        if isinstance(value, np.ndarray) and value.shape == (rows,):
            columns[field.name] = value
        elif isinstance(value, tuple) and len(value) == rows and all(isinstance(one, str) for one in value):
            columns[field.name] = np.array(value, dtype=object)
    return pd.DataFrame(columns)
