"""The emulated qbmove of generation 7 against byte pairs that its public client sends and expects."""

from __future__ import annotations

import pytest

from emg2vsa.devices.clock import VirtualClock
from tests.devices.qbmove.firmware_v7 import ADVANCED_V7, MAKER_PRO_V7, QbmoveFirmwareV7


class Free:
    """A shaft that stays halfway between its motors."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return sum(motors_rad) / 2


@pytest.fixture
def device() -> QbmoveFirmwareV7:
    return QbmoveFirmwareV7(ADVANCED_V7, Free(), VirtualClock())


@pytest.mark.parametrize(
    ("request_hex", "reply_hex"),
    [
        ("3a3a 01 02 00 00", "3a3a 01 06 00 00980001 99"),
        ("3a3a 01 02 03 03", "3a3a 01 03 03 01 02"),
        ("3a3a 01 02 04 04", "3a3a 01 03 04 01 05"),
        ("3a3a 01 02 05 05", "3a3a 01 03 05 01 04"),
        ("3a3a 01 02 0a 0a", "3a3a 01 03 0a 01 0b"),
        ("3a3a 01 02 01 01", "3a3a 01 03 01 01 00"),
        ("3a3a 01 06 0c 000d 03e8 ea", "3a3a 01 03 0c 01 0d"),
        ("3a3a 01 05 0c 0001 05 08", "3a3a 05 03 0c 01 0d"),
        ("3a3a 01 03 80 03 83", ""),
        ("3a3a 01 06 82 09c4 fe0c bd", ""),
        ("3a3a 01 02 84 84", "3a3a 01 08 84 0000 0000 0000 84"),
        ("3a3a 01 02 00 01", ""),
    ],
)
def test_bytes_in_bytes_out(device: QbmoveFirmwareV7, request_hex: str, reply_hex: str) -> None:
    assert device(bytes.fromhex(request_hex)).hex(" ") == bytes.fromhex(reply_hex).hex(" ")


@pytest.mark.parametrize("request_hex", ["3a3a 01 04 06 0000 06", "3a3a 01 04 0c 0000 0c"], ids=["info", "parameters"])
def test_long_replies_count_their_length_in_32_bytes_and_check_all_of_it(
    device: QbmoveFirmwareV7, request_hex: str
) -> None:
    reply = device(bytes.fromhex(request_hex))
    assert len(reply) - 4 == 32 * reply[3]
    checksum = 0
    for byte in reply[4:]:
        checksum ^= byte
    assert checksum == 0
    assert any(reply[4 + 200 :])


def test_a_set_parameter_acts_at_once(device: QbmoveFirmwareV7) -> None:
    device(bytes.fromhex("3a3a 01 06 0c 000d 03e8 ea"))
    assert device(bytes.fromhex("3a3a 01 04 0c 0000 0c"))[4 + 604 : 4 + 606] == b"\x03\xe8"


def test_inputs_are_not_negated_in_the_advanced() -> None:
    clock = VirtualClock()
    device = QbmoveFirmwareV7(ADVANCED_V7, Free(), clock)
    device(bytes.fromhex("3a3a 01 06 82 09c4 fe0c bd"))
    clock.sleep_until(0.01)
    assert device(bytes.fromhex("3a3a 01 02 83 83")) == bytes.fromhex("3a3a 01 06 83 09c4 fe0c bc")


def test_zero_is_where_everything_stands() -> None:
    device = QbmoveFirmwareV7(MAKER_PRO_V7, Free(), VirtualClock(), motors_rad=(0.5, 0.25))
    assert device(bytes.fromhex("3a3a 01 02 84 84")) != bytes.fromhex("3a3a 01 08 84 0000 0000 0000 84")
    device(bytes.fromhex("3a3a 01 02 01 01"))
    assert device(bytes.fromhex("3a3a 01 02 84 84")) == bytes.fromhex("3a3a 01 08 84 0000 0000 0000 84")
