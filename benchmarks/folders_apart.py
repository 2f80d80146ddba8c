"""Folders of palpation as ten laboratories would leave them, kept apart from the rules of `emg2vsa new`.

They were written from what laboratories publish and ask about, before anybody looked at what `new` can do, and `new` is
not tuned to them: `benchmarks.folders` counts how many reach a report. Each holds two or three people who press
objects of known stiffness several times; EMG follows a + b ln F. None is a real file.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import made_recordings
from benchmarks.folder_laboratory import Known, Laboratory

Floats = NDArray[np.float64]


STIFFNESS_N_PER_MM = (1.11, 3.35, 7.63)
"From soft to hard."
_A_V, _B_V = (16e-6, 28e-6, 42e-6), (7e-6, 13e-6, 20e-6)
"SD of the flexor's EMG is a + b ln F; the extensor has 0.7 of it."


_AROUND = (1.0, 0.7, 0.9, 0.6, 0.5, 0.4, 0.3, 0.2)
"Shares of the EMG around the forearm."


def press(
    person: int, hardness: int, fs_hz: float, presses: int = 4, emg_fs_hz: float | None = None,
    shares: Sequence[float] = (1.0, 0.7),
) -> tuple[Floats, Floats]:  # fmt: skip
    """EMG (channels, n) in volts and force (m,) in newtons of one record with so many presses at their own rates.

    shares : of the flexor's EMG that each channel has.
    """
    rng = np.random.default_rng([20261129, person, hardness, presses])
    knots_s, heights = [0.0, 2.5], [0.0, 0.0]
    for _ in range(presses):
        peak_n = rng.uniform(7.5, 8.4)
        for step_s, height_n in (
            (rng.uniform(1.8, 2.6), peak_n),
            (0.3, peak_n),
            (0.8, 0.0),
            (rng.uniform(2.2, 3.0), 0.0),
        ):
            knots_s.append(knots_s[-1] + step_s)
            heights.append(height_n)
    emg_fs_hz = emg_fs_hz or fs_hz
    force_n = np.interp(np.arange(int(knots_s[-1] * fs_hz)) / fs_hz, knots_s, heights)
    pressed_n = np.interp(np.arange(int(knots_s[-1] * emg_fs_hz)) / emg_fs_hz, knots_s, heights)
    level_v = np.maximum(_A_V[hardness] + _B_V[hardness] * np.log(np.maximum(pressed_n, 0.05)), 0) * rng.lognormal(
        0, 0.1
    )
    levels_v = np.hypot(np.outer(shares, level_v), 2e-6)
    emg = levels_v * _noise(rng, levels_v.shape, emg_fs_hz)
    return emg, force_n + 0.02 * rng.standard_normal(force_n.size)


def _noise(rng: np.random.Generator, shape: tuple[int, ...], fs_hz: float) -> Floats:
    """(channels, n) of unit variance, without what lies above 500 Hz, which no muscle gives."""
    spectrum = np.fft.rfft(rng.standard_normal(shape))
    spectrum[:, np.fft.rfftfreq(shape[1], 1 / fs_hz) > 500] = 0
    noise = np.fft.irfft(spectrum, shape[1])
    return np.asarray(noise / noise.std(axis=1, keepdims=True))


def _hpf_and_load_cell(folder: Path) -> None:
    """Delsys HPF beside the CSV of a load cell's own logger, which begins at the same trigger."""
    for person, who in enumerate(("Subj01", "Subj02", "Subj03")):
        for hardness, what in enumerate(("soft", "medium", "hard")):
            emg, force_n = press(person, hardness, 500.0, emg_fs_hz=2000.0)
            (folder / f"{who}_{what}.hpf").write_bytes(
                made_recordings.hpf({1: (2000.0, 2000.0, (emg[0], emg[1]))}, chunk_samples=400)
            )
            rows = "".join(f"{i / 500:.3f},{value:.4f}\n" for i, value in enumerate(force_n))
            (folder / f"{who}_{what}_loadcell.csv").write_text("Time (s),Load (N)\n" + rows)


