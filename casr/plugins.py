"""What other installed packages add: objects that they name as entry points of a group, found without importing them.

A group is looked up when something of it is asked for, and a plugin is imported when it is used. A plugin of the name
of something of this project never takes its place.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

from casr.by_name import used
from casr.errors import PluginError, said_by

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


ENGINES = ("pin-affine", "horn-schunck", "dis")
PLUGINS = "plugins "
"""Begins the name of a group of plugins, or of a group and the one name that is looked up, where use is told."""


@dataclass(frozen=True)
class Plugin:
    """An entry point of an installed distribution. ``str`` names it with its distribution and version.

    rivals : other distributions with an entry point of its name.
    """

    name: str
    distribution: str
    version: str
    entry: EntryPoint
    rivals: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.name} of {self.distribution} {self.version}"

    def load(self) -> Any:
        """The object that the entry point names. PluginError where it cannot be imported."""
        try:
            return self.entry.load()
        except (Exception, SystemExit) as error:  # whatever a foreign module does when it is imported
            raise self.fault("a module that can be imported", said_by(error)) from error

    def fault(self, wanted: str, found: str) -> PluginError:
        """The error that names the plugin, for a break of its contract."""
        do = f"Tell the authors of {self.distribution}, or uninstall it."
        return PluginError(f"plugin {self}", wanted=wanted, found=found, do=do)


def plugins(group: str) -> tuple[Plugin, ...]:
    """Plugins of a group, by distribution and name; of two with one name the first counts."""
    used([f"{PLUGINS}{group}"])
    return found_plugins(group)


def plugin_named(group: str, name: str) -> Plugin | None:
    """The plugin of that name; None for none. Whoever asks so hangs on no other plugin of the group."""
    used([f"{PLUGINS}{group} {name}"])
    return next((plugin for plugin in found_plugins(group) if plugin.name == name), None)


@cache
def found_plugins(group: str) -> tuple[Plugin, ...]:
    """As ``plugins``, and nobody is told."""
    from importlib.metadata import entry_points  # noqa: PLC0415  (looks through every installed distribution)

    found = [
        Plugin(entry.name, entry.dist.name, entry.dist.version, entry)
        for entry in entry_points(group=group)
        if entry.dist is not None
    ]
    named: dict[str, list[Plugin]] = {}
    for plugin in sorted(found, key=lambda each: (each.distribution.lower(), each.name)):
        named.setdefault(plugin.name, []).append(plugin)
    return tuple(
        replace(first, rivals=tuple(f"{each.distribution} {each.version}" for each in others))
        for first, *others in named.values()
    )


def known_engines() -> tuple[str, ...]:
    """``ENGINES``, then those that other installed packages add (entry points of ``casr.flow_engines``)."""
    return tuple(dict.fromkeys((*ENGINES, *(plugin.name for plugin in plugins("casr.flow_engines")))))


def made_worlds() -> Any:
    """The module that renders presses: the entry point ``casr.worlds`` of this project's own distribution.

    Those of other packages do not count. PluginError where a checkout is used without having been installed.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415  (looks through every installed distribution)

    for entry in entry_points(group="casr.worlds"):
        if entry.dist is not None and entry.dist.name == "emg2vsa":
            return entry.load()
    raise PluginError(
        "casr.worlds",
        wanted="the maker of simulated presses, an entry point of the package emg2vsa",
        found="none: this copy was not installed, or before it had one",
        do="Install it again: pip install . in its folder.",
    )
