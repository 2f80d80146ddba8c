"""A share of the recordings and runs of a study, for one of several processes that write the same results at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from emg2vsa.pipeline.fingerprint import digest
from emg2vsa.pipeline.stage_order import stage, with_needs

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign


@dataclass(frozen=True)
class Shard:
    """Share ``number`` of ``of``, from 1. All steps of one participant are in one share, and all steps of one run."""

    number: int
    of: int

    @property
    def name(self) -> str:
        """As in the names of its files."""
        return f"shard-{self.number}-of-{self.of}"

    def has(self, campaign: Campaign, name: str, item: str) -> bool:
        """Whether a step of the stage ``name`` is in this share; the same on every computer, whatever else there is."""
        return int(digest(group_of(campaign, name, item)), 16) % self.of == self.number - 1


def group_of(campaign: Campaign, name: str, item: str) -> str:
    """The participant, or the run, that the step belongs to."""
    match stage(name).per:
        case "recording":
            return campaign.recordings[item].participant
        case "mounting":
            return campaign.run_of_mounting[item]
        case _:
            return item


def shared_stages(stages: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the stages that run per recording or run, with all that they need."""
    return tuple(one for one in with_needs({one for one in stages if stage(one).per != "study"}) if one in stages)
