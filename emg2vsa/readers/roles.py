"""The channels of a study by their role: every muscle's EMG in volts, the pressing force in newtons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers.ati_gauges import force_of_gauges
from emg2vsa.readers.front_door import load_named, open_recording
from emg2vsa.readers.opened import OpenRecording, StoredChannel, scaled, unit_step
from emg2vsa.readers.trigger import clock_offset_s
from emg2vsa.readers.units import si_factor
from emg2vsa.recordings import Channel
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings, ReadingSettings

SLOWEST_EMG_HZ, SLOWEST_FORCE_HZ, _FASTEST_HZ = 10.0, 2.0, 200e3
"""Rates beyond which a column of time is misread: 1000 Hz in milliseconds that are labelled seconds reads as 1 Hz."""
_FEWEST_SAMPLES = 6


@dataclass(frozen=True)
class RoleChannels:
    """One recording as the analysis wants it.

    emg : muscle role to channel in V, gain divided out. force : channel in N, sign applied, not tared.
    format : of the file, or "EMG format + force format". notes : conversions aside, what the files made worth saying.
    began : what the EMG's file states of when it began, "" where it states nothing.
    """

    emg: dict[str, Channel]
    force: Channel
    format: str
    notes: tuple[str, ...]
    began: str = ""


def read_roles(
    emg_file: Path,
    force_file: Path | None,
    channels: ChannelSettings,
    reading: ReadingSettings | None = None,
    cal_file: Path | None = None,
) -> RoleChannels:
    """Read a recording; ``force_file`` None means that force and EMG are in one file.

    reading : limits of the decoders of binary files. cal_file : of the transducer whose gauges hold the force.

    Two files must share a clock: time 0 of both is taken as the same moment, and their time ranges must overlap.

    Raises RecordingError: unusable file, unknown or unusable channel, a unit that is no voltage (EMG) or force
    and that the study does not replace, or no overlap in time.
    """
    reading = reading or ReadingSettings()
    emg_format, emg_open = open_recording(emg_file, reading)
    emg_names = [settings.name for settings in channels.emg.values()]
    emg_hz = [settings.fs_hz for settings in channels.emg.values()]
    force_names = list(channels.force.gauges or (channels.force.name,))
    force_hz = [channels.force.fs_hz] * len(force_names)
    if force_file is None or Path(force_file) == Path(emg_file):
        stored = load_named(emg_open, [*emg_names, *force_names], [*emg_hz, *force_hz])
        emg_stored, force_stored = stored[: len(emg_names)], stored[len(emg_names) :]
        force_open, name = emg_open, emg_format
    else:
        force_format, force_open = open_recording(force_file, reading)
        emg_stored = load_named(emg_open, emg_names, emg_hz)
        force_stored = load_named(force_open, force_names, force_hz)
        name = emg_format if emg_format == force_format else f"{emg_format} + {force_format}"
    for path, channel, slowest in [
        *((emg_open.path, channel, SLOWEST_EMG_HZ) for channel in emg_stored),
        *((force_open.path, channel, SLOWEST_FORCE_HZ) for channel in force_stored),
    ]:
        refuse_short(path, channel)
        refuse_rate(path, channel, slowest)
    emg = {
        role: emg_in_v(emg_open.path, stored, settings)
        for (role, settings), stored in zip(channels.emg.items(), emg_stored, strict=True)
    }
    said: tuple[str, ...] = ()
    if channels.force.gauges is None:
        force = force_in_n(force_open.path, force_stored[0], channels.force)
    else:
        force, said = force_of_gauges(force_open.path, force_stored, channels.force, cal_file)
    force, aligned = _on_emg_clock(emg_open, force_open, force, channels.force)
    _refuse_disjoint(emg_open.path, emg, force_open.path, force)
    notes = _notes(emg_open, force_open, [*emg_stored, *force_stored])
    return RoleChannels(emg, force, name, (*notes, *said, *aligned), emg_open.contents.started)


def refuse_short(path: Path, stored: StoredChannel) -> None:
    """RecordingError where a channel has fewer samples than any filter needs."""
    if stored.samples.size < _FEWEST_SAMPLES:
        raise RecordingError(
            f"{path}, channel {stored.name!r}", wanted=f"a recording of {_FEWEST_SAMPLES} samples or more",
            found=str(stored.samples.size), do="Export the recording whole, or choose another file.",
        )  # fmt: skip


def refuse_rate(path: Path, stored: StoredChannel, slowest_hz: float) -> None:
    """RecordingError for a rate, Hz, at which nobody records: a time in another unit than its header says, or no time
    at all."""
    if slowest_hz < stored.fs_hz < _FASTEST_HZ:
        return
    right = "milliseconds or a count of samples" if stored.fs_hz <= slowest_hz else "seconds"
    raise RecordingError(
        f"{path}, channel {stored.name!r}",
        wanted=f"more than {slowest_hz:g} and less than {_FASTEST_HZ:g} samples a second",
        found=f"{stored.fs_hz:.6g}, as the time goes up by {1 / stored.fs_hz:.6g} s from row to row",
        do=f"Is the time in {right}? Correct the unit in its header, like \"time (ms)\"; for a count, remove the "
        "column and state fs_hz under the channel of the study (--fs for a single file).",
    )  # fmt: skip


def read_emg(emg_file: Path, channels: ChannelSettings, reading: ReadingSettings | None = None) -> dict[str, Channel]:
    """The EMG of a recording without force, such as of maximum contractions: muscle role to channel in V.

    Raises RecordingError as ``read_roles``.
    """
    _, opened = open_recording(emg_file, reading or ReadingSettings())
    wanted = channels.emg.values()
    stored = load_named(opened, [one.name for one in wanted], [one.fs_hz for one in wanted])
    for channel in stored:
        refuse_short(opened.path, channel)
    return {
        role: emg_in_v(opened.path, one, settings)
        for (role, settings), one in zip(channels.emg.items(), stored, strict=True)
    }


def _on_emg_clock(
    emg: OpenRecording, force_file: OpenRecording, force: Channel, settings: ForceChannelSettings
) -> tuple[Channel, tuple[str, ...]]:
    """The force on the clock of the EMG's file, and what is to be said of it."""
    if settings.trigger is None:
        return force, ()
    if emg is force_file:
        raise RecordingError(
            f"{emg.path}, trigger", wanted="a force file of its own", found="EMG and force in one file, on one clock",
            do="Remove trigger from [channels.force].",
        )  # fmt: skip
    (emg_trigger,), (force_trigger,) = (
        load_named(opened, [name]) for opened, name in zip((emg, force_file), settings.trigger, strict=True)
    )
    offset_s, said = clock_offset_s(emg.path, emg_trigger, force_file.path, force_trigger)
    return replace(force, start_s=force.start_s + offset_s), (said,)


