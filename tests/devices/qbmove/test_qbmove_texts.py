"""The text of GET_INFO and the list of parameters, read from bytes written by hand."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.devices.qbmove.info import Parameter, decode_parameters, parse_info
from emg2vsa.errors import DeviceError

INFO = """
Firmware version: QBADV v6.1.6.

DEVICE INFO
ID: 3
Number of sensors: 3
PWM Limit: 100

MOTOR INFO
Motor references - Position: 0 0
Motor enabled: NO

MEASUREMENTS INFO
Sensor value:
1 -> -8
2 -> 16
3 -> 0
Voltage (mV): 23812
Current 1 (mA): 0
Current 2 (mA): 0

DEVICE PARAMETERS
PID Controller:
P -> -0.099991
I -> 0.000000
D -> -0.799988
Current PID Controller:
P -> 3.000000
I -> 0.000000
D -> 0.000000

Startup activation: NO
Input mode: USB
Control Mode: Position and current
Sensor resolution:
1 -> 1
2 -> 1
3 -> 1
Measurement Offset:
1 -> 0
2 -> 0
3 -> 0
Measurement Multiplier:
1 -> 1.000000
2 -> 1.000000
3 -> 1.000000
Position limit active: 1
Position limit motor 1: inf -> -15000  sup -> 14000
Position limit motor 2: inf -> -13000  sup -> 15000
Max stiffness: 2874
Current limit: 1500
Max pwm rate: 12
debug: 3671
""".replace("\n", "\r\n")


def test_info_is_read() -> None:
    info = parse_info(INFO, "line")
    assert (info.firmware, info.device_id, info.max_stiffness_ticks) == ("QBADV v6.1.6", 3, 2874)
    assert info.position_limits_ticks == ((-15000, 14000), (-13000, 15000))
    assert (info.control_mode, info.input_mode, info.resolutions) == ("Position and current", "USB", (1, 1, 1))
    assert (info.current_limit_ma, info.max_pwm_rate, info.voltage_mv) == (1500, 12, 23812)
    assert parse_info(INFO.replace("Max pwm rate: 12\r\n", ""), "line").max_pwm_rate is None


def test_two_readings_are_equal_when_only_the_supply_differs() -> None:
    assert parse_info(INFO, "line") == parse_info(INFO.replace("23812", "23790"), "line")
    assert parse_info(INFO, "line") != parse_info(INFO.replace("2874", "2875"), "line")


@pytest.mark.parametrize(
    "text", ["", "\r\nFirmware version: QBMMP v6.1.0.\r\n", INFO.replace("Max stiff", "Max sti\0f")]
)
def test_an_absent_line_is_named(text: str) -> None:
    with pytest.raises(
        DeviceError, match=r"line, info: expected a line '(Firmware version|.*Position.*|Max stiffness)"
    ):
        parse_info(text, "line")


@given(st.text(max_size=200))
def test_any_other_text_is_refused_in_words(text: str) -> None:
    with pytest.raises(DeviceError):
        parse_info(text, "line")


def slot(kind: int, count: int, values: bytes, text: bytes) -> bytes:
    return (bytes((kind, count)) + values + text).ljust(50, b"\0")


SLOTS = b"\x04" + b"".join(
    (
        slot(2, 1, b"\x05", b"1 - Device ID:"),
        slot(7, 3, struct.pack(">3f", 0.5, 0, -0.25), b"2 - Position PID [P, I, D]:"),
        slot(0, 1, b"\x01", b"3 - Startup Activation: YES\0\3"),
        slot(5, 4, struct.pack(">4i", -15000, 15000, -15000, 15000), b"4 - Pos. limits [inf, sup]:"),
    )
)


def test_slots_are_read() -> None:
    found = decode_parameters(SLOTS + b"0 -> Usb\n", "line")
    assert found == {
        1: Parameter(1, "Device ID", (5,), "B"),
        2: Parameter(2, "Position PID [P, I, D]", (0.5, 0.0, -0.25), "f"),
        3: Parameter(3, "Startup Activation", (1,), "B"),
        4: Parameter(4, "Pos. limits [inf, sup]", (-15000, 15000, -15000, 15000), "i"),
    }


@pytest.mark.parametrize(
    "payload", [b"\x01", b"\x02" + SLOTS[1:51], b"\x01" + slot(99, 1, b"", b""), b"\x01" + slot(7, 13, b"", b"")]
)
def test_a_slot_that_makes_no_sense_is_refused(payload: bytes) -> None:
    with pytest.raises(DeviceError, match="parameter"):
        decode_parameters(payload, "line")


@pytest.mark.parametrize(("count", "fits"), [(47, True), (48, True), (49, False)])
def test_values_may_fill_their_slot_of_50_bytes_to_the_last(count: int, fits: bool) -> None:
    payload = b"\x01" + bytes([0, count]) + bytes(range(count)) + bytes(48 - min(count, 48))
    if fits:
        assert decode_parameters(payload, "line")[1].values == tuple(range(count))
    else:
        with pytest.raises(DeviceError, match="parameter 1: expected a slot of type 0 to 8 within 50 bytes"):
            decode_parameters(payload, "line")


@given(st.binary(min_size=1, max_size=800))
def test_any_bytes_are_read_or_refused(payload: bytes) -> None:
    try:
        found = decode_parameters(payload, "line")
    except DeviceError:
        return
    assert len(found) == payload[0]
