"""Every claim that a study makes of its rig; the report and all paths of analysis judge the same ones."""

from __future__ import annotations

from collections.abc import Iterator

from emg2vsa.claims.claim import Claim
from emg2vsa.claims.kappa import Laws, kappa_claims
from emg2vsa.claims.rig import rig_claims
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.study import Study


def claims_on_rig(study: Study, table: RunTable | None, laws: Laws | None) -> Iterator[Claim]:
    """Claims on the scores of ``table``, and on what ``laws`` give of them; a part that is None has no claims."""
    if table is not None:
        yield from rig_claims(table, study.calibration.mounting_sd_percent / 100, study.claims)
    if laws is not None:
        hexagons = study.scoring.recipe_of("paper").area_rule in ("paper", "hexagon")
        yield from kappa_claims(laws, study.scoring.algorithm, study.claims, hexagons=hexagons)
