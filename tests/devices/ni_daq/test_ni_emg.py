"""EMG from an emulated NI card, alone and together with the gauges of a force sensor."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from emg2vsa.ati import GaugeCalibration
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.ni_daq import NiEmgSettings
from emg2vsa.devices.ni_daq.gauges import DaqFt
from emg2vsa.devices.ni_daq.inputs import BUFFER_S, NiEmg, NiInputs, open_emg
from emg2vsa.devices.registry import Around
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.rig_force.driver import RigForce
from emg2vsa.devices.streams import Block, Source
from emg2vsa.errors import DeviceError
from emg2vsa.session.sample_clock import SampleClock
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import Person, Response
from tests.devices.ni_daq.emulated_card import EmulatedNi

SETTINGS = NiEmgSettings(
    channels={"EDC": "Dev1/ai6", "FDS": "Dev1/ai7"},
    gain=1000.0,
    fs_hz=1000.0,
    range_v=5.0,
    delay_s=0.002,
)
GAUGES = ("Dev1/ai0:5",)


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


@pytest.fixture
def card(clock: VirtualClock, monkeypatch: pytest.MonkeyPatch) -> Iterator[EmulatedNi]:
    person = Person(name="P1", responses={"S1": Response(42e-6, 20e-6, 7.6)}, muscle_share={"EDC": 0.4, "FDS": 0.6})
    card = EmulatedNi(EmulatedParticipant(person), {"Dev1/ai6": "EDC", "Dev1/ai7": "FDS"}, clock, gain=1000.0)
    monkeypatch.setitem(sys.modules, "nidaqmx", card)
    monkeypatch.setitem(sys.modules, "nidaqmx.constants", card.constants)
    return card


@pytest.fixture
def inputs(card: EmulatedNi, clock: VirtualClock) -> NiInputs:
    return NiInputs(SETTINGS.fs_hz, clock)


@pytest.fixture
def emg(inputs: NiInputs, clock: VirtualClock) -> NiEmg:
    group = inputs.add(tuple(SETTINGS.channels.values()), 2, (-5.0, 5.0), differential=False)
    return NiEmg(SETTINGS, group, clock)


def gauges(inputs: NiInputs, clock: VirtualClock) -> RigForce:
    group = inputs.add(GAUGES, 6, (-10.0, 10.0), differential=True)
    sensor = DaqFt(group, GaugeCalibration("FT1", np.eye(6), (-10.0, 10.0)), clock, stale_s=0.5)
    return RigForce(sensor, RigForceSettings(rig="rig.toml"), clock, bias=True)


def read_for(clock: VirtualClock, seconds: float, *sources: Source) -> list[list[Block]]:
    blocks: list[list[Block]] = [[] for _ in sources]
    end_s = clock.now_s() + seconds
    while clock.now_s() < end_s:
        clock.sleep_until(clock.now_s() + 0.005)
        for source, taken in zip(sources, blocks, strict=True):
            taken += source.read()
    return blocks


def numbered(blocks: list[Block]) -> int:
    """Samples of blocks without a gap."""
    for block, after in pairwise(blocks):
        assert after.first == block.first + len(block.samples)
    return blocks[-1].first + len(blocks[-1].samples)


def test_volts_at_the_skin(clock: VirtualClock, emg: NiEmg) -> None:
    emg.start()
    (blocks,) = read_for(clock, 2.0, emg)
    samples = np.concatenate([block.samples for block in blocks])
    info = emg.info
    assert (info.channels, info.unit, info.fs_hz, info.range_max, info.delay_s) == (
        ("EDC", "FDS"),
        "V",
        1000.0,
        5e-3,
        0.002,
    )
    assert len(samples) == numbered(blocks) == pytest.approx(2000, abs=10)
    # noise of a hand at rest in volts at the skin, in steps of the card's 16 bits over ±5 V
    assert np.all((samples.std(axis=0) > 2e-7) & (samples.std(axis=0) < 2e-5))
    steps = samples * 1000.0 / (10.0 / 65536)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert emg.counts() == (len(samples), 0)


def test_the_card_s_own_rate_is_measured(clock: VirtualClock, card: EmulatedNi, emg: NiEmg) -> None:
    card.clock_error = 2e-3
    emg.start()
    times = SampleClock(emg.info.fs_hz)
    for block in read_for(clock, 20.0, emg)[0]:
        times.add(block.first, len(block.samples), block.arrived_s)
    assert times.report().rate_hz == pytest.approx(1002.0, abs=0.02)
    assert times.report().missing == 0


def test_samples_overwritten_are_counted_and_their_time_is_kept(clock: VirtualClock, emg: NiEmg) -> None:
    emg.start()
    times = SampleClock(emg.info.fs_hz)
    blocks = read_for(clock, 10.0, emg)[0]
    clock.sleep_until(clock.now_s() + BUFFER_S + 5)
    blocks += read_for(clock, 5.0, emg)[0]
    for block in blocks:
        times.add(block.first, len(block.samples), block.arrived_s)
    came = sum(len(block.samples) for block in blocks)
    assert came == pytest.approx(15_000, abs=20)
    assert emg.counts() == (came, pytest.approx(1000 * (BUFFER_S + 5), abs=20))
    assert sum(emg.counts()) == blocks[-1].first + len(blocks[-1].samples)
    assert times.report().missing == 0
    assert times.time_s(sum(emg.counts()) - 1) == pytest.approx(clock.now_s(), abs=0.005)


def test_gauges_of_the_same_card_share_its_clock(clock: VirtualClock, inputs: NiInputs, emg: NiEmg) -> None:
    force = gauges(inputs, clock)
    emg.start()
    force.start()
    read_for(clock, 0.1, emg, force)
    emg_blocks, force_blocks = read_for(clock, 3.0, emg, force)
    samples = np.concatenate([block.samples for block in force_blocks])
    assert len(samples) == sum(len(block.samples) for block in emg_blocks) == pytest.approx(3000, abs=5)
    assert samples.shape[1] == 1
    assert np.abs(samples).max() < 0.05  # open inputs
    assert force.counts().lost == 0
    # each is closed by itself
    emg.close()
    assert numbered(read_for(clock, 0.5, force)[0]) > 3000
    emg.start()
    (blocks,) = read_for(clock, 0.5, emg)
    assert blocks[0].first == 0
    assert numbered(blocks) == sum(emg.counts())


def test_a_card_that_is_unplugged_and_plugged_in(
    clock: VirtualClock, card: EmulatedNi, inputs: NiInputs, emg: NiEmg
) -> None:
    force = gauges(inputs, clock)
    emg.start()
    force.start()
    card.unplug()
    for source in (emg, force):
        with pytest.raises(DeviceError, match=r"Dev1/ai6, Dev1/ai7"):
            read_for(clock, 0.1, source)
        source.close()
    with pytest.raises(DeviceError, match="Device identifier is invalid"):
        emg.start()
    card.lost = False
    emg.start()
    force.start()
    assert all(numbered(blocks) > 100 for blocks in read_for(clock, 0.2, emg, force))


def test_a_card_whose_clock_stands_still(clock: VirtualClock, card: EmulatedNi, emg: NiEmg) -> None:
    card.clock_error = -1.0 + 1e-9
    emg.start()  # the first sample is there at once
    with pytest.raises(DeviceError, match=r"expected 1000 samples a second, but found none for 1\.0 s"):
        read_for(clock, 1.1, emg)


@pytest.mark.parametrize(
    ("channels", "words"),
    [
        ({"EDC": "Dev9/ai0"}, "Device Specified: Dev9"),
        ({"EDC": "Dev1/ai99"}, "does not exist on this device: Dev1/ai99"),
        ({"EDC": "Dev1/ai0:3"}, "expected 1 channels, but found 4"),
    ],
)
def test_inputs_that_are_not_there(clock: VirtualClock, card: EmulatedNi, channels: dict[str, str], words: str) -> None:
    settings = NiEmgSettings(channels=channels)
    source = open_emg(settings, Around(clock))
    with pytest.raises(DeviceError) as caught:
        source.start()
    assert words in str(caught.value)
    source.close()


def test_before_the_start(emg: NiEmg) -> None:
    for use in (emg.read, lambda: emg.info):
        with pytest.raises(DeviceError, match="Start the source first"):
            use()


def test_without_nidaqmx(clock: VirtualClock, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nidaqmx", None)
    with pytest.raises(DeviceError, match=r'pip install "\.\[daq\]"'):
        open_emg(SETTINGS, Around(clock))


def test_the_real_package_has_what_is_called() -> None:
    """The names of nidaqmx that the source uses, in the package itself."""
    nidaqmx = pytest.importorskip("nidaqmx", reason="nidaqmx is not installed")
    from nidaqmx.constants import AcquisitionType, TerminalConfiguration
    from nidaqmx.error_codes import DAQmxErrors
    from nidaqmx.task.collections import AIChannelCollection

    assert AcquisitionType.CONTINUOUS
    assert TerminalConfiguration.DIFF
    assert TerminalConfiguration.DEFAULT
    assert issubclass(nidaqmx.errors.DaqReadError, nidaqmx.errors.Error)
    assert DAQmxErrors.SAMPLES_NO_LONGER_AVAILABLE == -200279
    assert {"number_of_channels", "timing", "read", "start", "close", "ai_channels"} <= set(dir(nidaqmx.Task))
    assert callable(AIChannelCollection.add_ai_voltage_chan)
