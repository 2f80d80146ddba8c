"""Classes of settings behave as frozen dataclasses of keywords do."""

from __future__ import annotations

import copy
import inspect
import pickle
from dataclasses import FrozenInstanceError, asdict, dataclass, field, fields, is_dataclass, replace

import pytest

from emg2vsa.settings_class import settings_class


@settings_class
class Ours:
    a: int
    b: float = 1.5
    c: tuple[str, ...] = ("x",)
    d: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Theirs:
    a: int
    b: float = 1.5
    c: tuple[str, ...] = ("x",)
    d: dict[str, int] = field(default_factory=dict)


@settings_class
class OursBelow(Ours):
    e: str = "e"

    def __repr__(self) -> str:
        return "mine"


@dataclass(frozen=True, kw_only=True)
class TheirsBelow(Ours):
    e: str = "e"


def test_values_fields_and_text_are_those_of_a_dataclass() -> None:
    ours, theirs = Ours(a=1, b=2.0), Theirs(a=1, b=2.0)
    assert is_dataclass(Ours)
    assert asdict(ours) == asdict(theirs)
    assert [each.name for each in fields(Ours)] == [each.name for each in fields(Theirs)]
    assert repr(ours) == repr(theirs).replace("Theirs", "Ours")
    assert asdict(replace(ours, c=())) == asdict(replace(theirs, c=()))
    assert Ours(a=1).d is not Ours(a=1).d


def test_equality_and_hash_are_those_of_the_values_of_one_class() -> None:
    nan = float("nan")
    assert Ours(a=1, b=nan) == Ours(a=1, b=nan)
    assert Ours(a=1) != Ours(a=2)
    assert Ours(a=1) != OursBelow(a=1)
    assert Ours(a=1) != 1
    one, same = (OursBelow(a=1, d=()) for _ in range(2))  # type: ignore[arg-type]
    assert hash(one) == hash(same)
    with pytest.raises(TypeError, match="unhashable"):
        hash(Ours(a=1))


@pytest.mark.parametrize("kind", [Ours, OursBelow, TheirsBelow])
def test_nothing_can_be_assigned_or_deleted(kind: type) -> None:
    made = kind(a=1)
    with pytest.raises(FrozenInstanceError, match="cannot assign to field 'a'"):
        made.a = 2
    with pytest.raises(FrozenInstanceError, match="cannot delete field 'a'"):
        del made.a
    assert made.a == 1


@pytest.mark.parametrize("kind", [Ours, OursBelow, TheirsBelow])
def test_copies_are_equal(kind: type) -> None:
    made = kind(a=1, d={"k": 1})
    assert pickle.loads(pickle.dumps(made)) == copy.deepcopy(made) == copy.copy(made) == made


@pytest.mark.parametrize("kind", [Ours, Theirs, OursBelow, TheirsBelow])
@pytest.mark.parametrize(("given", "said"), [({}, "missing .*'a'"), ({"a": 1, "z": 2}, "unexpected keyword .*z")])
def test_wrong_keywords_are_refused(kind: type, given: dict[str, int], said: str) -> None:
    with pytest.raises(TypeError, match=said):
        kind(**given)
    with pytest.raises(TypeError, match="positional"):
        kind(1)


def test_methods_of_the_class_itself_are_kept() -> None:
    assert repr(OursBelow(a=1)) == "mine"
    assert repr(TheirsBelow(a=1)) == "TheirsBelow(a=1, b=1.5, c=('x',), d={}, e='e')"


@pytest.mark.parametrize(("ours", "theirs"), [(Ours, Theirs), (TheirsBelow, TheirsBelow)])
def test_editors_and_notebooks_are_told_the_keywords(ours: type, theirs: type) -> None:
    shown, known = inspect.signature(ours).parameters, inspect.signature(theirs).parameters
    assert [(each.name, each.kind) for each in shown.values()] == [(each.name, each.kind) for each in known.values()]
    assert shown["a"].default is inspect.Parameter.empty
    assert shown["d"].default == {}
