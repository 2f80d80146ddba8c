"""How far skin goes along with a contact that is pulled."""

import numpy as np
import pytest

from casr.dome.pull import share_pulled


@pytest.mark.parametrize("x", [0.1, 0.7, 1.0, 1.3, 4.0])
def test_skin_goes_along_with_a_contact_that_grows(x: float) -> None:
    """Against the sum over growing discs, each of which takes the skin inside along and pulls at that around it."""
    radii = (np.arange(200_000) + 0.5) / 200_000
    along = np.where(radii >= x, 1.0, 2 / np.pi * np.arcsin(np.minimum(radii / x, 1.0)))
    assert share_pulled(2 * x, 2.0, 1e12) == pytest.approx(np.mean(3 * radii**2 * along), rel=1e-5)


def test_skin_at_the_clamp_stays_and_the_middle_goes_all_the_way() -> None:
    np.testing.assert_array_equal(share_pulled(np.array([0.0, 9.0, 12.0]), 3.0, 9.0), [1.0, 0.0, 0.0])
    assert share_pulled(6.0, 3.0, 9.0) == pytest.approx(share_pulled(6.0, 3.0, 1e12) / 2)
    assert share_pulled(0.0, 0.0, 9.0) == 1
