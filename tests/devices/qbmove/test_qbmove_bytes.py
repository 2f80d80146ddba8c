"""The driver against a script: each byte pair must be sent and answered, in order, and none may be left over."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove import Generation
from emg2vsa.devices.qbmove.driver import Qbmove, Ticks
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.devices.serial_line import LoopbackLine
from emg2vsa.errors import DeviceError

IS_ACTIVE, ACTIVE, INACTIVE = "3a3a 01 02 81 81", "3a3a 01 03 81 03 82", "3a3a 01 03 81 00 81"
ACTIVATE, DEACTIVATE = "3a3a 01 03 80 03 83", "3a3a 01 03 80 00 80"


@contextmanager
def scripted(*pairs: tuple[str, str], generation: Generation = "v6", model: str = "maker-pro") -> Iterator[Qbmove]:
    left = [(bytes.fromhex(sent), bytes.fromhex(answer)) for sent, answer in pairs]

    def device(data: bytes) -> bytes:
        assert left, f"nothing more was to be sent, but {data.hex(' ')}"
        sent, answer = left.pop(0)
        assert data.hex(" ") == sent.hex(" ")
        return answer

    yield Qbmove(LoopbackLine("script", device), 1, generation=generation, model=model, clock=VirtualClock())
    assert not left, f"left over: {left}"


def test_the_script_catches_what_is_left_over() -> None:
    with pytest.raises(AssertionError, match="left over"), scripted((IS_ACTIVE, ACTIVE)):
        pass


PING = "3a3a 01 02 00 00"
MEASURED = "3a3a 01 02 84 84", "3a3a 01 08 84 09c4 fe0c 03e8 50"


@pytest.mark.parametrize(
    ("pair", "generation", "ask", "told"),
    [
        ((PING, PING), "v6", Qbmove.answers, True),
        ((PING, "3a3a 01 06 00 00980001 99"), "v7", Qbmove.answers, True),
        ((PING, "3a3a 01 06 00 00980001 99"), "v7", Qbmove.serial_number, "0009961473"),
        (MEASURED, "v6", Qbmove.ticks, Ticks(2500, -500, 1000)),
        (MEASURED, "v6", Qbmove.measurements, Measurements((27.4658203125, -5.4931640625), 10.986328125)),
        # halfway between the motors
        (MEASURED, "v6", Qbmove.position_deg, 1000 * DEG_PER_TICK),
        (("3a3a 01 02 85 85", "3a3a 01 06 85 0064 ff9c 82"), "v6", Qbmove.currents_a, (0.1, -0.1)),
        # garbage before a reply costs nothing
        ((IS_ACTIVE, "3a ff 3a3a 01 08 84 3a" + ACTIVE), "v6", Qbmove.is_active, True),
    ],
)
def test_what_is_asked_and_told(
    pair: tuple[str, str], generation: Generation, ask: Callable[[Qbmove], object], told: object
) -> None:
    with scripted(pair, generation=generation) as device:
        assert ask(device) == told
        assert device.counts.lost == 0


def test_deactivate_insists() -> None:
    with scripted((DEACTIVATE, ""), (IS_ACTIVE, ACTIVE), (DEACTIVATE, ""), (IS_ACTIVE, INACTIVE)) as device:
        device.deactivate()


def test_the_context_ends_with_motors_off_whatever_happens() -> None:
    script = scripted((DEACTIVATE, ""), (IS_ACTIVE, INACTIVE))
    with pytest.raises(KeyboardInterrupt), script as device, device:
        raise KeyboardInterrupt


@pytest.mark.parametrize("answer", [IS_ACTIVE, "", "3a3a 01 03 81 03 83", "ff 3a", ACTIVE[:-3]])
def test_a_lost_or_corrupt_reply_is_asked_for_again_after_a_flush(answer: str) -> None:
    with scripted((IS_ACTIVE, answer), ("01" + "00" * 127, ""), (IS_ACTIVE, ACTIVE)) as device:
        assert device.is_active()
        assert device.counts.lost == 1
        assert device.counts.corrupt == int(answer == "3a3a 01 03 81 03 83")
        assert device.counts.requests == 2


def test_silence_is_told_after_three_attempts() -> None:
    flush = ("01" + "00" * 127, "")
    silent = [(IS_ACTIVE, ""), flush, (IS_ACTIVE, ""), flush, (IS_ACTIVE, "")]
    with (
        scripted(*silent) as device,
        pytest.raises(
            DeviceError, match="script, qbmove 1: expected a reply to GET_ACTIVATE, but found none in 3 atte"
        ),
    ):
        device.is_active()


def test_nothing_is_commanded_before_the_limits_are_known() -> None:
    with scripted() as device, pytest.raises(DeviceError, match="Call activate first"):
        device.command(0.0, 0.5)
    with scripted() as device, pytest.raises(DeviceError, match="Call activate first"):
        device.move_motors((0.0, 0.0))
