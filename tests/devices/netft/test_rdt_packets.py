"""What ATI's boxes say: datagrams of raw data, status words, and the configuration page."""

from __future__ import annotations

import pytest

from emg2vsa.devices.netft import RDT_PORT
from emg2vsa.devices.netft.box import (
    Command,
    Record,
    axia_status,
    fetch_config,
    netbox_status,
    parse_config,
    parse_records,
    parse_request,
    record_bytes,
    request_bytes,
    steps,
)
from emg2vsa.errors import DeviceError

REQUESTS = [
    (Command.STOP, 0, "1234 0000 00000000"),
    (Command.STREAM, 0, "1234 0002 00000000"),
    (Command.STREAM, 1, "1234 0002 00000001"),
    (Command.BUFFERED, 0x01020304, "1234 0003 01020304"),
    (Command.BIAS, 0, "1234 0042 00000000"),
]
RECORDS = [
    (
        Record(1, 7000, 0, (1_000_000, -1_000_000, 0, 1, -1, 2**31 - 1)),
        "00000001 00001b58 00000000 000f4240 fff0bdc0 00000000 00000001 ffffffff 7fffffff",
    ),
    (
        Record(2**32 - 1, 2**32 - 1, 0x80020000, (-(2**31), 0, 0, 0, 0, 256)),
        "ffffffff ffffffff 80020000 80000000 00000000 00000000 00000000 00000000 00000100",
    ),
]


@pytest.mark.parametrize(("command", "count", "wire"), REQUESTS)
def test_requests(command, count, wire):
    assert request_bytes(command, count) == bytes.fromhex(wire)
    assert parse_request(bytes.fromhex(wire)) == (command, count)


@pytest.mark.parametrize(("record", "wire"), RECORDS)
def test_records(record, wire):
    assert len(bytes.fromhex(wire)) == 36
    assert record_bytes(record) == bytes.fromhex(wire)
    assert parse_records(bytes.fromhex(wire)) == [record]


def test_a_datagram_of_many_records():
    wire = bytes.fromhex("".join(wire for _, wire in RECORDS))
    assert parse_records(wire) == [record for record, _ in RECORDS]


@pytest.mark.parametrize("length", [1, 35, 37, 71])
def test_a_cut_datagram_is_no_record(length):
    assert parse_records(bytes(length)) == []


@pytest.mark.parametrize("wire", ["", "1235 0002 00000000", "1234 0002 000000", "1234 0002 00000000 00"])
def test_what_is_no_request(wire):
    assert parse_request(bytes.fromhex(wire)) is None


def test_the_port_is_atis():
    assert RDT_PORT == 49152


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [(1, 2, 1), (2, 1, -1), (2**32 - 1, 0, 1), (0, 2**32 - 1, -1), (2**32 - 2, 3, 5), (7, 7, 0)],
)
def test_steps_wrap(before, after, expected):
    assert steps(before, after) == expected


NETBOX = [
    (0x00000000, (), ()),
    (0x80010000, (), ("monitor condition latched",)),
    (0x80020000, ("transducer saturation or A/D error",), ()),
    (0x80030000, ("transducer saturation or A/D error",), ("monitor condition latched",)),
    (0x80000004, ("temperature out of range",), ()),
    (0xC0000000, ("CPU or RAM error",), ()),
    (0x80000300, ("excitation current too high", "excitation current too low"), ()),
    (0x80000000, ("an error without a cause",), ()),
    (0x80000001, ("status bit 0",), ()),
    (0x00100000, ("RDT error",), ()),
]
AXIA = [
    (0x00000000, ()),
    (0x80000001, ("temperature out of range",)),
    (0x80000004, ("broken gauge",)),
    (0x88000000, ("gauge out of range",)),
    (0x90000000, ("force is simulated",)),
    (0xC0000000, ("force or torque out of range",)),
    (0x80010000, ("status bit 16",)),
]


@pytest.mark.parametrize(("word", "faults", "warnings"), NETBOX)
def test_net_ft_box(word, faults, warnings):
    status = netbox_status(word)
    assert (status.code, status.faults, status.warnings) == (word, faults, warnings)


@pytest.mark.parametrize(("word", "faults"), AXIA)
def test_ethernet_axia(word, faults):
    status = axia_status(word)
    assert (status.code, status.faults, status.warnings) == (word, faults, ())


