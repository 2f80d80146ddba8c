"""Readers and reproductions of the benchmark on published sequences."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks import optical_flow_data as data
from benchmarks import optical_flow_references as references
from benchmarks.tactile.metrics import angular_error_deg, endpoint_error_px


def test_flo_file_by_hand(tmp_path: Path) -> None:
    path = tmp_path / "two.flo"
    path.write_bytes(struct.pack("<fii", 202021.25, 2, 1) + struct.pack("<4f", 1.5, -2, 1e10, 1e10))
    flow = data.read_flo(path)
    assert flow.shape == (1, 2, 2)
    assert flow[0, 0].tolist() == [1.5, -2]
    assert np.isnan(flow[0, 1]).all()
    path.write_bytes(b"PNG?" + bytes(20))
    with pytest.raises(SystemExit, match="flo file"):
        data.read_flo(path)


def test_metric_gives_the_numbers_barrons_program_prints(shared_data: Callable[[str], Path]) -> None:
    shared_data("flow/yosemite")
    _, truth, _ = data.yosemite()
    for kind, mean, sd in (("modified", 9.57, 15.80), ("original", 31.61, 31.19)):
        flow, edge = data.barron_output(f"yosemite/barron_horn_{kind}_output.npz")
        error = angular_error_deg(flow, truth[edge:-edge, edge:-edge])
        assert (error.mean(), error.std(ddof=1)) == pytest.approx((mean, sd), abs=0.006)


@pytest.mark.parametrize(("folder", "suffix"), [("yosemite", ""), ("translating_tree", "_frame20")])
def test_modified_horn_and_schunck_done_again(shared_data: Callable[[str], Path], folder: str, suffix: str) -> None:
    shared_data(f"flow/{folder}")
    frames = getattr(data, folder)()[0]
    theirs, edge = data.barron_output(f"{folder}/barron_horn_modified_output{suffix}.npz")
    ours = references.barron_modified(frames)[edge:-edge, edge:-edge]
    difference = endpoint_error_px(ours, theirs)
    assert np.median(difference) < 0.02
    assert np.mean(difference) < 0.05


def test_fitted_divergence_of_a_known_part() -> None:
    y, x = np.mgrid[0:40, 0:50].astype(np.float32)
    flow = np.stack([0.03 * x, 0.01 * y], axis=-1)
    flow[:5] = flow[-5:] = np.nan
    flow[:, :5] = flow[:, -5:] = np.nan
    assert references.fitted_divergence(flow) == pytest.approx(0.04, rel=1e-4)
