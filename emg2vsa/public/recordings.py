"""One recording: from a file or a table to its presses, their samples and their fits v = a + b ln F."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from emg2vsa import __version__
from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.curves.press_fits import fit_presses
from emg2vsa.errors import DataError, SettingError, StudyError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, fit_trials
from emg2vsa.public.frames import frame_of
from emg2vsa.readers.front_door import inspect
from emg2vsa.readers.roles import RoleChannels, read_roles
from emg2vsa.recordings import Channel
from emg2vsa.settings import ChannelSettings, StageSettings
from emg2vsa.study_file.problems import checked, nearest

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
    name, found = inspect(Path(file))
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
    source : a file, or a DataFrame with a column for each channel, evenly sampled at ``fs_hz``.
    emg : names of the EMG channels, or muscle to name. force : name of the force channel.
    force_file : second file that holds the force, on the same clock.
    fs_hz : sampling rate, where the file does not state it; of a DataFrame it is needed unless it has ``time_s``.
    emg_unit, force_unit, newtons_per_unit, gain : where the file does not say; a DataFrame is in V and N without them.
    sign : -1 where the sensor reports a press as a negative force. tare : take the force at rest off.
    settings : its table ``reading`` limits decoders.

    Raises
    ------
    RecordingError : the file, or a channel, cannot be used. StudyError : an option that cannot be.
    """
    named = [emg] if isinstance(emg, str) else emg
    muscles = dict(named) if isinstance(named, Mapping) else {name: name for name in named}
    table = isinstance(source, pd.DataFrame)
    units = ("V", "N") if table else (None, None)
    asked = {
        "emg": {
            role: {"name": name, "unit": emg_unit or units[0], "gain": gain, "fs_hz": fs_hz}
            for role, name in muscles.items()
        },
        "force": {
            "name": force, "unit": force_unit or units[1], "newtons_per_unit": newtons_per_unit, "sign": sign,
            "tare": "rest" if tare else "none", "fs_hz": fs_hz,
        },
    }  # fmt: skip
    made, problems = checked(ChannelSettings, asked, ("channels",))
    if problems:
        raise StudyError(tuple(f"read: {problem}" for problem in problems))
    if isinstance(source, pd.DataFrame):
        return _of_table(source, made, fs_hz)
    second = None if force_file is None else Path(force_file)
    reading = settings.reading if settings else None
    return Recording(Path(source).stem, read_roles(Path(source), second, made, reading), made)


_PER_V = {"V": 1.0, "mV": 1e-3, "uV": 1e-6}


def _of_table(table: pd.DataFrame, asked: ChannelSettings, fs_hz: float | None) -> Recording:
    """A recording from columns of samples in volts (or mV, uV) and newtons."""
    start_s = 0.0
    if "time_s" in table.columns:
        time_s = table["time_s"].to_numpy(np.float64)
        steps = np.diff(time_s)
        if time_s.size < 2 or not np.all(steps > 0) or np.ptp(steps) > 0.01 * np.median(steps):
            raise DataError(
                "DataFrame, time_s", wanted="times that rise by one step", found="other steps",
                do="Resample the table, or give fs_hz and drop the column.",
            )  # fmt: skip
        fs_hz, start_s = fs_hz or float((time_s.size - 1) / (time_s[-1] - time_s[0])), float(time_s[0])
    if fs_hz is None:
        do = "Give the sampling rate: fs_hz=1000."
        raise SettingError("read, fs_hz", wanted="a rate in Hz for a DataFrame without time_s", found="none", do=do)
    scale = asked.force.newtons_per_unit or 1.0
    emg = {
        role: _column(table, one.name, _PER_V.get(str(one.unit), 1.0) / one.gain, "V", fs_hz, start_s)
        for role, one in asked.emg.items()
    }
    force = _column(table, asked.force.name, asked.force.sign * scale, "N", fs_hz, start_s)
    return Recording("DataFrame", RoleChannels(emg, force, "DataFrame", ()), asked)