def _lab_recorder(folder: Path) -> None:
    """LabRecorder's own tree of names, one stream with EMG and force."""
    for person, who in enumerate(("P001", "P002")):
        at = folder / f"sub-{who}" / "ses-S001" / "eeg"
        at.mkdir(parents=True)
        for hardness, what in enumerate(("gelA", "gelB", "gelC")):
            emg, force_n = press(person, hardness, 1000.0)
            samples = np.column_stack([emg.T * 1e6, force_n])
            stamps = 5321.4 + np.arange(len(samples)) / 1000
            units = {"FDS": "microvolts", "EDC": "microvolts", "Force": "N"}
            content = made_recordings.xdf_stream(stamps, samples, 1000, units)
            (at / f"sub-{who}_ses-S001_task-{what}_run-001_eeg.xdf").write_bytes(content)


def _labchart(folder: Path) -> None:
    """Texts of LabChart with decimal commas: six lines before the numbers, a folder for each person."""
    for person, who in enumerate(("Proband 1", "Proband 2", "Proband 3")):
        (folder / who).mkdir()
        for hardness, what in enumerate(("weich", "mittel", "fest")):
            emg, force_n = press(person, hardness, 1000.0)
            head = ["Interval=\t0,001 s", "ExcelDateTime=\t4,5E4\t12.03.2024 10:11:12,345", "TimeFormat=\tStartOfBlock"]
            head += ["DateFormat=\t", "ChannelTitle=\tFlexor\tExtensor\tKraft", "Range=\t2,000 mV\t2,000 mV\t50,00 N"]
            table = zip(np.arange(force_n.size) / 1000, emg[0] * 1e3, emg[1] * 1e3, force_n, strict=True)
            rows = ["\t".join(f"{value:.6g}" for value in row).replace(".", ",") for row in table]
            (folder / who / f"{what}.txt").write_text("\n".join([*head, *rows]) + "\n", encoding="latin-1")


def _labview(folder: Path) -> None:
    """LabVIEW's .lvm, dates and German participants in the names, a file for each press."""
    for person, who in enumerate(("VP02", "VP05", "VP07")):
        for hardness, what in enumerate(("Gel10", "Gel20", "Gel30")):
            for repetition in range(1, 5):
                emg, force_n = press(10 * person + repetition, hardness, 1000.0, presses=1)
                head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Separator\tTab", "Decimal_Separator\t."]
                head += ["Multi_Headings\tNo", "X_Columns\tOne", "***End_of_Header***\t", "\t", "Channels\t3"]
                n = force_n.size
                head += [f"Samples\t{n}\t{n}\t{n}", "Date" + "\t2024/02/19" * 3, "Time" + "\t09:51:10.0" * 3]
                head += ["Y_Unit_Label\tVolts\tVolts\tNewtons", "X0" + "\t0" * 3, "Delta_X" + "\t0.001" * 3]
                head += ["***End_of_Header***\t\t\t", "X_Value\tEMG_FDS\tEMG_EDC\tLoad\tComment"]
                table = zip(np.arange(n) / 1000, emg[0], emg[1], force_n, strict=True)
                rows = ["\t".join(f"{value:.7g}" for value in row) + "\t" for row in table]
                text = "\r\n".join([*head, *rows]) + "\r\n"
                (folder / f"20240219_{who}_{what}_{repetition}.lvm").write_text(text, newline="")


def _nexus(folder: Path) -> None:
    """Exports of Vicon Nexus: the plate's Fz is negative under a press, a folder for each person."""
    for person, who in enumerate(("S01", "S02", "S03")):
        (folder / who).mkdir()
        for hardness, what in enumerate(("foam", "rubber", "wood")):
            emg, force_n = press(person, hardness, 1000.0)
            text = ["Devices", "1000", ",,EMG box,,Plate,,", "Frame,Sub Frame,FDS,EDC,Fx,Fy,Fz", ",,V,V,N,N,N"]
            text += [
                f"{1 + i // 10},{i % 10},{emg[0, i]:.7g},{emg[1, i]:.7g},{0.03 * f:.5g},{-0.02 * f:.5g},{-f:.5g}"
                for i, f in enumerate(force_n.tolist())
            ]
            text += ["", "Trajectories", "100", ",,a", "Frame,Sub Frame,X", ",,mm", "1,0,3.5"]
            (folder / who / f"{who}_{what}_01.csv").write_text("\r\n".join(text) + "\r\n", newline="")


