"""Which claims survive together."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.statistics.multiplicity import claim_family


def test_holm_over_named_claims() -> None:
    """.0391, the paper's worst p, does not survive beside two others that are hardly smaller."""
    found = claim_family({"worst pair": 0.0391, "a": 0.02, "b": 0.001, "untested": np.nan})
    np.testing.assert_allclose(found.p_holm, [0.0400, 0.0400, 0.003, np.nan], rtol=1e-12)
    assert found.survives == (True, True, True, None)
    found = claim_family({"worst pair": 0.0391, "a": 0.03, "b": 0.001})
    assert found.survives == (False, False, True)
    assert found.p_holm[0] == found.p_holm[1] == pytest.approx(0.06)


def test_no_claim_is_an_empty_family() -> None:
    assert claim_family({}).survives == ()


@pytest.mark.parametrize("p", [-0.1, 1.2, np.inf])
def test_what_is_no_p_is_refused(p: float) -> None:
    with pytest.raises(SettingError, match="claims, a"):
        claim_family({"a": p})


@pytest.mark.parametrize("alpha", [0.0, 1.0, np.nan])
def test_what_is_no_level_is_refused(alpha: float) -> None:
    with pytest.raises(SettingError, match="alpha"):
        claim_family({"a": 0.5}, alpha)


def test_error_of_the_family() -> None:
    rng = np.random.default_rng(0)
    wrong = [any(claim_family(dict(zip("abcdefg", rng.random(7), strict=True))).survives) for _ in range(2000)]
    assert 0.035 < np.mean(wrong) < 0.065
