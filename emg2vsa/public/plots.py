"""Results that draw themselves: each function draws into Axes of Matplotlib, and returns them for more of your own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import pyplot
from matplotlib.axes import Axes
from scipy.special import stdtrit

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError, SettingError
from emg2vsa.figures.palette import INK, VERDICT_COLOURS, ActivityScale, Look, activity_scale, looks
from emg2vsa.public.given import column, numbers_of, of_kind, refuse_missing_labels
from emg2vsa.public.recordings import Recording, fit, samples
from emg2vsa.settings import StageSettings

_FORCE_N = (0.5, 7.0)
"Where curves are drawn when nothing tells the window."
_FORCE, _CONTRACTION = "force (N)", "co-contraction"


def plot_press(
    recording: Recording, repetition: int = 1, settings: StageSettings | None = None, axes: Axes | None = None
) -> Axes:
    """Co-contraction against force of one press: its samples, and the fit v = a + b ln(F / 1 N).

    The title says of a rejected press that it is one, and why.

    repetition : number of the press in its recording, from 1. axes : to draw into; None: new ones.
    SettingError : there is no such press. SignalError : the recording cannot be conditioned.
    """
    found, fitted = samples(recording, settings), fit(recording, settings)
    press, line = (table[table["repetition"] == repetition] for table in (found, fitted))
    if line.empty:
        numbers = ", ".join(map(str, fitted["repetition"])) or "none"
        do = "Choose one of them."
        raise SettingError("plot_press, repetition", wanted=f"a press ({numbers})", found=repr(repetition), do=do)
    activity = press[next(name for name in press.columns if name.startswith("activity"))].to_numpy(np.float64)
    scale = activity_scale(str(fitted.attrs["activity_unit"]), activity)
    drawn = _axes(axes, _FORCE, scale.label(_CONTRACTION))
    force_n = press["force_n"].to_numpy(np.float64)
    drawn.plot(force_n, activity * scale.factor, ".", color="0.7", markersize=3, label=f"samples of press {repetition}")
    if force_n.size and np.isfinite(line["b_v"].iloc[0]):
        grid = np.geomspace(force_n.min(), force_n.max(), 100)
        (curve,) = _curves(line, grid) * scale.factor
        b = f"b = {line['b_v'].iloc[0] * scale.factor:.3g} {scale.unit}".rstrip()
        drawn.plot(grid, curve, color=INK, linewidth=2, label=f"v = a + b ln F, {b}")
    verdict, reason = (str(line[name].iloc[0]) for name in ("verdict", "reason"))
    if verdict == "rejected":
        drawn.set_title(_literal(f"press {repetition} rejected: {reason}"), color=VERDICT_COLOURS[verdict], wrap=True)
    drawn.legend()
    return drawn


def plot_fits(fits: pd.DataFrame, axes: Axes | None = None) -> Axes:
    """The curve v = a + b ln(F / 1 N) of every press, thin, and the mean of each specimen, thick.

    fits : as `emg2vsa.fit` gives them or ``load(study).fits``; rejected presses are left out. axes : to draw into.
    DataError : a column is missing or no press has a fit.
    """
    used, scale = _used(fits)
    drawn, grid = _axes(axes, _FORCE, scale.label(_CONTRACTION)), np.geomspace(*_FORCE_N, 60)
    means = {}
    for specimen, look in _looks(used).items():
        curves = _curves(used[used["specimen"] == specimen], grid) * scale.factor
        drawn.plot(grid, curves.T, color=look.colour, alpha=0.25, linewidth=0.7)
        mean = np.mean(curves, axis=0)
        (line,) = drawn.plot(grid, mean, color=look.colour, linestyle=look.dash, linewidth=2.5, label=str(specimen))
        means[_literal(specimen)] = line
    if any(means):  # presses of one recording need no name of a specimen
        # given by hand, as Matplotlib leaves out of its own what begins with an underscore
        drawn.legend([*means.values()], [*means], title="mean of the presses on")
    return drawn


def plot_specimens(fits: pd.DataFrame, axes: Axes | None = None) -> Axes:
    """The slope b of each specimen: a dot for the mean of each person, and the mean of people with its 95 % interval.

    fits : as for `plot_fits`. Without a column ``participant`` all presses are one person's. axes : to draw into.
    DataError : a column is missing or no press has a fit.
    """
    used, scale = _used(fits)
    drawn = _axes(axes, "specimen", scale.label("slope b"))
    people = used["participant"] if "participant" in used else pd.Series("", index=used.index)
    means = (used["b_v"] * scale.factor).groupby([used["specimen"], people], sort=False).mean()
    worn = _looks(used)
    for place, (specimen, look) in enumerate(worn.items()):
        b = means[specimen].to_numpy(np.float64)
        drawn.plot(place + np.linspace(-0.15, 0.15, b.size), b, look.marker, color=look.colour, alpha=0.5)
        drawn.errorbar(place, b.mean(), _half_width(b), fmt="_", color=INK, markersize=18, capsize=5)
    names = [_literal(specimen) for specimen in worn]
    drawn.set_xticks(range(len(names)), names)
    drawn.set(xlim=(-0.5, len(names) - 0.5), ylim=(min(0.0, drawn.get_ylim()[0]), None))
    return drawn


def _literal(name: object) -> str:
    """A name as Matplotlib shows it letter by letter: between two dollar signs it would set a formula."""
    return str(name).replace("$", r"\$")


def _used(fits: pd.DataFrame) -> tuple[pd.DataFrame, ActivityScale]:
    """The presses that are drawn, and the unit of the activity."""
    of_kind(fits, pd.DataFrame, "fits", "a DataFrame", "Give what emg2vsa.fit or load(study).fits gave.")
    refuse_missing_labels(fits, "fits")
    known = np.isfinite(numbers_of(fits, "a_v", "fits")) & np.isfinite(numbers_of(fits, "b_v", "fits"))
    column(fits, "specimen", "fits")
    used = fits[known & (fits["verdict"] != "rejected")] if "verdict" in fits else fits[known]
    if used.empty:
        do = "Look at the columns verdict and reason."
        raise DataError("fits", wanted="a press that was fitted and not rejected", found="none", do=do)
    levels = _curves(used, np.array(_FORCE_N))
    return used, activity_scale(str(fits.attrs.get("activity_unit", "V")), levels)


def _looks(used: pd.DataFrame) -> Mapping[Any, Look]:
    names: Sequence[Any] = list(dict.fromkeys(used["specimen"]))
    return dict(zip(names, looks([str(name) for name in names]).values(), strict=True))


def _curves(fits: pd.DataFrame, force_n: Floats) -> Floats:
    """v of each press at each force (presses, forces)."""
    a_v, b_v = (fits[name].to_numpy(np.float64)[:, None] for name in ("a_v", "b_v"))
    return np.asarray(a_v + b_v * np.log(force_n))


def _half_width(values: Floats) -> float:
    """Half the 95 % interval of the mean by Student's t; NaN for one value, which tells no scatter."""
    if values.size < 2:
        return float("nan")
    return float(stdtrit(values.size - 1, 0.975) * values.std(ddof=1) / np.sqrt(values.size))


def _axes(axes: Axes | None, x_label: str, y_label: str) -> Axes:
    drawn = axes if axes is not None else pyplot.subplots(figsize=(6, 3.5), layout="constrained")[1]
    of_kind(drawn, Axes, "axes", "Axes of Matplotlib", "Give axes, as plt.subplots() makes them, or leave them out.")
    drawn.set(xlabel=x_label, ylabel=y_label)
    return drawn
