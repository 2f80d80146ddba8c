"""Classes of settings: frozen dataclasses of keywords that share their methods.

``dataclass(frozen=True)`` compiles six methods for each class. A study has sixty such classes, which took an eighth of
a run that finds everything fresh.
"""

from __future__ import annotations

from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, field, fields, is_dataclass
from functools import cache
from inspect import Parameter, Signature
from operator import attrgetter
from typing import Any, TypeVar, dataclass_transform

_Settings = TypeVar("_Settings")


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(field,))
def settings_class(cls: type[_Settings]) -> type[_Settings]:
    """What ``dataclass(frozen=True, kw_only=True)`` makes of a class; `fields`, `replace` and the like know it as one.

    Methods that the class has itself are kept; it has no ``__post_init__``.
    """
    inherits = any(is_dataclass(base) for base in cls.__bases__)
    own = {name: method for name, method in _METHODS.items() if name not in vars(cls)}
    made = dataclass(init=False, repr=False, eq=False, frozen=inherits, kw_only=True)(cls)
    for name, method in own.items():
        setattr(made, name, method)
    vars(made)["__dataclass_params__"].frozen = True  # so that frozen dataclasses may inherit from it
    return made


class _Signature:
    """How the class is called, for editors and notebooks; made when they ask for it."""

    def __get__(self, instance: object, cls: Any) -> Signature:
        def default(of: Field[Any]) -> Any:
            made = of.default if of.default_factory is MISSING else of.default_factory()
            return Parameter.empty if made is MISSING else made

        kinds = {True: Parameter.KEYWORD_ONLY, False: Parameter.POSITIONAL_OR_KEYWORD}
        ordered = sorted(_fields_of(cls), key=lambda each: bool(each.kw_only))
        return Signature(
            [Parameter(of.name, kinds[bool(of.kw_only)], default=default(of), annotation=of.type) for of in ordered]
        )


def _init(self: Any, **given: Any) -> None:
    values, name = self.__dict__, type(self).__name__
    for each in _fields_of(self.__class__):
        if each.name in given:
            values[each.name] = given.pop(each.name)
        elif each.default is not MISSING:
            values[each.name] = each.default
        elif each.default_factory is not MISSING:
            values[each.name] = each.default_factory()
        else:
            raise TypeError(f"{name}.__init__() missing the keyword argument {each.name!r}")
    if given:
        raise TypeError(f"{name}.__init__() got unexpected keyword arguments: {', '.join(given)}")


@cache
def _fields_of(cls: type[Any]) -> tuple[Field[Any], ...]:
    return fields(cls)


@cache
def _values_of(cls: type[Any]) -> attrgetter[Any]:
    """What gives the values of all fields; with the class, as a getter has one name or more."""
    return attrgetter("__class__", *(each.name for each in fields(cls)))


def _repr(self: Any) -> str:
    shown = (f"{each.name}={getattr(self, each.name)!r}" for each in _fields_of(self.__class__))
    return f"{type(self).__qualname__}({', '.join(shown)})"


def _eq(self: Any, other: object) -> bool:
    values = _values_of(self.__class__)
    return values(self) == values(other) if type(other) is type(self) else NotImplemented


def _hash(self: Any) -> int:
    return hash(_values_of(self.__class__)(self))


def _setattr(self: Any, name: str, value: object) -> None:
    raise FrozenInstanceError(f"cannot assign to field {name!r}")


def _delattr(self: Any, name: str) -> None:
    raise FrozenInstanceError(f"cannot delete field {name!r}")


_METHODS = {
    "__init__": _init, "__repr__": _repr, "__eq__": _eq, "__hash__": _hash, "__setattr__": _setattr,
    "__delattr__": _delattr, "__signature__": _Signature(),
}  # fmt: skip