def _armband(folder: Path) -> None:
    """An armband's eight channels at 200 Hz and a six-axis sensor at 243 Hz, whose clocks begin together."""
    for person, who in enumerate(("anna", "ben", "carla")):
        for hardness, what in enumerate(("gelatin", "silicone", "pu")):
            emg, force_n = press(person, hardness, 243.0, emg_fs_hz=200.0, shares=_AROUND)
            armband = np.round(emg * 5e5).clip(-128, 127)
            rows = "".join(
                f"{1571305210 + i / 200:.3f}," + ",".join(f"{v:.0f}" for v in row) + "\n"
                for i, row in enumerate(armband.T)
            )
            head = "timestamp," + ",".join(f"emg{i}" for i in range(8)) + "\n"
            (folder / f"{who}_{what}_myo.csv").write_text(head + rows)
            rows = "".join(
                f"{1571305210 + i / 243:.4f},{0.02 * f:.4f},{0.01 * f:.4f},{-f:.4f},0,0,0\n"
                for i, f in enumerate(force_n.tolist())
            )
            (folder / f"{who}_{what}_mini45.csv").write_text("timestamp,Fx,Fy,Fz,Tx,Ty,Tz\n" + rows)


def _bitalino(folder: Path) -> None:
    """BITalino: EMG and a load cell as counts of ten bits, of which only the laboratory knows the newtons."""
    for person, who in enumerate(("s1", "s2")):
        for hardness, what in enumerate(("A", "B", "C")):
            emg, force_n = press(person, hardness, 1000.0)
            about = {
                "00:07:80:00:00:01": {
                    "sensor": ["EMG", "EMG", "RAW"], "column": ["nSeq", "I1", "I2", "O1", "O2", "A1", "A2", "A3"],
                    "label": ["A1", "A2", "A3"], "channels": [1, 2, 3], "sampling rate": 1000,
                    "resolution": [4, 1, 1, 1, 1, 10, 10, 10], "device": "bitalino",
                    "date": "2024-1-2", "time": "3:4:5.6",
                }
            }  # fmt: skip
            counts = np.round(emg * 1009 / 3.3 * 1024 + 512).clip(0, 1023)
            load = np.round(100 + 50 * force_n).clip(0, 1023)
            rows = [
                f"{i % 16}\t0\t0\t0\t0\t{a:.0f}\t{b:.0f}\t{c:.0f}\t"
                for i, (a, b, c) in enumerate(zip(*counts, load, strict=True))
            ]
            text = ["# OpenSignals Text File Format", "# " + json.dumps(about), "# EndOfHeader", *rows]
            (folder / f"opensignals_{who}_object{what}_2024-01-02.txt").write_text("\n".join(text) + "\n")


def _tidy(folder: Path) -> None:
    """One table of everything, as people who work in R keep it."""
    rows = ["subject,object,time_s,fds_mV,edc_mV,force_N"]
    for person, who in enumerate(("s01", "s02", "s03")):
        for hardness, what in enumerate(("soft", "mid", "hard")):
            emg, force_n = press(person, hardness, 1000.0, presses=3)
            rows += [
                f"{who},{what},{i / 1000:.3f},{a:.6g},{b:.6g},{f:.5g}"
                for i, (a, b, f) in enumerate(zip(*(emg * 1e3), force_n, strict=True))
            ]
    (folder / "all_trials.csv").write_text("\n".join(rows) + "\n")


def _matlab(folder: Path) -> None:
    """A .mat for each block: a matrix of EMG, a vector of force, the rate."""
    import scipy.io

    (folder / "data").mkdir()
    for person, who in enumerate(("P3", "P4", "P9")):
        for hardness, what in enumerate(("low", "mid", "high")):
            emg, force_n = press(person, hardness, 2000.0, presses=3)
            variables = {"emg": emg.T, "force": force_n[:, None], "fs": 2000.0, "labels": ["FDS", "EDC"]}
            scipy.io.savemat(folder / "data" / f"{who}_block{hardness + 1}_{what}.mat", variables)


