"""The compiled engine: the envelopes of the plain one, and the bytes of its own loops in Python."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.envelope import envelopes_at, smoother
from emg2vsa.signals.filters import band_pass

compiled = pytest.importorskip("emg2vsa.signals.compiled", exc_type=SettingError)
FS_HZ = 1000.0
KERNELS = ("_lanes", "_cut", "_filter", "_rectify", "_smooth")


def channels(m: int = 2, n: int = 20_000, offset: float = 0.0, dtype: type = np.float64) -> tuple[np.ndarray, ...]:
    return tuple((1e-5 * np.random.default_rng(3).standard_normal((m, n)) + offset).astype(dtype))


def envelopes(rows: tuple[np.ndarray, ...], filters: FilterSettings, first: list[int], counts: list[int]) -> np.ndarray:
    step = 10
    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, step)
    return envelopes_at(rows, np.array(first), np.array(counts), step, band, kernel)


@pytest.mark.parametrize("envelope", ["fir", "rms"])
@pytest.mark.parametrize("phase", ["zero-phase", "causal"])
@pytest.mark.parametrize("band_order", [1, 2, 3])
@pytest.mark.parametrize("m", [1, 2, 5])
def test_both_engines_give_the_same_envelopes(envelope: str, phase: str, band_order: int, m: int) -> None:
    plain = FilterSettings(envelope=envelope, phase=phase, band_order=band_order, band_hz=(20.0, 450.0))  # type: ignore[arg-type]
    first, counts = [0, 3000, 3100, 9000, 12_000, 19_500], [40, 200, 7, 0, 120, 50]  # the first and last at the ends
    wanted, found = (
        envelopes(channels(m), filters, first, counts) for filters in (plain, replace(plain, engine="compiled"))
    )
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13 * wanted.max())


@pytest.mark.parametrize("scale", [1e-300, 1e-160, 1e160])
@pytest.mark.parametrize("envelope", ["fir", "rms"])
def test_scale_offset_and_single_precision_cost_no_digits(envelope: str, scale: float) -> None:
    settings = FilterSettings(envelope=envelope, engine="compiled")  # type: ignore[arg-type]
    own = envelopes(channels(), settings, [5000, 8000], [100, 30])
    scaled = envelopes(tuple(row * scale for row in channels()), settings, [5000, 8000], [100, 30])
    np.testing.assert_allclose(scaled / scale, own, rtol=1e-12)
    single = channels(dtype=np.float32, offset=0.25)
    wide = tuple(row.astype(np.float64) - 0.25 for row in single)
    found, wanted = (envelopes(rows, settings, [5000], [100]) for rows in (single, wide))
    np.testing.assert_allclose(found, wanted, rtol=1e-9)


@pytest.mark.parametrize("envelope", ["fir", "rms"])
def test_compiled_loops_give_the_bytes_of_their_python(envelope: str, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = FilterSettings(envelope=envelope, engine="compiled", band_hz=(60.0, 450.0))  # type: ignore[arg-type]
    asked = channels(n=3000), settings, [900, 1400], [20, 31]
    found = envelopes(*asked)
    for name in KERNELS:
        monkeypatch.setattr(compiled, name, getattr(compiled, name).py_func)
    assert found.tobytes() == envelopes(*asked).tobytes()


def test_the_windows_beside_change_nothing() -> None:
    settings = FilterSettings(engine="compiled")
    first, counts = [3000, 5000, 8000, 11_000], [200, 90, 150, 10]
    together = np.split(envelopes(channels(), settings, first, counts), np.cumsum(counts)[:-1], axis=1)
    alone = [envelopes(channels(), settings, [i], [n]) for i, n in zip(first, counts, strict=True)]
    for one, other in zip(together, alone, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13)


def test_without_numba_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "emg2vsa.signals.compiled")
    monkeypatch.setitem(sys.modules, "numba", None)
    with pytest.raises(SettingError, match=r"filters.engine: expected the package numba.*\"\.\[flow\]\""):
        envelopes(channels(), FilterSettings(engine="compiled"), [5000], [10])
