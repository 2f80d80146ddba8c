"""What the study claims of the rig's presses: areas, spread rates, their order, and conditions."""

from __future__ import annotations

from collections.abc import Iterator

from emg2vsa.claims.claim import Claim
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.settings import ClaimSettings


def rig_claims(table: RunTable, mounting_sd: float, margins: ClaimSettings) -> Iterator[Claim]:
    yield from ()
