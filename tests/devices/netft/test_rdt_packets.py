"""Bytes of ATI's RDT, from the manuals 9620-05 and 9610-05."""

from __future__ import annotations

import pytest

from emg2vsa.devices.netft import RDT_PORT
from emg2vsa.devices.netft.box import Command, Record, parse_records, parse_request, record_bytes, request_bytes, steps

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