def emg_in_v(path: Path, stored: StoredChannel, settings: EmgChannelSettings) -> Channel:
    """A stored EMG in V, gain divided out; its samples are changed in place. RecordingError: its unit is no voltage."""
    known = si_factor(settings.unit or stored.unit)
    if known is None or known[0] != "V":
        raise RecordingError(
            f"{path}, channel {stored.name!r}", wanted="an EMG in V, mV or uV", found=_stated(stored),
            do='State it: unit = "mV" (or "V", "uV") under the channel of the study, --emg-unit for a single file.',
        )  # fmt: skip
    steps = [_unit_said(settings.unit, stored), unit_step(str(settings.unit or stored.unit), known[1], "V")]
    if settings.gain != 1.0:
        steps.append(f"/ gain {settings.gain:.10g}")
    return scaled(stored, known[1] / settings.gain, "V", _joined(steps))


def force_in_n(path: Path, stored: StoredChannel, settings: ForceChannelSettings) -> Channel:
    """A stored force in N, sign applied; its samples are changed in place.

    RecordingError: its unit is no force and ``newtons_per_unit`` is not given, or both are.
    """
    unit = settings.unit or stored.unit
    known = si_factor(unit)
    where = f"{path}, channel {stored.name!r}"
    if settings.newtons_per_unit is not None:
        if known is not None and known[0] == "N":
            raise RecordingError(
                where, wanted="either a force unit or newtons_per_unit", do="Remove one of the two.",
                found=f"unit {unit} and newtons_per_unit = {settings.newtons_per_unit:.10g}",
            )  # fmt: skip
        factor = settings.newtons_per_unit
        step = f"{unit or 'stored unit'} x {factor:.10g} N per unit = N"
    elif known is not None and known[0] == "N":
        factor, step = known[1], unit_step(str(unit), known[1], "N")
    else:
        raise RecordingError(
            where, wanted="a force (N, mN, kN, lbf, kgf, gf)", found=_stated(stored),
            do=_kilogram_force(unit)
            + 'State unit = "N" (or another force unit) or newtons_per_unit under the force channel of the study, '
            "--force-unit or --newtons-per-unit for a single file.",
        )  # fmt: skip
    steps = [_unit_said(settings.unit, stored), step, "sign reversed" if settings.sign < 0 else ""]
    return scaled(stored, factor * settings.sign, "N", _joined(steps))


def _kilogram_force(unit: str | None) -> str:
    """Which force is meant by a unit of mass, as balances write it."""
    meant = {"kg": "kgf", "g": "gf", "lb": "lbf", "lbs": "lbf"}.get(unit or "")
    return f'{unit} is a mass; if its weight is meant, state unit = "{meant}". ' if meant else ""


def _stated(stored: StoredChannel) -> str:
    found = f"unit {stored.unit!r}" if stored.unit else "no unit"
    return "; ".join([found, *stored.notes])


def _unit_said(override: str | None, stored: StoredChannel) -> str:
    if override is None or override == stored.unit:
        return ""
    return f"unit {override} by the study (the file states {stored.unit or 'none'})"


def _joined(steps: Sequence[str]) -> str:
    return "; ".join(step for step in steps if step)


def _refuse_disjoint(emg_path: Path, emg: dict[str, Channel], force_path: Path, force: Channel) -> None:
    for role, channel in emg.items():
        start = max(channel.start_s, force.start_s)
        stop = min(channel.start_s + channel.duration_s, force.start_s + force.duration_s)
        if start >= stop:
            raise RecordingError(
                f"{emg_path}, channel {channel.name!r} ({role})",
                wanted=f"time in common with the force ({_range(force)} in {force_path.name})", found=_range(channel),
                do="Give the two files of one recording, exported with the same time zero.",
            )  # fmt: skip


def _range(channel: Channel) -> str:
    return f"{channel.start_s:.6g} to {channel.start_s + channel.duration_s:.6g} s"


def _notes(emg: OpenRecording, force: OpenRecording, stored: Sequence[StoredChannel]) -> tuple[str, ...]:
    notes = [*emg.contents.notes, *(force.contents.notes if force is not emg else ())]
    notes += [note for channel in stored for note in channel.notes]
    begun = (emg.contents.started, force.contents.started)
    if all(begun) and begun[0] != begun[1]:
        notes.append(
            f"The EMG file states that it began at {begun[0]}, the force file at {begun[1]}; "
            "time 0 of both was taken as the same moment."
        )
    return tuple(dict.fromkeys(notes))
