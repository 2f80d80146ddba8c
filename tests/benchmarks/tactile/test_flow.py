"""The comparison of flow on few pairs and quick methods."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.bench.case import Size
from benchmarks.tactile.flow_cases import growth_cases, pin_cases
from benchmarks.tactile.flow_growth import LOOKS, RADII_PITCHES
from benchmarks.tactile.flow_pairs import contact_pair
from benchmarks.tactile.flow_scores import errors_of_pair
from benchmarks.tactile.method import Method
from benchmarks.tactile.metrics import root_mean_square
from benchmarks.tactile.ours import dense, on_pins
from benchmarks.tactile.peers import dense_peers, pin_peers
from casr.flow.estimate import ENGINES

QUICK = [*dense(), *on_pins(), *[peer for peer in dense_peers() if "DIS" in peer.name]]


def test_a_method_that_knows_the_flow_has_no_error() -> None:
    pair = contact_pair(1.0)
    divergence_percent, epe_px = errors_of_pair(Method("made", "truth", lambda *_: lambda: pair.flow), pair)
    assert divergence_percent == pytest.approx(0, abs=0.01)
    assert epe_px == 0
    divergence_percent, epe_px = errors_of_pair(
        Method("made", "nothing", lambda *_: lambda: np.zeros_like(pair.flow)), pair
    )
    assert divergence_percent == pytest.approx(-100)
    assert epe_px == pytest.approx(2 / 3, rel=0.01)  # mean of k r over a disc whose edge moves by 1 px


@pytest.mark.parametrize("method", QUICK, ids=lambda method: method.name)
def test_our_methods_and_dis_see_the_same_motion(method: Method) -> None:
    divergence_percent, epe_px = errors_of_pair(method, contact_pair(1.0))
    assert abs(divergence_percent) < 15
    assert epe_px < 0.2


def test_rms_and_bias_are_two_cases_of_one_motion() -> None:
    rms, bias = pin_cases(Size.SMOKE)
    for case, of_errors in ((rms, root_mean_square), (bias, np.mean)):
        assert case.ways[0].ours
        (way,) = (way for way in case.ways if way.name == "pins followed")
        errors = [errors_of_pair(on_pins()[0], contact_pair(1.0, seed))[0] for seed in range(2)]
        assert case.error_of(way, way.run()) == pytest.approx(of_errors(np.array(errors)))
    (lucas,) = (way for way in rms.ways if way.name == "PyrLK on all pins, default")
    assert lucas.work == "equal"
    assert (rms.error_of(lucas, None) or 9) < 1


@pytest.mark.slow
def test_every_installed_peer_runs_and_points_the_right_way() -> None:
    pair = contact_pair(1.0)
    for peer in [*dense_peers(), *pin_peers()]:
        if peer.installed:
            divergence_percent, epe_px = errors_of_pair(peer, pair)
            assert -80 < divergence_percent < 10, peer.name
            assert epe_px < 1, peer.name


def test_a_peer_that_is_absent_is_known_to_be() -> None:
    for needs in ("no_such_module", "no_such_module.part", "cv2.no_such_part"):
        assert not Method("made", "absent", lambda *_: lambda: None, needs=needs).installed
    assert Method("made", "present", lambda *_: lambda: None, needs="cv2.optflow").installed


def test_lucas_and_kanade_see_what_our_pins_see() -> None:
    pair = contact_pair(1.0)
    peers_on_pins = pin_peers()
    assert len(peers_on_pins) == 3
    for method in (*peers_on_pins, on_pins()[0]):
        divergence_percent, epe_px = errors_of_pair(method, pair)
        assert abs(divergence_percent) < 1, method.name
        assert epe_px < 0.02, method.name


def test_growth_has_a_case_for_every_radius_and_skin() -> None:
    names = [case.name for case in growth_cases(Size.FULL)]
    assert len(names) == len(RADII_PITCHES) * len(LOOKS)
    (case,) = growth_cases(Size.SMOKE)
    errors = {way.name: case.error_of(way, None) or 0 for way in case.ways}
    assert tuple(errors) == ENGINES
    # on a contact of two pitches dense flow loses growth at the edge
    assert abs(errors["pin-affine"]) < 1 < abs(errors["dis"])
