"""What the study claims of people: b by specimen, people, clusters, the law, the interpolated profile."""

from __future__ import annotations

from collections.abc import Iterator

from emg2vsa.claims.claim import Claim
from emg2vsa.fits import Fits
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.profiles import Profiles
from emg2vsa.study import Study


def people_claims(
    study: Study, fits: Fits, hypotheses: Hypotheses | None, profiles: Profiles | None
) -> Iterator[Claim]:
    yield from ()
