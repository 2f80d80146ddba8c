"""``emg2vsa fit``: one recording, no study; its presses and their fits v = a + b ln F."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_channels, add_reading, channels_of, checked_settings, given, reading_of

if TYPE_CHECKING:
    from emg2vsa.extraction import Trials
    from emg2vsa.fits import Fits


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "fit",
        run,
        "Find the presses of one recording and fit v = a + b ln F to each. This needs no study file.",
        "Without --emg or --force the command lists the channels of the file. Exit status 1: no press was found. "
        "Example: emg2vsa fit P01_S1.csv --emg EDC --emg FDS --force Fz --sign -1",
    )
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="recording: CSV, text, EMGworks, Discover, C3D, EDF, BDF, .mat"
    )
    add_channels(parser)
    add_reading(parser)
    method = parser.add_argument_group("method")
    method.add_argument(
        "--window", type=float, nargs=2, metavar=("LOW", "HIGH"), help="force window, N (default 0.5 7)"
    )
    method.add_argument("--min-duration", type=float, metavar="S", help="shortest loading phase, s (default 0.5)")
    method.add_argument("--band", type=float, nargs=2, metavar=("LOW", "HIGH"), help="EMG band, Hz (default 10 450)")
    method.add_argument("--output-fs", type=float, metavar="HZ", help="rate of the fitted curves, Hz (default 100)")
    method.add_argument("--bin", type=float, metavar="N", help="force bin, N (default 0.3)")
    method.add_argument("--force-cutoff", type=float, metavar="HZ", help="force low-pass, Hz (default 5)")
    method.add_argument(
        "--paper", action="store_true", help="the paper's method: causal filters, least squares on samples"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    if not arguments.emg or arguments.force is None:
        return _list_channels(arguments)
    from emg2vsa.fits import fit_trials
    from emg2vsa.pipeline.stages.trials import trials_of
    from emg2vsa.settings import CocontractionSettings

    settings = _settings(arguments)
    fit = settings.pop("fit")
    trials = trials_of(
        arguments.file, arguments.force_file, arguments.file.stem, "", cocontraction=CocontractionSettings(), **settings
    )
    fits = fit_trials(trials, fit, settings["window"])
    if arguments.json:
        print_json({"file": str(arguments.file), "notes": list(trials.notes), "trials": _rows(trials, fits)})
    else:
        _print(trials, fits)
    return 0 if trials.repetition.size else 1


def _settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """The settings of each stage, checked as a study file's are."""
    from emg2vsa.settings import PAPER, ChannelSettings, FilterSettings, FitSettings, WindowSettings

    paper = PAPER if arguments.paper else {}
    filters = {
        "band_hz": arguments.band, "output_fs_hz": arguments.output_fs, "force_cutoff_hz": arguments.force_cutoff,
    }  # fmt: skip
    window = {"force_n": arguments.window, "min_duration_s": arguments.min_duration}
    asked = {
        "channels": (ChannelSettings, channels_of(arguments)),
        "filters": (FilterSettings, {**paper.get("filters", {}), **given(filters)}),
        "window": (WindowSettings, {**paper.get("window", {}), **given(window)}),
        "fit": (FitSettings, {**paper.get("fit", {}), **given({"bin_n": arguments.bin})}),
    }
    return checked_settings("fit", asked) | {"reading": reading_of(arguments, "fit")}


def _list_channels(arguments: argparse.Namespace) -> int:
    from emg2vsa.readers.front_door import open_recording

    name, opened = open_recording(arguments.file, reading_of(arguments, "fit"))
    channels = opened.describe()
    if arguments.json:
        notes = list(opened.contents.notes)
        print_json({"format": name, "channels": [vars(channel) for channel in channels], "notes": notes})
        return 0
    print(f"{arguments.file}: {name}, {len(channels)} channel{'s' if len(channels) != 1 else ''}")
    width = max((len(channel.name) for channel in channels), default=0)
    for channel in channels:
        rate = f"{channel.fs_hz:.4f} Hz" if channel.fs_hz > 0 else "rate unknown"
        print(f"  {channel.name:<{width}}  {channel.unit or 'no unit':<10} {rate:>14} {channel.n_samples:>9} samples")
    for note in opened.contents.notes:
        print(f"note: {note}")
    absent = [*([] if arguments.emg else ["--emg CHANNEL"]), *([] if arguments.force else ["--force CHANNEL"])]
    print(f"To fit, add {' and '.join(absent)}; more muscles: --emg again")
    return 0


def _rows(trials: Trials, fits: Fits) -> list[dict[str, Any]]:
    names = (
        "repetition", "verdict", "start_s", "a_v", "b_v", "a_se_v", "b_se_v", "b_lo_v", "b_hi_v", "n_points", "adj_r2",
        "r2_bins", "adj_r2_bins", "r2_samples", "adj_r2_samples", "n_effective", "lag1",
    )  # fmt: skip
    rows = [{name: getattr(fits, name)[i].item() for name in names} for i in range(fits.repetition.size)]
    for row, reason, stop_s in zip(rows, trials.reasons, trials.stop_s, strict=True):
        row |= {"reason": reason, "stop_s": float(stop_s), "unit": trials.activity_unit}
    return rows


def _print(trials: Trials, fits: Fits) -> None:
    rows = _rows(trials, fits)
    ok = sum(row["verdict"] == "ok" for row in rows)
    print(f"{len(rows)} press{'es' if len(rows) != 1 else ''} found, {ok} ok; v = a + b ln(F / 1 N), in microvolts")
    if rows:
        _print_table(rows)
    for note in trials.notes:
        print(f"note: {note}")


def _print_table(rows: list[dict[str, Any]]) -> None:
    head = ("press", "from s", "to s", "verdict", "a", "b", "b 95 % interval", "adj R2 bins", "samples", "n eff")
    print("{:>5} {:>8} {:>8} {:<9} {:>8} {:>8} {:>20} {:>11} {:>8} {:>6}".format(*head))
    for row in rows:
        interval = f"{row['b_lo_v'] * 1e6:.3g} to {row['b_hi_v'] * 1e6:.3g}"
        print(
            f"{row['repetition']:>5} {row['start_s']:>8.3f} {row['stop_s']:>8.3f} {row['verdict']:<9} "
            f"{row['a_v'] * 1e6:>8.4g} {row['b_v'] * 1e6:>8.4g} {interval:>20} "
            f"{row['adj_r2_bins']:>11.3f} {row['adj_r2_samples']:>8.3f} {row['n_effective']:>6.0f}"
        )
        if row["reason"]:
            print(f"      {row['reason']}")
