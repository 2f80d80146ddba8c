"""Where verdicts hang on choices: the share of paths of analysis that keep each, and presets by index."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from emg2vsa.figures.multiverse import draw_paths
from emg2vsa.multiverse import KINDS, IndexPresets, Paths
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Row, Table, table_of
from emg2vsa.report.wording import listed, number

_ALL, _NAMED, _OF_CLAIM = "all paths", 3, ("kept", "applicable", "share", "overturned_by")
_BY_KIND = (
    Column("claim", "Claim"), Column("verdict", "Verdict"), Column("kind", "Choice that differs"),
    Column("paths", "Paths"), Column("kept", "Keep the verdict"), Column("share", "Share, %", 100),
    Column("changed_by", "Changed by"),
)  # fmt: skip
_NO_MOVE = 1e-6
"""Points; presets move by less where they differ by rounding alone."""
_PRESETS = (
    Column("index", "Index"), Column("specimen", "Specimen"), Column("largest_move_points", "Largest move, points"),
    Column("place", "Place by mean preset"), Column("own_place", "Place by the study's index"),
    Column("turned", "Order turns"),
)  # fmt: skip


def paths_share(results: StudyResults) -> dict[str, tuple[int, int]]:
    """Claim to the number of paths that keep its verdict, and of all that bear on it; empty where nobody asked."""
    return {claim: results.paths.kept(claim) for claim in results.paths.claims} if results.paths else {}


def told_of_paths(results: StudyResults, claim: str) -> str:
    """One sentence; "" where nobody asked, or no path bears on the claim."""
    paths = results.paths
    kept, of = paths.kept(claim) if paths and claim in paths.claims else (0, 0)
    if paths is None or not of:
        return ""
    if not paths.estimated(claim):
        return f"None of {of} other paths of analysis gives an estimate."
    return f"{kept} of {of} other paths of analysis keep this verdict."


def _quantities(results: StudyResults) -> Items:
    if results.paths:
        yield "paths.count", int(results.paths.name.size)
        for claim, (kept, of) in paths_share(results).items():
            found = kept, of, kept / of if of else np.nan, results.paths.worst_kind(claim)
            yield from zip((f"paths.{claim}.{name}" for name in _OF_CLAIM), found, strict=True)
    for index, specimen, move, *_, turned in _moves(results.presets):
        yield f"index.{index}.{specimen}.largest_move_points", move
        yield f"index.{index}.{specimen}.turned", turned


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if paths := results.paths:
        rows = [row for claim in paths.claims for row in _kind_rows(paths, claim)]
        shown = tuple(row for row in rows if row["kind"] == _ALL or row["kept"] != row["paths"])
        caption = "Paths that keep each verdict; the page leaves out choices that change none"
        yield Table("paths", caption, _BY_KIND, rows, shown)
        claim, path = np.nonzero(paths.verdict != "")
        whole = {"claim": np.array(paths.claims)[claim], "kind": paths.kind[path], "path": paths.name[path]}
        whole |= {name: getattr(paths, name)[claim, path] for name in ("verdict", "estimate", "low", "high")}
        yield table_of("paths_all", "Every claim along every path", {Column(k, k): v for k, v in whole.items()})
    if moves := list(_moves(results.presets)):
        columns = dict(zip(_PRESETS, zip(*moves, strict=True), strict=True))
        yield table_of("index_presets", "Stiffness presets by index of co-contraction", columns)


def _kind_rows(paths: Paths, claim: str) -> Iterator[Row]:
    at = paths.claims.index(claim)
    said = {"claim": paths.says[at], "verdict": str(paths.own[at])}
    for kind in ("", *KINDS):
        kept, of = paths.kept(claim, kind)
        if of:
            changed_by = _some(paths.changing(claim, kind)) if kind in KINDS[:-1] else ""
            yield said | {
                "kind": kind or _ALL, "paths": of, "kept": kept, "share": kept / of, "changed_by": changed_by,
            }  # fmt: skip


def _some(names: list[str]) -> str:
    """Up to three names."""
    more = [f"{len(names) - _NAMED} more"] if len(names) > _NAMED else []
    return listed([*names[:_NAMED], *more])


def _moves(presets: IndexPresets | None) -> Iterator[tuple[str, str, float, int | None, int | None, bool]]:
    """Index, specimen, largest move, place by this index and by the study's, and whether they differ."""
    if presets is None:
        return
    move, rank = presets.largest_move, presets.rank
    for (i, s), place in np.ndenumerate(rank):
        if i:
            turned = bool(place == place and place != rank[0, s])
            here, own = (int(of) if of == of else None for of in (place, rank[0, s]))
            yield presets.indices[i], presets.specimens[s], float(move[i, s]), here, own, turned


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    paths = results.paths
    if not paths or not paths.name.size:
        return
    kinds, share = paths.shares()
    caption = (
        "Fig. P. Percent of paths that keep a verdict; a column changes one choice alone. Gaps: no bearing on the "
        "claim, or no estimate. Green: holds; red: refuted; grey: not determined."
    )
    each = zip(paths.says, paths.own, share[:, 0], strict=True)
    told = " ".join(
        f"{says}: {own}, kept by {number(100 * kept)} % of paths." for says, own, kept in each if kept == kept
    )
    figure = draw_paths(paths.says, paths.own.tolist(), [_ALL, *kinds], share)
    yield Drawing("figpaths", ROBUSTNESS.title, caption, told, figure)


def _words(results: StudyResults, q: Quantities) -> Mapping[str, object]:
    """The claim whose verdict the fewest paths keep, and the index that moves presets most."""
    found: dict[str, object] = {"least": "", "moved": ()}
    says = dict(zip(results.paths.claims, results.paths.says, strict=True)) if results.paths else {}
    shares = {claim: kept / of for claim, (kept, of) in paths_share(results).items() if of}
    if shares and results.paths:
        least = min(shares, key=shares.__getitem__)
        kind = results.paths.worst_kind(least)
        by = _some(results.paths.changing(least, kind))
        found |= {"least": least, "says": says[least], "share": shares[least], "kind": kind, "by": by}
    if moves := [move for move in _moves(results.presets) if move[2] > _NO_MOVE]:
        turning = list(dict.fromkeys(move[0] for move in moves if move[-1]))
        points = float(np.ptp(results.study.schedule.stiffness_percent))
        found |= {"moved": max(moves, key=lambda move: move[2]), "points": points, "turning": turning}
    return found


_TEXT = """
{{ figure("figpaths") }}
{% if least and share == 1 %}
<p>Every path keeps every verdict.</p>
{% elif least %}
<p>The fewest paths keep the verdict on “{{ says }}”: {{ share | percent }}.{% if kind %}
 Of single choices, “{{ kind }}” changes that verdict most often: {{ by }}.{% endif %}</p>
{% endif %}
{% if least %}
{{ folded("paths", "Paths of analysis that keep each verdict") }}
{% else %}
<p><code>emg2vsa run {{ study.path.name }} --paths</code> judges every claim again along other paths of analysis.</p>
{% endif %}
{% if moved %}
<p>Another index of co-contraction moves a stiffness preset by up to {{ moved[2] | number(2) }} points of
{{ points | number(2) }} ({{ moved[1] }}, {{ moved[0] }}).
{% if turning %}By {{ turning | listed }} the specimens change their order.{% endif %}</p>
{% endif %}
{{ folded("index_presets", "Stiffness presets by index of co-contraction") }}
"""

ROBUSTNESS = Section(
    "robustness", "Where verdicts hang on choices", _TEXT,
    quantities=_quantities, tables=_tables, drawings=_drawings, words=_words,
)  # fmt: skip
