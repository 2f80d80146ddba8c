"""Results that draw themselves: what is in the Axes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot
from matplotlib.axes import Axes

import emg2vsa
from emg2vsa.sample_data import write_sample

ROWS = [
    ("P1", "S1", 1, 50e-6, 20e-6, "ok"), ("P1", "S1", 2, 52e-6, 22e-6, "doubtful"), ("P2", "S1", 1, 60e-6, 27e-6, "ok"),
    ("P1", "S2", 1, 30e-6, 9e-6, "ok"), ("P2", "S2", 1, 31e-6, 11e-6, "ok"), ("P2", "S2", 2, 0, 900e-6, "rejected"),
    ("P2", "S2", 3, np.nan, np.nan, "ok"),
]  # fmt: skip
FITS = pd.DataFrame(ROWS, columns=["participant", "specimen", "repetition", "a_v", "b_v", "verdict"])
BAD: Any = 3


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    pyplot.close("all")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> emg2vsa.Recording:
    first, *_ = write_sample("recordings", Path(tmp_path_factory.mktemp("a"), "recordings"))
    return emg2vsa.read(first, emg=["EDC", "FDS"], force="Fz")


def test_the_curves_of_presses_and_their_means() -> None:
    axes = emg2vsa.plot_fits(FITS)
    lines = {line.get_label(): line for line in axes.lines}
    assert len(axes.lines) == 5 + 2
    force_n, v = lines["S1"].get_data()
    mean = (54 + 23 * np.log(np.asarray(force_n))).tolist()
    assert np.asarray(v).tolist() == pytest.approx(mean)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("force (N)", "co-contraction (µV)")


def test_the_slopes_of_people_and_their_mean() -> None:
    axes = emg2vsa.plot_specimens(FITS)
    dots = [np.asarray(line.get_ydata()).tolist() for line in axes.lines if line.get_marker() in "oD"]
    assert dots == [pytest.approx([21.0, 27.0]), pytest.approx([9.0, 11.0])]
    bars = [container.lines[2][0].get_segments()[0][:, 1] for container in axes.containers]  # type: ignore[attr-defined]
    # Student's t of one degree of freedom
    assert bars[0].tolist() == pytest.approx([24 - 12.706 * 3, 24 + 12.706 * 3], rel=1e-3)
    assert [label.get_text() for label in axes.get_xticklabels()] == ["S1", "S2"]


def test_one_person_has_no_interval_and_names_may_be_numbers() -> None:
    axes = emg2vsa.plot_specimens(pd.DataFrame({"specimen": [1, 1, 2], "a_v": 1e-5, "b_v": [1e-6, 3e-6, 4e-6]}))
    assert [segment.size for segment in axes.containers[0].lines[2][0].get_segments()] == [0]  # type: ignore[attr-defined]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["1", "2"]


@pytest.mark.filterwarnings("error")
def test_names_are_shown_letter_by_letter() -> None:
    names = ["$a^2$", "_soft"]
    fits = FITS.assign(specimen=FITS["specimen"].map({"S1": names[0], "S2": names[1]}))
    axes = emg2vsa.plot_fits(fits)
    legend = axes.get_legend()
    assert legend is not None
    shown = [*legend.get_texts(), *emg2vsa.plot_specimens(fits).get_xticklabels()]
    assert [text._preprocess_math(text.get_text()) for text in shown] == [(name, False) for name in names * 2]  # type: ignore[attr-defined]


@pytest.mark.filterwarnings("error")
def test_presses_of_one_recording_need_no_legend(recording: emg2vsa.Recording) -> None:
    assert emg2vsa.plot_fits(emg2vsa.fit(recording)).get_legend() is None


def test_a_rejected_press_says_so_and_why(recording: emg2vsa.Recording) -> None:
    settings = emg2vsa.Settings(window={"min_duration_s": 0.1, "max_duration_s": 0.3})
    reason = emg2vsa.fit(recording, settings)["reason"].iloc[0]
    assert reason
    assert emg2vsa.plot_press(recording, 1, settings).get_title() == f"press 1 rejected: {reason}"
    assert emg2vsa.plot_press(recording, 1).get_title() == ""


def test_one_press_with_its_fit(recording: emg2vsa.Recording) -> None:
    _, own = pyplot.subplots()
    axes = emg2vsa.plot_press(recording, 2, axes=own)
    assert axes is own
    press = emg2vsa.samples(recording).query("repetition == 2")
    fitted = emg2vsa.fit(recording).iloc[1]
    points, curve = axes.lines
    assert np.asarray(points.get_ydata()) == pytest.approx(1e6 * press["activity_v"].to_numpy())
    force_n, v = (np.asarray(each) for each in curve.get_data())
    assert v == pytest.approx(1e6 * (fitted["a_v"] + fitted["b_v"] * np.log(force_n)))
    assert f"b = {1e6 * fitted['b_v']:.3g} µV" in str(curve.get_label())


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda r: emg2vsa.plot_press(r, 99), "plot_press, repetition: expected a press (1, 2, "),
        (lambda r: emg2vsa.plot_press(BAD), "expected a Recording, but found int"),
        (lambda r: emg2vsa.plot_fits(BAD), "fits: expected a DataFrame, but found int"),
        (lambda r: emg2vsa.plot_fits(FITS, axes=BAD), "axes: expected Axes of Matplotlib, but found int"),
        (lambda r: emg2vsa.plot_fits(FITS.drop(columns="b_v")), "expected a column 'b_v'"),
        (lambda r: emg2vsa.plot_specimens(FITS.drop(columns="specimen")), "expected a column 'specimen'"),
        (lambda r: emg2vsa.plot_specimens(FITS[FITS["verdict"] == "rejected"]), "a press that was fitted"),
        (lambda r: emg2vsa.plot_fits(FITS[:0]), "a press that was fitted and not rejected, but found none"),
        (lambda r: emg2vsa.plot_fits(FITS.assign(specimen=["S1", None, *"abcde"])), "a name in every row"),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_is_said(call: Any, said: str, recording: emg2vsa.Recording) -> None:
    with pytest.raises(emg2vsa.Emg2vsaError) as error:
        call(recording)
    assert said in str(error.value)


def test_normalised_activity_has_no_unit() -> None:
    fits = FITS.copy()
    fits.attrs["activity_unit"] = "mvc"
    axes: Axes = emg2vsa.plot_fits(fits)
    assert "V" not in axes.get_ylabel()
