"""What the study claims of the stiffness of the new specimen."""

from __future__ import annotations

from collections.abc import Iterator

from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.claims.claim import Claim
from emg2vsa.settings import ClaimSettings


def kappa_claims(found: CalibrationResults, own: str, margins: ClaimSettings) -> Iterator[Claim]:
    yield from ()
