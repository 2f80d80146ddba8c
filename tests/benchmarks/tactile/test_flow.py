"""The comparison of flow on few pairs and quick methods."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.tactile.flow import compare, errors_of_pair, flow_table, front_table
from benchmarks.tactile.flow_growth import LOOKS, growth_table
from benchmarks.tactile.flow_pairs import contact_pair
from benchmarks.tactile.method import Method
from benchmarks.tactile.ours import ours
from benchmarks.tactile.peers import peers
from benchmarks.tactile.time_error_plot import Point, draw, write_plot
from casr.flow.estimate import ENGINES

QUICK = [*ours(), *[peer for peer in peers() if "DIS" in peer.name]]


def test_a_method_that_knows_the_flow_has_no_error() -> None:
    pair = contact_pair(1.0)
    divergence_percent, epe_px = errors_of_pair(Method("truth", lambda *_: lambda: pair.flow), pair)
    assert divergence_percent == pytest.approx(0, abs=0.01)
    assert epe_px == 0
    divergence_percent, epe_px = errors_of_pair(Method("nothing", lambda *_: lambda: np.zeros_like(pair.flow)), pair)
    assert divergence_percent == pytest.approx(-100)
    assert epe_px == pytest.approx(2 / 3, rel=0.01)  # mean of k r over a disc whose edge moves by 1 px


def test_our_methods_and_dis_see_the_same_motion() -> None:
    results = compare(QUICK, n_seeds=1, budget_s=1e-3)
    assert [r.method.name for r in results] == [method.name for method in QUICK]
    for result in results:
        assert np.abs(result.divergence_error_percent).max() < 15, result.method.name
        assert result.epe_px[:2].max() < 0.2, result.method.name
    text = flow_table(results, ["absent peer"], 1).text()
    assert "absent peer" in text
    assert "nan" not in text + front_table(results).text()


@pytest.mark.slow
def test_every_installed_peer_runs_and_points_the_right_way() -> None:
    pair = contact_pair(1.0)
    for peer in peers():
        if peer.installed:
            divergence_percent, epe_px = errors_of_pair(peer, pair)
            assert -80 < divergence_percent < 10, peer.name
            assert epe_px < 1, peer.name


def test_a_peer_that_is_absent_is_known_to_be() -> None:
    for needs in ("no_such_module", "no_such_module.part", "cv2.no_such_part"):
        assert not Method("absent", lambda *_: lambda: None, needs=needs).installed
    assert Method("present", lambda *_: lambda: None, needs="cv2.optflow").installed


def test_lucas_and_kanade_see_what_our_pins_see() -> None:
    pair = contact_pair(1.0)
    peers_on_pins = [peer for peer in peers() if "PyrLK" in peer.name]
    assert len(peers_on_pins) == 3
    for method in (*peers_on_pins, *(method for method in ours() if "followed" in method.name)):
        divergence_percent, epe_px = errors_of_pair(method, pair)
        assert abs(divergence_percent) < 1, method.name
        assert epe_px < 0.02, method.name


def test_growth_by_radius_has_a_row_for_every_engine_and_skin() -> None:
    table = growth_table(1)
    assert [row[:2] for row in table.rows] == [[engine, look] for look in LOOKS for engine in ENGINES]
    mean = {(row[0], row[1]): row[2::2] for row in table.rows}
    assert all(abs(error) < 1 for error in mean["pin-affine", "clean"])
    # the smaller the contact, the more dense flow loses
    assert mean["dis", "clean"][0] < mean["dis", "clean"][2] < -1
    assert abs(mean["horn-schunck", "clean"][-1]) < 1


def test_labels_of_the_plot_do_not_cover_each_other(tmp_path: Path) -> None:
    crowd = [Point(f"method number {i}", 1 + 0.05 * i, 1 + 0.03 * i) for i in range(6)] + [Point("far", 900, 60)]
    figure = draw(crowd, "error, %")
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    boxes = [text.get_window_extent(renderer) for text in figure.axes[0].texts]
    assert len(boxes) == len(crowd)
    assert all(box.count_overlaps(boxes) == 1 for box in boxes)
    write_plot(crowd, tmp_path / "plot", "error, %")
    assert {path.name for path in tmp_path.iterdir()} == {"plot.png", "plot.svg"}
