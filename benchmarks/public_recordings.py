"""What is said of recordings of other laboratories, and whether it is right.

Public files (``../shared/data/emg``, or EMG2VSA_TEST_DATA; origins and licences in its SOURCES.md). Where a file holds
force, it is judged with it. Few do, so EMG is also judged with a force made from its own level (low-passed at 1 Hz,
less what the quietest fifth shows, its upper twentieth at 8 N): what is said of the signals then counts, what is said of the law does not. A session
is judged as ``emg2vsa check`` judges it, and thirds of long recordings as a study of one person.

    python -m benchmarks.public_recordings     # writes benchmarks/results/public_recordings.json
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import signal

from benchmarks.bench.record import keep
from emg2vsa.arrays import Floats
from emg2vsa.errors import Emg2vsaError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import fit_trials
from emg2vsa.readers.front_door import load_named, open_recording
from emg2vsa.readers.opened import to_si
from emg2vsa.recordings import Channel
from emg2vsa.screening.screen import screen, traits_by_recording
from emg2vsa.session_verdict import judge_session
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    WindowSettings,
)

FILES = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).parents[2] / "shared" / "data")) / "emg"
RESULTS = Path(__file__).parent / "results" / "public_recordings.json"
FOLLOWS_HZ, PEAK_N, QUIET = 1.0, 8.0, 1.3


@dataclass(frozen=True)
class Case:
    """emg : muscle to channel. force : of it, in newtons times ``newtons``; "" where it is made. window_n : of the force.
    why : what is right or wrong about what is said. volts : of a stored unit, where the file does not say."""

    file: str
    emg: dict[str, str]
    why: str
    force: str = ""
    newtons: float = 1.0
    window_n: tuple[float, float] = (0.5, 7.0)
    volts: float = 1.0
    fs_hz: float | None = None
    thirds: bool = False
    force_file: str = ""


@dataclass
class Judged:
    verdict: str
    said: list[str] = field(default_factory=list)


def loaded(case: Case) -> tuple[dict[str, Channel], Channel]:
    _, opened = open_recording(FILES / case.file)
    names = [*case.emg.values(), *([case.force] if case.force and not case.force_file else [])]
    stored = [to_si(each) for each in load_named(opened, names, [case.fs_hz] * len(names))]
    emg = {
        muscle: Channel(muscle, case.volts * own.samples, "V", own.fs_hz, own.start_s, own.conversion)
        for muscle, own in zip(case.emg, stored, strict=False)
    }
    if case.force_file:
        _, opened = open_recording(FILES / case.force_file)
        stored += [to_si(each) for each in load_named(opened, [case.force])]
    if case.force:
        own = stored[-1]
        return emg, Channel("force", case.newtons * own.samples, "N", own.fs_hz, own.start_s, own.conversion)
    return emg, followed(emg)


def followed(emg: dict[str, Channel]) -> Channel:
    """A force that rises and falls with the level of all muscles."""
    first = next(iter(emg.values()))
    low = signal.butter(2, FOLLOWS_HZ, fs=first.fs_hz, output="sos")
    high = signal.butter(2, 20.0, "highpass", fs=first.fs_hz, output="sos")
    level = sum(
        np.abs(signal.sosfiltfilt(high, np.nan_to_num(each.samples - np.nanmean(each.samples))))
        for each in emg.values()
    )
    slow: Floats = signal.sosfiltfilt(low, level)
    slow = np.maximum(slow - QUIET * np.quantile(slow, 0.2), 0.0)
    return Channel("force", PEAK_N / np.quantile(slow, 0.95) * slow, "N", first.fs_hz, first.start_s, "made of EMG")


def extracted(case: Case, emg: dict[str, Channel], force: Channel, specimen: str) -> tuple[Trials, WindowSettings]:
    window = WindowSettings(force_n=case.window_n, min_duration_s=0.5 if case.force else 0.1)
    trials = extract_trials(
        emg, force, participant="P", specimen=specimen, filters=FilterSettings(),
        cocontraction=CocontractionSettings(), window=window,
        force_channel=ForceChannelSettings(name="force"),
    )  # fmt: skip
    return trials, window


def judged(case: Case) -> Judged:
    try:
        emg, force = loaded(case)
        trials, window = extracted(case, emg, force, "S")
    except Emg2vsaError as error:
        return Judged("refused", [str(error).partition(": ")[2] or str(error)])
    session = judge_session("P", [trials], {"S": fit_trials(trials, FitSettings(), window)}, {"S": None}, {})
    said = [each.text.removeprefix("S: ") for each in session.advice]
    if case.thirds:
        parts = [extracted(case, *third(emg, force, k), f"T{k}")[0] for k in range(3)]
        found = screen(traits_by_recording(parts)).found
        said += [f"third {each.specimen[1:]}: {each.said}" for each in found] or ["thirds: alike"]
    return Judged(session.verdict, said)


def third(emg: dict[str, Channel], force: Channel, k: int) -> tuple[dict[str, Channel], Channel]:
    def part(one: Channel) -> Channel:
        n = one.samples.size // 3
        return Channel(one.name, one.samples[k * n : (k + 1) * n], one.unit, one.fs_hz, one.start_s, one.conversion)

    return {muscle: part(one) for muscle, one in emg.items()}, part(force)


VL = "Vastus Lateralis - AUX 3 (Channel 1->1) - GR08MM1305 ({})"
COUNTS_V = 3.0 / 2**16 / 1000
"""Volts of a count of a 16 bit converter of 3 V behind a gain of 1000."""
CASES = {
    "forearm, gripping counts of a Mini45": Case(
        "ati/atusa_myo_mini45_raw_01.csv", {"EDC": "emg0", "FDS": "emg4"}, "", force="Fz", fs_hz=243.0, volts=1e-6
    ),
    "grip, one EMG": Case(
        "emg_force/novainstrumentation_emg.txt", {"FDS": "row 2"}, "", force="row 2", newtons=0.1, volts=1e-3,
        force_file="emg_force/novainstrumentation_force.txt", window_n=(0.5, 7.0),
    ),
    "knee, monopolar grid, force in % MVC": Case(
        "emg_force/openhdemg_otb_testfile_VL64_force.mat", {"A": VL.format(1), "B": VL.format(40)}, "",
        force="acquired data", newtons=0.4,
    ),
    "gait, force plate": Case(
        "c3d/btk_PiG_Motion-FlatFoot-Full.c3d", {"TA": "R_TA", "GL": "R_GL"}, "", force="plate 1 Fz", newtons=0.02
    ),
    "gait, right leg": Case("c3d/btk_PiG_Motion-FlatFoot-Full.c3d", {"TA": "R_TA", "GL": "R_GL"}, ""),
    "gait, mV": Case(
        "c3d/btk_1123x01EMG.c3d", {"TA": "Right Tibialis Anterior", "GL": "Right Gastrocnemius Lateralis"}, ""
    ),
    "eight muscles, 4 and 5": Case("delsys_native/btk_Set1_Rep2_v3.emg", {"A": "EMG Ch4", "B": "EMG Ch5"}, "", thirds=True),
    "eight muscles, 3 and 6": Case("delsys_native/btk_Set1_Rep2_v3.emg", {"A": "EMG Ch3", "B": "EMG Ch6"}, "", thirds=True),
    "eight muscles, 7 and 8": Case("delsys_native/btk_Set1_Rep2_v3.emg", {"A": "EMG Ch7", "B": "EMG Ch8"}, "", thirds=True),
    "forearm, fast arm movements": Case(
        "delsys_native/btk_Run34_EDC_FCR_BIC_TRI.hpf",
        {"EDC": "R EXTENSOR DIGITORUM: EMG 3", "FCR": "R FLEXOR CARPI RADIALIS: EMG 5"}, "",
    ),
    "bursts of one muscle": Case("opensignals/bsnb_emg_bursts.h5", {"A": "PORT3_CHN1"}, "", volts=COUNTS_V, thirds=True),
    "electrodes on nothing that moves": Case("vicon_csv/pyomeca_analogs_first2000.csv", {"A": "EMG1", "B": "EMG4"}, ""),
    "mains in a sensor that is off": Case(
        "delsys_csv/emgio_emgworks_verbose_truncated.csv",
        {"A": "Mini sensor 10: EMG 10", "B": "Mini sensor 11: EMG 11"}, "",
    ),
    "one second of standing": Case("anc/btk_Res16bits.anc", {"TA": "R Tibialis Ant", "GM": "R Gastrocnemius Med"}, ""),
    "slow sensors that are no EMG": Case(
        "opensignals/bsnb_raw_3ch_2018_7_4.txt", {"A": "CH1", "B": "CH2"}, "", volts=COUNTS_V
    ),
    "placeholder of a data standard": Case(
        "bids/emg_IndependentMod/sub-01/emg/sub-01_task-grasping_emg.edf", {"A": "EMG1", "B": "EMG2"}, ""
    ),
}  # fmt: skip


def table() -> list[str]:
    lines = ["| recording | file | force | verdict | said | right? |", "|---|---|---|---|---|---|"]
    for name, case in CASES.items():
        found = judged(case)
        said = "; ".join(found.said).replace("|", "/") or "nothing"
        lines.append(f"| {name} | {case.file} | {case.force or 'made'} | {found.verdict} | {said} | {case.why} |")
    return lines


if __name__ == "__main__":
    text = "# Public recordings\n\n" + "\n".join(table())
    keep(RESULTS, text)
    print(text)
