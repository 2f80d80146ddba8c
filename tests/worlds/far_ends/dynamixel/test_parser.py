"""Whatever comes on the bus, whole packets are found, and nothing else is."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.worlds.far_ends.dynamixel.packets import (
    BYTE_GAP_S,
    HEADER,
    POSITION_COMMANDS,
    WATCHDOG_COMMANDS,
    DynamixelFrames,
    Instruction,
    Packet,
    PacketParser,
    packet,
    unstuffed,
)

FRAMES = DynamixelFrames()
NASTY = st.lists(st.sampled_from((0xFF, 0xFD, 0x00, 0x01, 0x55)) | st.integers(0, 255), max_size=40).map(bytes)
PACKETS = st.tuples(st.integers(0, 254), st.integers(1, 0x9F), NASTY)


def parsed(parser: PacketParser, *pieces: bytes, now_s: float = 0.0) -> list[Packet]:
    return [found for piece in pieces for found in parser.feed(piece, now_s)]


def cut(data: bytes, places: list[int]) -> list[bytes]:
    ends = sorted({place % (len(data) + 1) for place in places} | {len(data)})
    return [data[start:end] for start, end in zip([0, *ends], ends, strict=False)]


@given(NASTY)
def test_stuffing_is_undone(body: bytes) -> None:
    whole = packet(1, 0x55, body)
    assert HEADER not in whole[1:-2]
    assert unstuffed(whole[7:-2])[1:] == body


@given(st.lists(PACKETS, min_size=1, max_size=4), st.lists(st.integers(0, 400), max_size=8))
def test_packets_are_found_however_they_are_cut(packets: list[tuple[int, int, bytes]], places: list[int]) -> None:
    data = b"".join(packet(*one) for one in packets)
    assert parsed(PacketParser(), *cut(data, places)) == [Packet(*one, True) for one in packets]


@given(st.binary(max_size=60) | NASTY, st.lists(st.integers(0, 400), max_size=6), PACKETS)
def test_any_bytes_are_read_alike_however_they_are_cut(
    garbage: bytes, places: list[int], one: tuple[int, int, bytes]
) -> None:
    data = garbage + packet(*one) + garbage
    assert parsed(PacketParser(), *cut(data, places)) == parsed(PacketParser(), data)


@given(NASTY | st.binary(max_size=60), PACKETS)
def test_after_a_pause_a_packet_is_found_whatever_came_before(garbage: bytes, one: tuple[int, int, bytes]) -> None:
    parser = PacketParser()
    parsed(parser, garbage)
    assert parsed(parser, packet(*one), now_s=2 * BYTE_GAP_S) == [Packet(*one, True)]


@given(PACKETS, PACKETS, st.integers(5, 80))
def test_a_torn_packet_does_not_swallow_the_next(
    torn: tuple[int, int, bytes], one: tuple[int, int, bytes], keep: int
) -> None:
    begun = packet(*torn)
    begun = begun[: min(keep, len(begun) - 3)]
    assert parsed(PacketParser(), begun + packet(*one))[-1] == Packet(*one, True)


@given(PACKETS, st.data())
def test_a_wrong_bit_never_passes_as_the_packet(one: tuple[int, int, bytes], data: st.DataObject) -> None:
    whole = bytearray(packet(*one))
    whole[data.draw(st.integers(0, len(whole) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    assert not [found for found in parsed(PacketParser(), bytes(whole)) if found.intact]


def test_a_length_that_cannot_be_is_skipped() -> None:
    for length in (b"\x02\x00", b"\x01\x04"):
        assert parsed(PacketParser(), HEADER + b"\x01" + length + packet(1, 1)) == [Packet(1, 1, b"", True)]


def written(address: int, size: int = 4, instruction: int = Instruction.WRITE) -> bytes:
    return packet(1, instruction, address.to_bytes(2, "little") + bytes(size))


SYNC = packet(0xFE, Instruction.SYNC_WRITE, bytes((102, 0, 18, 0, 1)) + bytes(18))
BULK = packet(0xFE, Instruction.BULK_WRITE, bytes((1, 64, 0, 1, 0, 1, 2, 98, 0, 1, 0, 5)))


def test_a_wire_drops_what_writes_the_goal_or_the_watchdog_and_nothing_else() -> None:
    goal, registered, gain = written(116), written(116, instruction=Instruction.REG_WRITE), written(84, 2)
    read = packet(1, Instruction.READ, bytes((116, 0, 4, 0)))
    whole = b"??" + goal + gain + SYNC + registered + read + BULK + goal[:9]
    assert FRAMES.without(whole, POSITION_COMMANDS) == b"??" + gain + read + BULK + goal[:9]
    assert FRAMES.without(whole, WATCHDOG_COMMANDS) == whole.replace(BULK, b"")
    assert FRAMES.without(whole, frozenset()) == whole


@given(st.lists(NASTY | PACKETS.map(lambda one: packet(*one)), max_size=5).map(b"".join))
def test_a_wire_that_drops_nothing_changes_nothing(data: bytes) -> None:
    assert FRAMES.without(data, frozenset()) == data


def test_an_answer_under_another_id_has_a_checksum_that_fits() -> None:
    answers = packet(1, 0x55, b"\0\xff\xff\xfd") + packet(252, 0x55, b"\0")
    assert FRAMES.renamed(answers, 1) == packet(2, 0x55, b"\0\xff\xff\xfd") + packet(0, 0x55, b"\0")
    assert FRAMES.renamed(answers[:-1], 1) == packet(2, 0x55, b"\0\xff\xff\xfd") + packet(252, 0x55, b"\0")[:-1]
