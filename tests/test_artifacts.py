"""Results survive the disk unchanged, and a broken file is one clear error."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from emg2vsa import artifacts
from emg2vsa.artifacts import DamagedResult
from emg2vsa.errors import DataError
from emg2vsa.recordings import Channel, ChannelInfo


def test_round_trip_is_exact(tmp_path: Path) -> None:
    samples = np.array([0.1, np.nan, -np.inf, 5e-324])
    product = (
        Channel("EDC", samples, "V", 1925.9259259259259, -0.5, "mV x 0.001"),
        {"a": (1, None, True), 3: np.array(["S1", "S_new"])},
        np.zeros((0, 3)),
        np.arange(6, dtype=np.int64).reshape(2, 3),
    )
    path = tmp_path / "deep" / "x.result"
    artifacts.save(path, product)
    channel, mapping, empty, whole = artifacts.load(path)
    assert isinstance(channel, Channel)
    assert channel.samples.tobytes() == samples.tobytes()
    assert (channel.name, channel.fs_hz, channel.start_s) == ("EDC", 1925.9259259259259, -0.5)
    assert mapping["a"] == (1, None, True)
    assert mapping[3].tolist() == ["S1", "S_new"]
    assert empty.shape == (0, 3)
    np.testing.assert_array_equal(whole, product[3])


def test_same_product_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        artifacts.save(tmp_path / name, Channel("F", np.arange(4.0), "N", 1.0, 0.0, ""))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize("damage", [lambda b: b[:-9], lambda b: b"", lambda b: b"PK" + b, lambda b: b[:40]])
def test_damaged_file_is_one_clear_error(tmp_path: Path, damage) -> None:
    path = tmp_path / "x.result"
    artifacts.save(path, Channel("F", np.arange(40.0), "N", 1.0, 0.0, ""))
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(DataError, match=r"x\.result: expected a stored result"):
        artifacts.load(path)


def test_a_foreign_type_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.result"
    artifacts.save(path, ChannelInfo("a", None, 1.0, 2))
    write_sealed(path, path.read_bytes().replace(b"emg2vsa.recordings:", b"subprocess.recordi:"))
    with pytest.raises(DamagedResult, match="foreign type"):
        artifacts.load(path)


@pytest.mark.parametrize(
    ("old", "new"), [(b"ChannelInfo", b"ChannelGone"), (b".recordings", b".recordingz"), (b'"fs_hz"', b'"fs_Hz"')]
)
def test_a_result_of_another_version_is_refused(tmp_path: Path, old: bytes, new: bytes) -> None:
    path = tmp_path / "x.result"
    artifacts.save(path, ChannelInfo("a", None, 1.0, 2))
    assert old in path.read_bytes()
    write_sealed(path, path.read_bytes().replace(old, new))
    with pytest.raises(DamagedResult, match="another version's"):
        artifacts.load(path)


def write_sealed(path: Path, data: bytes) -> None:
    """As if it had been saved so."""
    start = artifacts._START
    path.write_bytes(artifacts._MAGIC + artifacts._sum(data[start:]) + data[start:])


def test_every_flipped_bit_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "x.result"
    artifacts.save(path, (Channel("F", np.arange(9.0), "N", 1.0, 0.0, ""), {"a": 1}))
    whole = path.read_bytes()
    for at in range(0, 8 * len(whole), 3):  # each bit of a byte in turn
        path.write_bytes(whole[: at // 8] + bytes([whole[at // 8] ^ 1 << at % 8]) + whole[at // 8 + 1 :])
        with pytest.raises(DamagedResult, match=r"not a result file|a wrong checksum"):
            artifacts.load(path)


def test_equal_results_have_equal_digests(tmp_path: Path) -> None:
    for name, last in (("a", 4.0), ("b", 4.0), ("c", 5.0)):
        artifacts.save(tmp_path / name, np.arange(last))
    first, same, other = (artifacts.digest_of(tmp_path / name) for name in "abc")
    assert first == same != other
    assert len(first) == 32
    (tmp_path / "a").write_bytes(b"")
    with pytest.raises(DamagedResult):
        artifacts.digest_of(tmp_path / "a")


@dataclass(frozen=True)
class Unstorable:
    values: NDArray[np.float64]
    handle: object


def test_what_cannot_be_stored_says_so(tmp_path: Path) -> None:
    assert [f.name for f in fields(Unstorable)] == ["values", "handle"]
    with pytest.raises(TypeError, match="cannot store a object"):
        artifacts.save(tmp_path / "x", Unstorable(np.zeros(1), object()))
    assert list(tmp_path.iterdir()) == []
