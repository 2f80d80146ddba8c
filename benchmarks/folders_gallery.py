"""Folders of palpation as twelve laboratories keep them, made by code, of which `emg2vsa new` drafts studies."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import ezc3d
import numpy as np
import pandas as pd
import scipy.io

from benchmarks import made_neurophysiology
from benchmarks.folder_laboratory import Known, Laboratory
from emg2vsa.settings import SimulationSettings
from emg2vsa.worlds.people.recording import RecordingStream

PEOPLE, SPECIMENS = ("ama", "bob"), {"hard": 40e-6, "soft": 20e-6}
FS_HZ = 1000
Table = np.ndarray
"""(n, 4): time in s, extensor and flexor in mV, pressing force in N."""


@cache
def press_tables() -> dict[tuple[str, str], Table]:
    """Three presses of each person on each specimen."""
    made = {}
    for i, person in enumerate(PEOPLE):
        for j, (specimen, b_v) in enumerate(SPECIMENS.items()):
            settings = SimulationSettings(repetitions=3, fs_hz=FS_HZ)
            stream = RecordingStream(np.random.SeedSequence([i, j]), settings, a_v=2 * b_v, b_v=b_v, window_n=(0.5, 7))
            one = stream.whole()
            time = np.arange(one.force_n.size) / FS_HZ
            made[person, specimen] = np.column_stack(
                [time, 1e3 * one.emg_v["EDC"], 1e3 * one.emg_v["FDS"], one.force_n]
            )
    return made


def text(path: Path, header: str, table: Table, sep: str = ",", comma: bool = False) -> None:
    rows = pd.DataFrame(table).to_csv(
        header=False, index=False, sep=sep, decimal="," if comma else ".", float_format="%.7g"
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(header + "\n" + rows, encoding="utf-8")


def pairs_of_one_name(folder: Path, person: str, specimen: str, table: Table) -> None:
    text(folder / f"{person}_{specimen}_emg.csv", "time (s),Channel 1 (mV),Channel 2 (mV)", table[:, :3])
    text(folder / f"{person}_{specimen}_force.csv", "time (s),Channel 1 (N)", table[:, [0, 3]])


def folders_of_kinds(folder: Path, person: str, specimen: str, table: Table) -> None:
    text(folder / "EMG" / f"{person}_{specimen}.txt", "Time[s];EDC[mV];FDS[mV]", table[:, :3], ";", comma=True)
    text(folder / "Force" / f"{person}_{specimen}.txt", "Time[s];Fz[N]", table[:, [0, 3]], ";", comma=True)


def material_tester(folder: Path, person: str, specimen: str, table: Table) -> None:
    """An EMG export, and the log of a testing machine with a preamble, a row of units and pushing negative."""
    text(folder / f"{person}_{specimen}_delsys.csv", "X[s],EXT DIG (mV),FLEX DIG (mV)", table[:, :3])
    above = f'Bluehill\nSpecimen label,"{specimen}"\nRate,10,mm/s\n\nTime,Load\n(s),(N)'
    text(folder / f"{person}_{specimen}_load.csv", above, np.column_stack([table[:, 0], -table[:, 3]]))


def decimal_commas(folder: Path, person: str, specimen: str, table: Table) -> None:
    """As Noraxon exports: a preamble, semicolons and decimal commas."""
    above = f'type;begin_time;frequency;count\n"{person}";"0,00000";{FS_HZ}.0;{len(table)}\n'
    text(folder / person / f"{specimen}.csv", f"{above}\ntime;EDC (mV);FDS (mV);Force (N)", table, ";", comma=True)


def clock_stamps(folder: Path, person: str, specimen: str, table: Table) -> None:
    moments = pd.Timestamp("2026-05-02 23:59:58") + pd.to_timedelta(table[:, 0], unit="s")
    cells = pd.DataFrame(table[:, 1:]).assign(at=moments.strftime("%Y-%m-%dT%H:%M:%S.%f"))[["at", 0, 1, 2]]
    rows = cells.to_csv(header=False, index=False, sep="\t", float_format="%.7g")
    (folder / f"{specimen}_{person}.txt").write_text("Timestamp\tEDC_mV\tFDS_mV\tGrip_N\n" + rows)


def rates_above(folder: Path, person: str, specimen: str, table: Table) -> None:
    text(folder / f"sub-{person}_{specimen}.txt", f"Sampling rate: {FS_HZ} Hz\nEDC,FDS,Fz\nmV,mV,N", table[:, 1:])


def matlab(folder: Path, person: str, specimen: str, table: Table) -> None:
    content = {"fs": float(FS_HZ), "EDC": table[:, 1], "FDS": table[:, 2], "Fz": table[:, 3]}
    scipy.io.savemat(folder / f"{person}_{specimen}.mat", content)


def motion_capture(folder: Path, person: str, specimen: str, table: Table) -> None:
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["ANALOG"]["RATE"]["value"] = [float(FS_HZ)]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = ["EDC", "FDS", "Fz"]
    file["parameters"]["ANALOG"]["UNITS"]["value"] = ["mV", "mV", "N"]
    n = len(table) // 10 * 10
    file["data"]["points"] = np.zeros((4, 0, n // 10))
    file["data"]["analogs"] = table[:n, 1:].T[None]
    file.write(str(folder / f"{person}_{specimen}.c3d"))


def headerless(folder: Path, person: str, specimen: str, table: Table) -> None:
    for kind, columns in (("emg", [0, 1, 2]), ("force", [0, 3])):
        np.savetxt(folder / f"{person}_{specimen}_{kind}.txt", table[:, columns], "%.6f")


def repetitions(folder: Path, person: str, specimen: str, table: Table) -> None:
    """A file for each press, cut in the rests between them."""
    force = table[:, 3]
    rest = np.flatnonzero(force < 0.25)
    gaps = np.array_split(np.arange(len(table)), 3)
    cuts = [0, *(int(rest[np.argmin(np.abs(rest - part[-1]))]) for part in gaps[:2]), len(table)]
    for k in range(3):
        part = table[cuts[k] : cuts[k + 1]].copy()
        part[:, 0] -= part[0, 0]
        text(folder / f"{person}_{specimen}_{k + 1}.csv", "time (s),EDC (mV),FDS (mV),Fz (N)", part)


def spike2(folder: Path, person: str, specimen: str, table: Table) -> None:
    step = {"EDC": (0.05, "mV"), "FDS": (0.05, "mV"), "Fz": (5.0, "N")}
    channels = {
        name: (np.round(table[:, i] * 6553.6 / scale).astype(np.int16), 100, scale, unit)
        for i, (name, (scale, unit)) in enumerate(step.items(), start=1)
    }
    (folder / f"{person}_{specimen}.smr").write_bytes(made_neurophysiology.spike2(channels))


def weight_and_dates(folder: Path, person: str, specimen: str, table: Table) -> None:
    """A date first, a balance that gives kilograms, and a folder for each person."""
    kilograms = np.column_stack([1e3 * table[:, 0], table[:, 1:3], table[:, 3] / 9.80665])
    name = f"2026-05-{10 + 3 * PEOPLE.index(person) + len(specimen)}_{specimen}.csv"
    text(folder / person / name, "time_ms,Ch1 ExtDig (mV),Ch2 FlexDig (mV),Load (kg)", kilograms)


def _laboratory(
    keep: Callable[[Path, str, str, Table], None], what: str, emg: str = "EDC FDS", force: str = "Fz", **more: Any
) -> Laboratory:
    """keep : writes the recordings of a person on a specimen. emg : channels of EDC and FDS, ``|`` between names."""

    def make(folder: Path) -> None:
        for (person, specimen), table in press_tables().items():
            keep(folder, person, specimen, table)

    channels = emg.split("|") if "|" in emg else emg.split()
    known = Known({"hard": 6.0, "soft": 1.5}, dict(zip(channels, ("EDC", "FDS"), strict=True)), force, "mV", **more)
    return Laboratory(keep.__name__, what, make, known, len(PEOPLE), 3, SPECIMENS)


LABORATORIES = {
    each.name: each
    for each in (
        _laboratory(pairs_of_one_name, "EMG and force files with one channel name", "Channel 1|Channel 2", "Channel 1"),
        _laboratory(folders_of_kinds, "a folder for the EMG and one for the force, decimal commas"),
        _laboratory(material_tester, "EMG, and a testing machine's log", "EXT DIG|FLEX DIG", "Load", down=True),
        _laboratory(decimal_commas, "Noraxon's preamble, semicolons, decimal commas", force="Force"),
        _laboratory(clock_stamps, "ISO time stamps, units glued to names", force="Grip"),
        _laboratory(rates_above, "the rate in a line above, a row of units"),
        _laboratory(matlab, ".mat of a variable a channel"),
        _laboratory(motion_capture, "C3D"),
        _laboratory(headerless, "matrices without a header", "column 2|column 3", "column 2"),
        _laboratory(repetitions, "a file a press"),
        _laboratory(spike2, "Spike2"),
        _laboratory(
            weight_and_dates, "dates in names, kilograms", "Ch1 ExtDig|Ch2 FlexDig", "Load", force_unit="kgf"
        ),
    )
}  # fmt: skip