def _tdms(folder: Path) -> None:
    """DAQmx logs: a group for each device, EMG at 2000 Hz, a force sensor at 1000 Hz."""
    import nptdms

    for person, who in enumerate(("AB", "CD", "EF")):
        (folder / who).mkdir()
        for hardness, what in enumerate(("E10", "E30", "E60")):
            emg, force_n = press(person, hardness, 1000.0, emg_fs_hz=2000.0)
            begun = np.datetime64("2024-05-02T10:00:00.000000")
            common = {"wf_start_offset": 0.0, "wf_start_time": begun}
            muscle = common | {"wf_increment": 1 / 2000, "unit_string": "V"}
            newtons = common | {"wf_increment": 1 / 1000, "unit_string": "N"}
            channels = [
                nptdms.ChannelObject("Amplifier", "flexor", emg[0], properties=muscle),
                nptdms.ChannelObject("Amplifier", "extensor", emg[1], properties=muscle),
                nptdms.ChannelObject("FT", "Fz", -force_n, properties=newtons),
            ]
            with nptdms.TdmsWriter(folder / who / f"{what}.tdms") as writer:
                writer.write_segment(channels)


def _percent(folder: Path) -> None:
    """Matrices of motor unit people: EMG in uV, force in percent of a maximum of 40 N."""
    for person, who in enumerate(("S1", "S2", "S3")):
        for hardness, what in enumerate(("soft", "medium", "stiff")):
            emg, force_n = press(person + 3, hardness, 1024.0)
            table = np.column_stack([np.arange(force_n.size) / 1024, *(1e6 * emg), force_n / 40 * 100])
            head = "Time (s),GL [uV],GM [uV],Force [%MVC]"
            np.savetxt(folder / f"{who}-{what}-ramp.csv", table, "%.6g", ",", header=head, comments="")


def _edf(folder: Path) -> None:
    """EDF files named as in BIDS, without its tables."""
    import edfio

    for person, who in enumerate(("01", "02")):
        place = folder / f"sub-{who}" / "emg"
        place.mkdir(parents=True)
        for hardness, what in enumerate(("foam", "gel", "rubber")):
            emg, force_n = press(person + 3, hardness, 1000.0)
            n = force_n.size // 1000 * 1000
            named = (("EMG FDS", 1e6 * emg[0], "uV"), ("EMG EDC", 1e6 * emg[1], "uV"), ("FORCE", force_n, "N"))
            signals = [edfio.EdfSignal(v[:n], 1000, label=label, physical_dimension=unit) for label, v, unit in named]
            edfio.Edf(signals).write(place / f"sub-{who}_task-press_acq-{what}_emg.edf")


def _robot(folder: Path) -> None:
    """A folder a person and a folder an object: EMG as CSV, and a robot's wrench log without a clock of its own."""
    for person, who in enumerate(("anna", "ben", "carla")):
        for hardness, what in enumerate(("ecoflex10", "ecoflex30", "dragonskin")):
            (place := folder / who / what).mkdir(parents=True)
            emg, force_n = press(person + 3, hardness, 500.0, emg_fs_hz=1000.0)
            table = np.column_stack([np.arange(emg.shape[1]) / 1000, *(1e3 * emg)])
            np.savetxt(place / "emg.csv", table, "%.6g", ",", header="t,ch0_mV,ch1_mV", comments="")
            wrench = np.column_stack([np.arange(force_n.size) / 500, 0.1 * force_n, 0 * force_n, -force_n])
            np.savetxt(place / "wrench.csv", wrench, "%.6g", ",", header="t,fx,fy,fz", comments="")


def _qualisys(folder: Path) -> None:
    """Analogue TSV of a motion capture system: lines of keys and values, then a line of names."""
    for person, who in enumerate(("P01", "P02", "P03")):
        for hardness, what in enumerate(("A", "B", "C")):
            emg, force_n = press(person + 3, hardness, 1000.0)
            head = [f"NO_OF_SAMPLES\t{force_n.size}", "TOT_NO_OF_CHAN\t3", "FREQUENCY\t1000", "TIME_STAMP\t2024-01-02"]
            head += ["FIRST_SAMPLE\t1", "CHANNEL_NAMES\tEMG_1\tEMG_2\tFP1_Fz", "CHANNEL_UNITS\tV\tV\tN"]
            rows = ["\t".join(f"{v:.7g}" for v in row) for row in zip(*emg, -force_n, strict=True)]
            (folder / f"{who}_spec{what}_a.tsv").write_text("\n".join([*head, *rows]) + "\n")