def _column(table: pd.DataFrame, name: str, factor: float, unit: str, fs_hz: float, start_s: float) -> Channel:
    if name not in table.columns:
        known = [str(column) for column in table.columns]
        do = nearest(name, known, "Choose one of them.")
        raise DataError("DataFrame", wanted=f"a column {name!r}", found=f"columns {', '.join(known)}", do=do)
    samples = pd.to_numeric(table[name], errors="coerce").to_numpy(np.float64) * factor
    return Channel(name, samples, unit, float(fs_hz), start_s, f"{unit} of a DataFrame")


def _extracted(recording: Recording, settings: StageSettings | None, participant: str, specimen: str) -> Trials:
    settings = settings or StageSettings()
    if not isinstance(recording, Recording):
        do = "Read the file first: emg2vsa.read(file, emg=[...], force=...)."
        raise SettingError("recording", wanted="a Recording", found=type(recording).__name__, do=do)
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
    verdict (ok, warned, rejected), reason. SignalError : the recording cannot be conditioned.
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

    source : a `Recording`, or a DataFrame with ``force_n`` and ``activity_v`` and, for several presses, ``repetition``:
    samples that are conditioned already, as `samples` gives them.

    Columns of a recording: those of `trials` that tell the press, and ``a_v``, ``b_v`` with standard errors, the
    interval ``b_lo_v`` to ``b_hi_v``, ``n_points``, ``adj_r2`` and more.
    SignalError, DataError : what cannot be fitted.
    """
    settings = settings or StageSettings()
    if isinstance(source, pd.DataFrame):
        return _fit_table(source, settings)
    return fits_frame(fit_trials(_extracted(source, settings, participant, specimen), settings.fit, settings.window))


def _fit_table(table: pd.DataFrame, settings: StageSettings) -> pd.DataFrame:
    for name in ("force_n", "activity_v"):
        if name not in table.columns:
            found = f"columns {', '.join(map(str, table.columns))}"
            raise DataError("DataFrame", wanted=f"a column {name!r}", found=found, do="Rename the column.")
    press = table["repetition"] if "repetition" in table.columns else pd.Series(1, index=table.index)
    order = np.argsort(press.to_numpy(), kind="stable")
    numbers, counts = np.unique(press.to_numpy(), return_counts=True)
    force_n, activity = (table[name].to_numpy(np.float64)[order] for name in ("force_n", "activity_v"))
    if not (np.isfinite(force_n).all() and np.isfinite(activity).all() and (force_n > 0).all()):
        do = "Leave such rows out."
        raise DataError("DataFrame", wanted="finite samples with a force above 0 N", found="others", do=do)
    offsets = np.concatenate([[0], np.cumsum(counts)])
    edges = bin_edges(*settings.window.force_n, settings.fit.bin_n)
    found = fit_presses(force_n, activity, offsets, edges, settings.fit).reported
    frame = pd.DataFrame(
        {
            "repetition": numbers, "a_v": found.a, "b_v": found.b, "a_se_v": found.a_se, "b_se_v": found.b_se,
            "b_lo_v": found.b_lo, "b_hi_v": found.b_hi, "n_points": found.n, "adj_r2": found.adj_r2,
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
    """`Trials` as `samples` gives them."""
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
    frame = pd.DataFrame(columns)
    frame.attrs = {"fs_hz": found.fs_hz, "activity_unit": found.activity_unit, "emg2vsa": __version__}
    return frame


def fits_frame(found: Fits) -> pd.DataFrame:
    """`Fits`, one row a press; bins are left out."""
    frame = frame_of(found, found.repetition.size)
    frame.attrs = {
        "points": found.points, "weights": found.weights, "confidence": found.confidence,
        "activity_unit": found.activity_unit, "emg2vsa": __version__,
    }  # fmt: skip
    return frame
