"""Public names of a package that are loaded when they are first asked for, so that importing it stays cheap."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


def lazy_names(package: str, modules: Mapping[str, str]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of ``package``. The first raises AttributeError for other names.

    modules : public name to the module that has it, as a relative import writes it without its first dot. Where a
    library is missing that an extra installs, ModuleNotFoundError says which; ``errors.EXTRAS`` has them.
    """

    def load(name: str) -> object:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        try:
            value = getattr(import_module(f".{modules[name]}", package), name)
        except ModuleNotFoundError as error:
            errors = import_module(f"{package.partition('.')[0]}.errors")
            if (extra := errors.EXTRAS.get(str(error.name).partition(".")[0])) is None:
                raise
            do = f"Install it: {errors.install_extra(extra)}."
            said = f"{package}.{name}: expected the library {error.name}, but found none. {do}"
            raise ModuleNotFoundError(said, name=error.name) from error
        setattr(sys.modules[package], name, value)
        return value

    return load, lambda: sorted(sys.modules[package].__all__)