def _excel(folder: Path) -> None:
    """Saved by a German spreadsheet: a byte order mark, semicolons, decimal commas, blanks in names."""
    for person, who in enumerate(("Anna", "Bernd", "Carla")):
        for hardness, what in enumerate(("weich", "mittel", "fest")):
            emg, force_n = press(person + 3, hardness, 1000.0)
            table = zip(np.arange(force_n.size), *(1e6 * emg), force_n, strict=True)
            rows = [";".join(f"{v:.6g}" for v in row).replace(".", ",") for row in table]
            head = "Zeit [ms];EMG Beuger [µV];EMG Strecker [µV];Kraft [N]"
            text = "\r\n".join([head, *rows]) + "\r\n"
            (folder / f"Messung {person + 1} {who} {what}.csv").write_text(text, encoding="utf-8-sig", newline="")


def _arduino(folder: Path) -> None:
    """A microcontroller's log: counts of ten bits, a load cell in grams, milliseconds that jitter."""
    for person, who in enumerate(("s01", "s02", "s03")):
        for hardness, what in enumerate(("soft", "middle", "hard")):
            emg, force_n = press(person + 3, hardness, 500.0)
            jitter = np.random.default_rng(person).uniform(-0.3, 0.3, force_n.size)
            time_ms = 81234 + 2 * np.arange(force_n.size) + jitter
            counts = np.round(512 + emg * 2e6).clip(0, 1023)
            table = np.column_stack([time_ms, *counts, force_n / 9.80665e-3])
            head = "millis_ms,myoware1,myoware2,hx711 (g)"
            np.savetxt(
                folder / f"log_2024-05-0{person + 1}_{who}_{what}.csv", table, "%.3f", ",", header=head, comments=""
            )


def _copies(folder: Path) -> None:
    """A folder a person; a file system numbered the further presses on an object."""
    for person, who in enumerate(("Subject_07", "Subject_11", "Subject_12")):
        (folder / who).mkdir()
        for hardness, what in enumerate(("soft gel", "hard gel", "wood")):
            for number in range(4):
                emg, force_n = press(10 * person + number, hardness, 1000.0, presses=1)
                table = np.column_stack([np.arange(force_n.size) / 1000, *(1e3 * emg), force_n])
                name = f"{what}.csv" if number == 0 else f"{what} ({number}).csv"
                head = "Time (s),FDS (mV),EDC (mV),Force (N)"
                np.savetxt(folder / who / name, table, "%.6g", ",", header=head, comments="")


def _adapter(folder: Path) -> None:
    """Trigno Discover with a load cell on an analogue adapter, in volts, 5 N a volt, at a rate of its own."""
    for person, who in enumerate(("001", "002", "003")):
        for hardness, what in enumerate(("low", "mid", "high")):
            emg, force_n = press(person + 6, hardness, 500.0, emg_fs_hz=2000.0)
            head = ["Application:, Trigno Discover (1.5.0)", "Date/Time:, 4/12/2022 5:23:09 PM"]
            head += [f"Collection Length (seconds):, {emg.shape[1] / 2000:.3f}", "FDS (1), EDC (2), Adapter (3), "]
            head += ["sensor mode: 55, sensor mode: 55, sensor mode: 40, ", "EMG 1 (mV), EMG 1 (mV), ANALOG 3 (V)"]
            head += ["2000.0000 Hz, 2000.0000 Hz, 500.0000 Hz"]
            rows = [
                f"{a:.6g}, {b:.6g}, {force_n[i] / 5:.6g}" if i < force_n.size else f"{a:.6g}, {b:.6g}, "
                for i, (a, b) in enumerate((1e3 * emg).T.tolist())
            ]
            (folder / f"sub{who}_{what}.csv").write_text("\r\n".join([*head, *rows]) + "\r\n", newline="")


def _hdf5(folder: Path) -> None:
    """OpenSignals HDF5, a hub of three channels of counts, of which 100 are a newton."""
    import h5py

    for person, who in enumerate(("maria", "nils", "olga")):
        for hardness, what in enumerate(("sponge", "eraser", "cork")):
            emg, force_n = press(person + 6, hardness, 1000.0)
            counts = [*np.round(emg * 1000 / 3 * 65536 + 32768), np.round(2000 + 100 * force_n)]
            with h5py.File(folder / f"{who}_{what}.h5", "w") as file:
                device = file.create_group("00:07:80:3B:46:58")
                facts = {"sampling rate": 1000, "device": "biosignalsplux", "date": "2024-1-2", "time": "3:4:5.6"}
                device.attrs.update(facts)
                device["raw/nSeq"] = np.arange(force_n.size, dtype="u4")[:, None]
                for i, each in enumerate(counts, 1):
                    device[f"raw/channel_{i}"] = each.clip(0, 65535).astype("u2")[:, None]


