"""Force of a rig's sensor as a stream: every sample along the axis, lost ones in their places."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.netft.box import parse_config
from emg2vsa.devices.netft.datagrams import LoopbackDatagrams
from emg2vsa.devices.netft.driver import NetFt
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.rig_force.driver import RigForce, unit_axis
from emg2vsa.devices.streams import Block
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.session.sample_clock import SampleClock
from emg2vsa.worlds.far_ends.netft_box import BoxSettings, RdtBox, configuration_page

RATE_HZ = 1000.0


class Bench:
    """A box that feels the time, s, as newtons along -z, and 2 N across."""

    def __init__(self, *, bias: bool = False, rate_hz: float = RATE_HZ, **settings: object) -> None:
        self.clock = VirtualClock()
        loads = lambda times_s: [[2.0, 0.0, -time_s, 0.0, 0.0, 0.0] for time_s in times_s]  # noqa: E731
        self.box = RdtBox(loads, BoxSettings(rate_hz=rate_hz, noise=(1e-6, 1e-6)))
        line = LoopbackDatagrams("box", self.box, self.clock)
        sensor = NetFt(line, parse_config(configuration_page(self.box)), self.clock, stale_s=0.5, **settings)
        self.source = RigForce(sensor, RigForceSettings(rig="rig.toml", delay_s=0.001), self.clock, bias=bias)
        self.source.start()

    def read_for(self, seconds: float) -> list[Block]:
        blocks, end_s = [], self.clock.now_s() + seconds
        while self.clock.now_s() < end_s:
            self.clock.sleep_until(self.clock.now_s() + 0.005)
            blocks += self.source.read()
        return blocks


def force_by_index(blocks: list[Block]) -> np.ndarray:
    """(n,) with NaN for the numbers that no block has."""
    force_n = np.full(blocks[-1].first + len(blocks[-1].samples), np.nan)
    for block in blocks:
        assert np.isnan(force_n[block.first : block.first + len(block.samples)]).all()
        force_n[block.first : block.first + len(block.samples)] = block.samples[:, 0]
    return force_n


def test_every_sample_along_the_axis() -> None:
    bench = Bench()
    force_n = force_by_index(bench.read_for(2.0))
    info = bench.source.info
    assert (info.kind, info.channels, info.unit, info.fs_hz, info.delay_s) == ("force", ("force",), "N", RATE_HZ, 0.001)
    assert len(force_n) == pytest.approx(2000, abs=8)
    # the force is the time: no sample is missing and none comes twice
    np.testing.assert_allclose(np.diff(force_n), 1 / RATE_HZ, atol=1e-5)
    assert bench.source.counts() == (len(force_n), 0)
    assert info.range_max == bench.box.settings.rating[2]


@pytest.mark.parametrize("lost", [1, 3, 40])
def test_lost_records_have_their_places(lost: int) -> None:
    bench = Bench()
    blocks = bench.read_for(1.0)
    bench.box.faults.lose = lost
    blocks += bench.read_for(1.0)
    force_n = force_by_index(blocks)
    assert np.isnan(force_n).sum() == lost
    known = np.flatnonzero(np.isfinite(force_n))
    np.testing.assert_allclose(force_n[known] - force_n[0], known / RATE_HZ, atol=1e-5)
    assert bench.source.counts() == (len(known), lost)


def test_records_that_come_late_are_lost_once() -> None:
    bench = Bench()
    blocks = bench.read_for(0.5)
    bench.box.faults.shuffled = 2
    blocks += bench.read_for(0.004)
    bench.box.faults.shuffled = 0
    blocks += bench.read_for(0.5)
    force_n = force_by_index(blocks)
    lost = int(np.isnan(force_n).sum())
    assert 1 <= lost <= 3
    assert bench.source.counts().lost == lost
    known = np.flatnonzero(np.isfinite(force_n))
    np.testing.assert_allclose(force_n[known] - force_n[0], known / RATE_HZ, atol=1e-5)


def test_a_turn_that_took_longer_than_the_sensor_keeps() -> None:
    bench = Bench()
    bench.read_for(0.5)
    bench.clock.sleep_until(bench.clock.now_s() + 3.0)
    blocks = bench.read_for(0.1)
    times = SampleClock(RATE_HZ)
    force_n = force_by_index(blocks)
    known = np.flatnonzero(np.isfinite(force_n))
    # the sensor keeps one second; what it has dropped is counted and has its place
    assert bench.source.counts().lost == pytest.approx(2000, abs=80)
    np.testing.assert_allclose(np.diff(force_n[known][-900:]), 1 / RATE_HZ, atol=1e-5)
    for block in blocks:
        times.add(block.first, len(block.samples), block.arrived_s)
    assert times.report().missing == 0


def test_a_faulty_force_is_no_force() -> None:
    bench = Bench()
    before = force_by_index(bench.read_for(0.5))
    bench.box.faults.saturated = True
    blocks = bench.read_for(0.5)
    assert np.isnan(np.concatenate([block.samples for block in blocks[2:]])).all()
    assert bench.source.counts().lost == pytest.approx(500, abs=10)
    assert bench.source.counts().samples == pytest.approx(len(before), abs=10)
    with pytest.raises(DeviceError, match=r"expected a force that can be trusted, but found for 1 s: .*satur"):
        bench.read_for(1.0)
    bench.source.close()


def test_the_load_at_the_start_becomes_zero_when_asked() -> None:
    bench = Bench(bias=True)
    force_n = force_by_index(bench.read_for(0.2))
    assert 0.09 < force_n[0] < 0.2  # what came on since the bias was taken, 0.1 s before
    assert bench.source.info.facts["biased at the start"] == "yes"


def test_a_box_that_falls_silent() -> None:
    bench = Bench()
    bench.box.faults.mute = True
    with pytest.raises(DeviceError, match="expected 1000 records a second, but found none for"):
        bench.read_for(1.0)
    bench.source.close()


@pytest.mark.parametrize("axis", [(0.0, 0.0, 0.0), (float("nan"), 0.0, 1.0), (float("inf"), 0.0, 0.0)])
def test_an_axis_that_is_no_direction(axis: tuple[float, float, float]) -> None:
    with pytest.raises(SettingError, match=r"session\.force\.axis: expected a direction"):
        unit_axis(axis)


def test_a_direction_has_length_1() -> None:
    np.testing.assert_allclose(unit_axis((0.0, 3.0, -4.0)), [0, 0.6, -0.8])
