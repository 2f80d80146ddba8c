"""Whether the data were simulated, as far as a report can know: it sees a table of the truth, or it sees none."""

from __future__ import annotations

from dataclasses import dataclass

from emg2vsa.report.inputs import StudyResults


@dataclass(frozen=True)
class Origin:
    """``strong`` and ``text`` open the report, ``source`` is what tables call the data, ``kind`` the colour."""

    kind: str
    strong: str
    text: str
    source: str


_SIMULATED = Origin(
    "usable",
    "These results come from a simulation.",
    "Every recording was synthesised from chosen curves plus noise. Numbers on this page show that the method finds "
    "what was put in; they are no evidence about people, and agreement with the paper is not a replication.",
    "simulated data",
)
_PERHAPS = Origin(
    "repeat",
    "These data may be simulated.",
    "The study file has a [simulation] table, but no table of simulated truth was found beside the recordings. If "
    "emg2vsa made them, nothing here is evidence about people; if people did, remove the [simulation] table.",
    "data that may be simulated",
)
_NO_TRUTH = Origin(
    "",
    "No table of simulated truth was found beside the recordings,",
    "so they are taken as recorded from people, and no fit can be compared with a truth.",
    "data taken as recorded",
)


def origin(results: StudyResults) -> Origin:
    """What can be said of the data of this study."""
    if results.truth is not None:
        return _SIMULATED
    return _NO_TRUTH if results.study.simulation is None else _PERHAPS