def _glued(folder: Path) -> None:
    """C3D of a gait laboratory: initials with a date for folders, objects with a number glued to their name."""
    import ezc3d

    for person, who in enumerate(("2024-03-01_JD", "2024-03-04_KM", "2024-03-05_LW")):
        (folder / who).mkdir()
        for hardness, what in enumerate(("Foam01", "Gel01", "Rubber01")):
            emg, force_n = press(person + 6, hardness, 1000.0)
            n = force_n.size // 10 * 10
            file = ezc3d.c3d()
            file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
            file["parameters"]["ANALOG"]["RATE"]["value"] = [1000.0]
            file["parameters"]["ANALOG"]["LABELS"]["value"] = ["Force.Fx1", "Force.Fz1", "EMG.1", "EMG.2"]
            file["parameters"]["ANALOG"]["UNITS"]["value"] = ["N", "N", "V", "V"]
            file["data"]["points"] = np.zeros((4, 0, n // 10))
            file["data"]["analogs"] = np.stack([0.03 * force_n, -force_n, *emg])[None, :, :n]
            file.write(str(folder / who / f"{what}.c3d"))


def _numbers(folder: Path) -> None:
    """Names of numbers alone: participant, object, trial."""
    for person in range(1, 4):
        for hardness in range(3):
            for trial in range(1, 5):
                emg, force_n = press(10 * person + trial, hardness, 1000.0, presses=1)
                table = np.column_stack([1e3 * np.arange(force_n.size) / 1000, *(1e3 * emg), -force_n])
                head = "time_ms;FDS_mV;EDC_mV;Fz_N"
                name = f"{person:02d}_{hardness + 1}_{trial}.txt"
                np.savetxt(folder / name, table, "%.6g", ";", header=head, comments="")


def _with_mvc(folder: Path) -> None:
    """A maximum contraction and a rest of each person lie beside the presses."""
    for person, who in enumerate(("P1", "P2", "P3")):
        for hardness, what in enumerate(("soft", "medium", "stiff", "mvc", "rest")):
            emg, force_n = press(person + 6, min(hardness, 2), 1000.0)
            if what in ("mvc", "rest"):
                emg, force_n = emg[:, :3000] * (20 if what == "mvc" else 1), 0.01 * force_n[:3000]
            table = np.column_stack([np.arange(force_n.size) / 1000, *(1e3 * emg), force_n])
            head = "time (s),FDS (mV),EDC (mV),Fz (N)"
            np.savetxt(folder / f"{who}_{what}.csv", table, "%.6g", ",", header=head, comments="")


def _laboratory(
    make: Callable[[Path], None], what: str, objects: str, emg: Mapping[str, str], force: str, emg_unit: str = "V",
    force_unit: str = "N", **more: Any,
) -> Laboratory:  # fmt: skip
    """objects : from soft to hard. more : of Laboratory and Known; muscles : sum of the channels' shares of the EMG."""
    names, muscles = objects.split(), more.pop("muscles", 1.7)
    people, presses = more.pop("people", 3), more.pop("presses", 4)
    slopes = {name: b_v * (2 / np.pi) ** 0.5 * muscles for name, b_v in zip(names, _B_V, strict=True)}
    known = Known(dict(zip(names, STIFFNESS_N_PER_MM, strict=True)), emg, force, emg_unit, force_unit, **more)
    return Laboratory(make.__name__.strip("_"), what, make, known, people, presses, slopes)


_NAMED = {"FDS": "FDS", "EDC": "EDC"}
LABORATORIES = (
    _laboratory(
        _hpf_and_load_cell, "Delsys HPF; a load cell's logger beside it", "soft medium hard",
        {"EMG 1.1": "FDS", "EMG 1.2": "EDC"}, "Load",
    ),
    _laboratory(_lab_recorder, "XDF of LabRecorder in its own tree of names", "gelA gelB gelC", _NAMED, "Force", "uV",
                people=2),
    _laboratory(
        _labchart, "texts of LabChart with decimal commas, a folder a person", "weich mittel fest",
        {"Flexor": "FDS", "Extensor": "EDC"}, "Kraft", "mV", fs_hz=1000.0,
    ),
    _laboratory(
        _labview, "LabVIEW .lvm, a file a press, dates in names", "Gel10 Gel20 Gel30",
        {"EMG_FDS": "FDS", "EMG_EDC": "EDC"}, "Load",
    ),
    _laboratory(_nexus, "Vicon Nexus exports, the plate's Fz negative", "foam rubber wood", _NAMED, "Fz", down=True),
    _laboratory(
        _armband, "armband at 200 Hz, six-axis sensor at 243 Hz, a file each", "gelatin silicone pu",
        {f"emg{i}": f"M{i}" for i in range(8)}, "Fz", "uV", down=True,
        muscles=0.5 * sum(_AROUND),
    ),
    _laboratory(
        _bitalino, "OpenSignals texts of counts, load cell too", "A B C", {"A1": "FDS", "A2": "EDC"}, "A3", "uV",
        "0.02", people=2, muscles=1.7 * 1009 / 3.3 * 1024 * 1e-6,
    ),
    _laboratory(_tidy, "one table of all people and objects", "soft mid hard", {"fds_mV": "FDS", "edc_mV": "EDC"},
                "force_N", "mV", presses=3),
    _laboratory(_matlab, ".mat of a matrix, a vector and a rate", "low mid high", {"emg[1]": "FDS", "emg[2]": "EDC"},
                "force", fs_hz=2000.0, presses=3),
    _laboratory(_tdms, "DAQmx logs of two rates, a folder a person", "E10 E30 E60",
                {"flexor": "FDS", "extensor": "EDC"}, "Fz", down=True),
)  # fmt: skip
"""The ten, each with what its people know."""

LATER = (
    _laboratory(_percent, "CSV with the force in percent of a maximum", "soft medium stiff",
                {"GL": "FDS", "GM": "EDC"}, "Force", "uV", "0.4"),
    _laboratory(_edf, "EDF named as in BIDS, without its tables", "foam gel rubber",
                {"EMG FDS": "FDS", "EMG EDC": "EDC"}, "FORCE", "uV", people=2),
    _laboratory(_robot, "a folder an object: EMG, and a robot's wrench", "ecoflex10 ecoflex30 dragonskin",
                {"ch0": "FDS", "ch1": "EDC"}, "fz", "mV", down=True),
    _laboratory(_qualisys, "analogue TSV of a motion capture system", "A B C",
                {"EMG_1": "FDS", "EMG_2": "EDC"}, "FP1_Fz", down=True, fs_hz=1000.0),
    _laboratory(_excel, "a German spreadsheet's CSV", "weich mittel fest",
                {"EMG Beuger": "FDS", "EMG Strecker": "EDC"}, "Kraft", "uV"),
    _laboratory(_arduino, "a microcontroller's log", "soft middle hard",
                {"myoware1": "FDS", "myoware2": "EDC"}, "hx711", "uV", "gf", muscles=3.4),
)  # fmt: skip
"""Six more, made after `new` had been mended by the ten, and before it was tried on them."""

LAST = (
    _laboratory(_copies, "a folder a person, copies numbered by the system", "soft hard wood", _NAMED, "Force", "mV"),
    _laboratory(_adapter, "Discover with a load cell in volts", "low mid high",
                {"EMG 1": "FDS", "EMG 1 #2": "EDC"}, "ANALOG 3", "mV", "5"),
    _laboratory(_hdf5, "OpenSignals HDF5 of counts", "sponge eraser cork", {"CH1": "FDS", "CH2": "EDC"}, "CH3", "uV",
                "0.01", muscles=1.7 * 1000 / 3 * 65536 * 1e-6),
    _laboratory(_glued, "C3D, dates with initials, numbers glued to objects", "Foam01 Gel01 Rubber01",
                {"EMG.1": "FDS", "EMG.2": "EDC"}, "Force.Fz1", down=True),
    _laboratory(_numbers, "names of numbers alone", "1 2 3", _NAMED, "Fz", "mV", down=True),
    _laboratory(_with_mvc, "maximum contractions beside the presses", "soft medium stiff", _NAMED, "Fz", "mV"),
)  # fmt: skip
"""Six that `new` met last: it was not changed for them."""