NETBOX_BITS = {
    30: "CPU or RAM", 29: "digital board", 28: "analog board", 27: "serial link", 26: "program verify",
    25: "halted by configuration", 24: "settings validation", 23: "configuration and calibration", 22: "network",
    21: "CAN", 20: "RDT", 19: "EtherNet/IP", 18: "DeviceNet", 17: "transducer saturation or A/D", 14: "watchdog",
    13: "stack", 12: "EEPROM", 11: "flash", 10: "analog watchdog", 9: "excitation current too high",
    8: "excitation current too low", 7: "analog ground", 6: "supply too high", 5: "supply too low",
    4: "serial data not available", 3: "reference voltage", 2: "temperature", 1: "HTTP",
}  # fmt: skip
"""As netft-cpp decodes them."""


@pytest.mark.parametrize(("bit", "name"), NETBOX_BITS.items())
def test_each_bit_of_the_net_ft_box_has_its_name(bit: int, name: str) -> None:
    assert netbox_status(1 << 31 | 1 << bit).faults[0].startswith(name)


TAGS = {
    "runrate": "7000",
    "cfgcalsn": "FT12345",
    "scfgfu": "N",
    "scfgtu": "Nm",
    "cfgcpf": "1000000",
    "cfgcpt": "1000000",
    "comrdte": "Enabled",
    "comrdtrate": "100",
}


def page(**changes: str | None) -> bytes:
    tags = {tag: text for tag, text in (TAGS | changes).items() if text is not None}
    inner = "".join(f"<{tag}>{text}</{tag}>\n" for tag, text in tags.items())
    return f'<?xml version="1.0"?><netft>\n{inner}</netft>'.encode()


def test_a_live_net_ft_box():
    config = parse_config(page())
    assert config.n_per_count == config.nm_per_count == 1e-6
    assert config.rate_hz == 100
    assert (config.axia, config.product, config.calibration_serial) == (False, "", "FT12345")


@pytest.mark.parametrize(
    ("told", "force_n"),
    [("145;145;290;5;5;5", (145, 145, 290)), ("145;145;290;5;5;5;", (145, 145, 290)), ("145;145", None), ("", None),
     ("0;1;1;1;1;1", None), ("a;1;1;1;1;1", None)],
)  # fmt: skip
def test_the_rating_of_the_transducer(told: str, force_n: tuple[float, float, float] | None):
    rating = parse_config(page(cfgmr=told)).rating
    assert (rating and rating.force_n) == force_n
    pounds = parse_config(page(cfgmr="10;10;20;1;1;1", scfgfu="lbf")).rating
    assert pounds is not None
    assert pounds.force_n[2] == pytest.approx(88.96, abs=0.01)


def test_an_ethernet_axia():
    config = parse_config(page(prodname="Ethernet Axia", runrate=None))
    assert config.axia


@pytest.mark.parametrize(
    ("unit", "counts", "newton"),
    [
        ("N", "1000", 1e-3),
        ("kN", "1000", 1.0),
        ("lbf", "1", 4.4482216152605),
        ("klbf", "1000", 4.4482216152605),
        ("kgf", "10", 0.980665),
        ("gf", "1", 0.00980665),
    ],
)
def test_force_units(unit, counts, newton):
    assert parse_config(page(scfgfu=unit, cfgcpf=counts)).n_per_count == pytest.approx(newton, rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "newton_metre"),
    [
        ("Nm", 1.0),
        ("N-m", 1.0),
        ("Nmm", 1e-3),
        ("N-mm", 1e-3),
        ("kNm", 1e3),
        ("lbf-in", 0.1129848290276167),
        ("lbf-ft", 1.3558179483314004),
        ("kgf-cm", 0.0980665),
    ],
)
def test_torque_units(unit, newton_metre):
    assert parse_config(page(scfgtu=unit, cfgcpt="1")).nm_per_count == pytest.approx(newton_metre, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"cfgcpf": None}, "cfgcpf"),
        ({"cfgcpf": "0"}, "cfgcpf"),
        ({"cfgcpt": "nan"}, "cfgcpt"),
        ({"cfgcpt": "many"}, "many"),
        ({"scfgfu": "stone"}, "stone"),
        ({"scfgtu": None}, "scfgtu"),
        ({"comrdtrate": None}, "comrdtrate"),
        ({"comrdte": "Disabled"}, "Enable RDT"),
    ],
)
def test_a_page_that_makes_no_sense(changes, named):
    with pytest.raises(DeviceError, match=named):
        parse_config(page(**changes))


def test_no_xml():
    with pytest.raises(DeviceError, match="as XML"):
        parse_config(b"<netft><cfgcpf>")


def test_nobody_there():
    with pytest.raises(DeviceError, match=r"127\.0\.0\.1:1/netftapi2\.xml"):
        fetch_config("127.0.0.1", 1, timeout_s=0.5)
