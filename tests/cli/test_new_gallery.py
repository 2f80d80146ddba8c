"""Folders as twelve laboratories keep them, made by code: ``emg2vsa new`` drafts a study whose every press is found."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import ezc3d
import numpy as np
import pandas as pd
import pytest
import scipy.io

from benchmarks import made_neurophysiology
from emg2vsa.cli import main
from emg2vsa.settings import SimulationSettings
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.recording import RecordingStream

PEOPLE, SPECIMENS = ("ama", "bob"), {"hard": 40e-6, "soft": 20e-6}
FS_HZ = 1000
Table = np.ndarray
"""(n, 4): time in s, extensor and flexor in mV, pressing force in N."""


@pytest.fixture(scope="module")
def presses() -> dict[tuple[str, str], Table]:
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
    pytest.importorskip("neo", reason="the extra formats is not installed")
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


LABORATORIES: dict[str, Callable[[Path, str, str, Table], None]] = {
    each.__name__: each
    for each in (
        pairs_of_one_name, folders_of_kinds, material_tester, decimal_commas, clock_stamps, rates_above, matlab,
        motion_capture, headerless, repetitions, spike2, weight_and_dates,
    )
}  # fmt: skip
EDITS = {"matlab": 3, "headerless": 3, "weight_and_dates": 1}
"""Lines beyond stiffness and number of presses that the draft marks for a person: units that no file states."""


QUICK = ("clock_stamps", "headerless")
SLOW_TOO = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in LABORATORIES]


@pytest.mark.parametrize("name", SLOW_TOO)
def test_every_press_of_a_laboratory_is_found(
    name: str, presses: dict[tuple[str, str], Table], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for (person, specimen), table in presses.items():
        LABORATORIES[name](tmp_path, person, specimen, table)
    assert main(["new", str(tmp_path), "--stiffness", "hard=6", "--stiffness", "soft=1.5", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    study = load_study(tmp_path / "study.toml")
    assert {person.removeprefix("sub-") for person in study.participants} == set(PEOPLE)
    assert set(study.stiffness_n_per_mm) == set(SPECIMENS)
    assert len(told["fill_in_lines"]) == 1 + EDITS.get(name, 0)
    main(["check", str(tmp_path / "study.toml"), "--json"])
    judged = json.loads(capsys.readouterr().out)
    found = {p: [each["found"] for each in judged[p]["specimens"]] for p in study.participants}
    assert found == {p: [3, 3] for p in study.participants}
