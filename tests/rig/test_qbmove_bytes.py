"""The driver against a script: each byte pair must be sent and answered, in order, and none may be left over."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from emg2vsa.errors import DeviceError
from emg2vsa.rig.clock import VirtualClock
from emg2vsa.rig.qbmove import Measurements, Qbmove
from emg2vsa.rig.qbmove_dialects import Generation
from emg2vsa.rig.qbmove_packets import Command
from emg2vsa.rig.transport import LoopbackLine

IS_ACTIVE, ACTIVE, INACTIVE = "3a3a 01 02 81 81", "3a3a 01 03 81 03 82", "3a3a 01 03 81 00 81"
ACTIVATE, DEACTIVATE = "3a3a 01 03 80 03 83", "3a3a 01 03 80 00 80"
STORE, V6_DONE, V6_FAILED = "3a3a 01 02 03 03", "3a3a 01 02 01 01", "3a3a 01 02 00 00"


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


def test_ping() -> None:
    with scripted(("3a3a 01 02 00 00", "3a3a 01 02 00 00")) as device:
        assert device.ping()


def test_ping_of_generation_7_brings_a_serial_number() -> None:
    with scripted(("3a3a 01 02 00 00", "3a3a 01 06 00 00980001 99"), generation="v7") as device:
        assert device.ping()


def test_measurements() -> None:
    with scripted(("3a3a 01 02 84 84", "3a3a 01 08 84 09c4 fe0c 03e8 50")) as device:
        assert device.measurements() == Measurements(2500, -500, 1000)


def test_the_position_is_halfway_between_the_motors() -> None:
    with scripted(("3a3a 01 02 84 84", "3a3a 01 08 84 09c4 fe0c 03e8 50")) as device:
        assert device.position_ticks() == 1000


def test_currents_come_from_133() -> None:
    with scripted(("3a3a 01 02 85 85", "3a3a 01 06 85 0064 ff9c 82")) as device:
        assert device.currents_ma() == (100, -100)


@pytest.mark.parametrize(
    ("generation", "model", "read"),
    [
        ("v6", "maker-pro", (2500, -500)),
        ("v6", "advanced", (-2500, 500)),
        ("v7", "maker-pro", (2500, -500)),
        ("v7", "advanced", (2500, -500)),
    ],
)
def test_inputs_are_turned_back_for_the_advanced_of_generation_6(
    generation: Generation, model: str, read: tuple[int, int]
) -> None:
    pair = ("3a3a 01 02 83 83", "3a3a 01 06 83 09c4 fe0c bc")
    with scripted(pair, generation=generation, model=model) as device:
        assert device.inputs() == read


def test_deactivate_reads_back() -> None:
    with scripted((DEACTIVATE, ""), (IS_ACTIVE, INACTIVE)) as device:
        device.deactivate()


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


def test_garbage_before_a_reply_costs_nothing() -> None:
    with scripted((IS_ACTIVE, "3a ff 3a3a 01 08 84 3a" + ACTIVE)) as device:
        assert device.is_active()
        assert device.counts.lost == 0


def test_silence_is_told_after_three_attempts() -> None:
    flush = ("01" + "00" * 127, "")
    silent = [(IS_ACTIVE, ""), flush, (IS_ACTIVE, ""), flush, (IS_ACTIVE, "")]
    with (
        scripted(*silent) as device,
        pytest.raises(DeviceError, match=r"script, qbmove 1: wanted a reply to GET_ACTIVATE; found none in 3 attempts"),
    ):
        device.is_active()


def test_store_asks_once_and_hears_both_answers() -> None:
    with scripted((IS_ACTIVE, INACTIVE), (STORE, V6_DONE)) as device:
        device.store_parameters()
    with scripted((IS_ACTIVE, INACTIVE), (STORE, V6_FAILED)) as device, pytest.raises(DeviceError, match="a failure"):
        device.store_parameters()
    with scripted((IS_ACTIVE, INACTIVE), (STORE, "")) as device, pytest.raises(DeviceError, match="no answer"):
        device.store_parameters()
    with scripted((IS_ACTIVE, INACTIVE), (STORE, "3a3a 01 03 03 01 02"), generation="v7") as device:
        device.store_parameters()


def test_parameters_change_with_motors_off_only() -> None:
    for change in (
        lambda device: device.store_parameters(),
        lambda device: device.set_parameter(13, 1000),
        lambda device: device.change_id(5),
    ):
        with scripted((IS_ACTIVE, ACTIVE)) as device, pytest.raises(DeviceError, match="motors off; found motors on"):
            change(device)


def test_a_new_id_of_generation_6_is_confirmed_by_the_old_one() -> None:
    with scripted(
        (IS_ACTIVE, INACTIVE),
        ("3a3a 01 05 0c 0001 05 08", ""),
        (STORE, V6_DONE),
        ("3a3a 05 02 00 00", "3a3a 05 02 00 00"),
    ) as device:
        device.change_id(5)
        assert device.device_id == 5


def test_a_new_id_of_generation_7_is_confirmed_by_the_new_one() -> None:
    with scripted(
        (IS_ACTIVE, INACTIVE),
        ("3a3a 01 05 0c 0001 05 08", "3a3a 05 03 0c 01 0d"),
        ("3a3a 05 02 03 03", "3a3a 05 03 03 01 02"),
        ("3a3a 05 02 00 00", "3a3a 05 06 00 00980001 99"),
        generation="v7",
    ) as device:
        device.change_id(5)


MAINTENANCE = [
    (4, "STORE_DEFAULT_PARAMS"),
    (5, "RESTORE_PARAMS"),
    (9, "BOOTLOADER"),
    (10, "INIT_MEM"),
    (11, "CALIBRATE"),
]


@pytest.mark.parametrize(("code", "name"), MAINTENANCE)
def test_maintenance_needs_its_flag(code: int, name: str) -> None:
    with scripted() as device, pytest.raises(DeviceError, match=name):
        device.maintain(Command(code))
    with scripted((f"3a3a 01 02 {code:02x} {code:02x}", "3a3a 07 02 01 01")) as device:
        device.maintain(Command(code), allow=True)


def test_nothing_is_commanded_before_the_limits_are_known() -> None:
    with scripted() as device, pytest.raises(DeviceError, match="Call activate first"):
        device.set_position_stiffness(0, 1500)
    with scripted() as device, pytest.raises(DeviceError, match="Call activate first"):
        device.set_inputs(0, 0)


@pytest.mark.parametrize("device_id", [0, -1, 256])
def test_an_id_that_cannot_be_is_refused(device_id: int) -> None:
    with pytest.raises(DeviceError, match="1 to 255"):
        Qbmove(LoopbackLine("script", lambda data: b""), device_id, clock=VirtualClock())
