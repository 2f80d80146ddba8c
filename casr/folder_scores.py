"""Every press of a folder scored, each beside the others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from casr.errors import CasrError, PassingError
from casr.frames import FrameSequence
from casr.scored import Score, ScoreSettings
from casr.scoring import score
from casr.stretch import stretch_of, unlike_others


@dataclass(frozen=True)
class FolderScores:
    """Presses by name. scores : of those that could be scored; not_scored : why of the others; unlike : what sets a
    press apart from the others, which is a doubt of its score, too."""

    scores: Mapping[str, Score]
    not_scored: Mapping[str, str]
    unlike: Mapping[str, str]


def named_presses(root: Path, found: Sequence[Path]) -> dict[str, Path]:
    """The presses by their path below ``root`` with dashes, without a file's suffix."""
    bare = {path: path.with_suffix("") if path.is_file() else path for path in found}
    return {"-".join(name.relative_to(root).parts): path for path, name in bare.items()}


def score_presses(
    presses: Mapping[str, Path],
    settings: ScoreSettings,
    open_press: Callable[[Path], FrameSequence],
    told: Callable[[str, Score | CasrError | PassingError], None],
) -> FolderScores:
    """Score one press after the other; ``told`` hears of each, by itself, as soon as it is done."""
    scores: dict[str, Score] = {}
    not_scored: dict[str, str] = {}
    for name, path in presses.items():
        try:
            scores[name] = score(open_press(path), settings)
        except (CasrError, PassingError) as error:
            not_scored[name] = str(error)
            told(name, error)
        else:
            told(name, scores[name])
    stretches = {name: stretch_of(scored) for name, scored in scores.items()}
    unlike = unlike_others({name: stretch for name, stretch in stretches.items() if stretch is not None})
    for name, reason in unlike.items():
        scores[name] = replace(scores[name], doubts=(*scores[name].doubts, reason))
    return FolderScores(scores, not_scored, unlike)
