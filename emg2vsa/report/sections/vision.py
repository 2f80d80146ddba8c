"""Old and new vision algorithm, on the same presses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.discrimination.run_table import RIGID
from emg2vsa.report.designs import DESIGN, design_name, keys, of_tests, tested, with_interval
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Row, Table
from emg2vsa.report.wording import interval

_NUMBERS = ("area_ratio", "area_error", "area_error_sd", "area_cv", "casr_cv")


def _quantities(results: StudyResults) -> Items:
    found = tested(results)
    compared = found.algorithms
    for a, algorithm in enumerate(compared.names):
        for i, name in enumerate(keys(found)):
            for key in _NUMBERS:
                yield f"{name}.{algorithm}.{key}", float(getattr(compared, key)[a, i])
            yield from with_interval(f"{name}.{algorithm}.gap", *compared.gap(a, i))


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    compared, table = found.algorithms, found.table
    heads = {
        "area_ratio": f"A_c0 / that of {compared.names[0]}",
        "area_error": "Error of A_c0 (%)",
        "area_error_sd": "SD of that error (%)",
        "area_cv": "CV of A_c0 (%)",
        "casr_cv": "CV of CASR (%)",
    }
    if not np.isfinite(compared.area_error).any():
        heads = {key: head for key, head in heads.items() if "error" not in key}
    columns = (
        Column("algorithm", "Algorithm"),
        DESIGN,
        *(Column(key, head, 1.0 if key == "area_ratio" else 100.0) for key, head in heads.items()),
        Column("gap", f"Gap {compared.pair[0]} to {compared.pair[1]}, in SDs"),
    )
    rows: tuple[Row, ...] = tuple(
        {
            "algorithm": algorithm,
            "design": design_name(table, i),
            **{key: float(getattr(compared, key)[a, i]) for key in heads},
            "gap": interval(*compared.gap(a, i)),
        }
        for a, algorithm in enumerate(compared.names)
        for i in range(len(table.conditions))
    )
    shown = tuple(row for row in rows if str(row["design"]).startswith(RIGID)) or rows
    caption = "Vision algorithms on the same presses, rigid motor" if len(shown) < len(rows) else "Vision algorithms"
    yield Table("algorithms", caption, columns, rows, shown)


_TEXT = """
<p>"Circle" is the old algorithm; a larger gap sets specimens further apart.
{% if "paper" in runs.discrimination.algorithms.names %}"Paper" follows the paper in every step.{% endif %}</p>
{{ folded("algorithms", "The algorithms on the same presses") }}
"""

VISION = Section("vision", "Old and new vision algorithm", _TEXT, of_tests, _quantities, _tables)
