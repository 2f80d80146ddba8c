"""Whatever a study file holds, it is loaded or refused by problems on lines, never with a traceback."""

from __future__ import annotations

import copy
import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from emg2vsa.errors import StudyError
from emg2vsa.study_file import load_study
from emg2vsa.study_file.problems import KeyPath

ROOT = Path(__file__).resolve().parents[2]
STUDIES = [tomllib.loads(path.read_text()) for path in sorted(ROOT.glob("studies/*/study.toml"))]
VALUES = st.one_of(
    st.sampled_from([-1, 0, 1, 2**70, 1e-320, 1.5, math.inf, math.nan, True, "", "S1", "P01", "{", "{x}", "1", [], {}]),
    st.lists(st.sampled_from([1, -2.5, "S1", True, [], {}]), max_size=3),
    st.dictionaries(st.sampled_from(["name", "emg", "S1", "force", "files", "EDC"]), st.sampled_from([1, "a", [], {}])),
)


def as_toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {as_toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(as_toml, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def places(value: Any, path: KeyPath = ()) -> list[KeyPath]:
    """Paths of all that may be replaced."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [found for key, inner in items for found in [(*path, key), *places(inner, (*path, key))]]


@st.composite
def changed_studies(draw: st.DrawFn) -> dict[str, Any]:
    study = copy.deepcopy(draw(st.sampled_from(STUDIES)))
    for _ in range(draw(st.integers(1, 3))):
        *parents, last = draw(st.sampled_from(places(study)))
        node: Any = study
        for part in parents:
            node = node[part]
        match draw(st.sampled_from(["replace", "remove", "add"])):
            case "replace":
                node[last] = draw(VALUES)
            case "remove" if isinstance(node, dict):
                del node[last]
            case _ if isinstance(node, dict):
                node[draw(st.sampled_from(["extra", "window", "files", "ids", "file", "channels"]))] = draw(VALUES)
        if not places(study):
            break
    return study


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(changed_studies())
def test_any_change_is_taken_or_refused(tmp_path_factory: Any, study: dict[str, Any]) -> None:
    path = tmp_path_factory.mktemp("study") / "study.toml"
    path.write_text("".join(f"{json.dumps(key)} = {as_toml(value)}\n" for key, value in study.items()))
    said: tuple[str, ...] = ()
    try:
        assert load_study(path).recordings
    except StudyError as error:
        said = error.problems
    for problem in said:
        assert re.match(rf"{re.escape(str(path))}:\d+: .+: expected .+, but found .+\.", problem)
