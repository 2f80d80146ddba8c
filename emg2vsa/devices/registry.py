"""Kinds of devices, one line each: of this project, and of other packages as entry points of ``emg2vsa.devices``.

A role is what the rig or a session wants of a device; a kind is one device that plays it. A kind is loaded when it is
asked for, and its driver when it is opened. A kind of another package never takes the place of one of ours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, get_args, get_type_hints

from casr.by_name import module_named
from casr.errors import PluginError, UserError, said_by
from casr.plugins import Plugin, plugin_named, plugins

if TYPE_CHECKING:
    from emg2vsa.devices.clock import Clock

GROUP = "emg2vsa.devices"


class _Role(NamedTuple):
    """base : of the settings. device : the protocol of what is opened. kinds : of this project, by name. default : the
    kind of a table that names none, as every table did before there was a choice."""

    base: str
    device: str
    kinds: dict[str, str]
    default: str | None = None


ROLES = {
    "actuator": _Role("emg2vsa.devices.device_settings:ActuatorSettings", "emg2vsa.devices.board:Board", {
        "qbmove": "emg2vsa.devices.qbmove:QBMOVE",
        "dynamixel": "emg2vsa.devices.dynamixel:DYNAMIXEL",
    }, default="qbmove"),
    "force": _Role("emg2vsa.devices.device_settings:ForceSettings", "emg2vsa.devices.protocols:ForceSensor", {
        "net-ft": "netft:NET_FT",
        "ni-daq": "ni_daq:GAUGES",
    }),
    "camera": _Role("emg2vsa.devices.device_settings:CameraSettings", "emg2vsa.devices.protocols:Camera", {
        "opencv": "opencv_camera:OPENCV",
    }, default="opencv"),
    "emg": _Role("emg2vsa.session_settings:EmgSettings", "emg2vsa.devices.streams:Source", {
        "ni-daq": "ni_daq:EMG",
        "trigno": "trigno:TRIGNO",
        "lsl": "lsl:EMG",
        "simulated": "simulated:EMG",
    }),
    "session-force": _Role("emg2vsa.session_settings:SessionForceSettings", "emg2vsa.devices.streams:Source", {
        "rig": "rig_force:RIG",
        "lsl": "lsl:FORCE",
        "simulated": "simulated:FORCE",
    }),
}  # fmt: skip
"""A kind is one line: its name, and where its `Kind` stands below ``emg2vsa.devices``."""


class Wrong(NamedTuple):
    """What is wrong with settings: keys from their table on, what was wanted, what was found, what to do."""

    path: tuple[str | int, ...]
    wanted: str
    found: str
    do: str = ""


@dataclass(frozen=True)
class Around:
    """What is around a device when it is opened.

    Parameters
    ----------
    clock : on which it measures.
    lost_s : a device that has given nothing for so long is lost.
    stiffness_percent : what a rig may ask of an actuator, of its full preset.
    others : settings of the devices beside it, by role; of a session "emg", "session-force" and, with a rig, "force".
    kept : lasts as long as the session, in which a device that was lost is opened anew; for what two devices share.
    """

    clock: Clock
    lost_s: float = 1.0
    stiffness_percent: tuple[float, float] = (0.0, 100.0)
    others: Mapping[str, Any] = field(default_factory=dict)
    kept: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Kind:
    """One kind of device. A function may be given as "module:name", which is loaded when it is called.

    Parameters
    ----------
    role : one of `ROLES`.
    settings : its table, a frozen dataclass that inherits from the role's, with kind: Literal["its name"].
    open : of settings and `Around`, the device, not started: an Actuator, ForceSensor or Camera of
        `emg2vsa.devices.protocols`, or a Source of `emg2vsa.devices.streams`. It raises DeviceError or SettingError.
    check : of settings, what is `Wrong` with them that their types and limits do not say.
    about : of an opened device, lines on it for ``emg2vsa rig info``.
    facts : of a started device and its settings, plain values for the record of a run.
    serial_number : of an opened force sensor or camera; empty: this one tells none.
    scan : of a line, a clock, ids (none: all) and the time for each answer, s, a line of text for each who answers.
    joints : of an actuator, names of the joints for which schedules are made. full_key : of the full preset, in the
        table [schedule] of a study and in schedules. export : how these schedules are written, an `Export` of
        `emg2vsa.devices.joints`.
    plugin : whose it is; None for one of this project.
    """

    role: str
    settings: type
    open: str | Callable[[Any, Around], Any]
    check: Callable[[Any], Iterator[Wrong]] | None = None
    about: str | Callable[[Any], Iterator[str]] | None = None
    facts: str | Callable[[Any, Any], dict[str, Any]] | None = None
    serial_number: str | Callable[[Any], str] | None = None
    scan: str | Callable[[Any, Clock, Sequence[int], float], Iterator[str]] | None = None
    joints: tuple[str, ...] = ()
    full_key: str = ""
    export: Any = None
    plugin: Plugin | None = None

    def opened(self, settings: Any, around: Around) -> Any:
        """The device. PluginError where that of another package fails, or lacks what its role wants."""
        device = self.call("open", settings, around)
        if self.plugin:
            protocol = loaded(ROLES[self.role].device)
            named = dict.fromkeys((*getattr(protocol, "__annotations__", ()), *vars(protocol)))
            wanted = [name for name in named if not name.startswith("_")]
            if absent := [name for name in wanted if name not in dir(device)]:
                raise self.plugin.fault(f"a device with {', '.join(wanted)}", f"no {', '.join(absent)}")
        return device

    def call(self, function: str, *given: Any) -> Any:
        """What one of its functions gives; nothing where there is none. PluginError where it fails."""
        with blamed(self.plugin, f"{function} of its Kind to do its work"):
            place = getattr(self, function)
            given_back = loaded(place if self.plugin else _whole(place))(*given) if place else ()
            return given_back if function == "open" else _GIVES[function](given_back)


@contextmanager
def blamed(plugin: Plugin | None, wanted: str) -> Iterator[None]:
    """What the code of another package raises inside becomes a PluginError; errors for the user stay."""
    try:
        yield
    except UserError:
        raise
    except Exception as error:
        if plugin is None:
            raise
        raise plugin.fault(wanted, said_by(error)) from error


def _wrong(found: Any) -> Wrong:
    path, *said = Wrong(*found)
    if not (isinstance(path, (tuple, list)) and all(isinstance(key, (str, int)) for key in path)):
        raise TypeError(f"{path!r} is no tuple of keys")
    return Wrong(tuple(path), *map(str, said))


_GIVES: dict[str, Callable[[Any], Any]] = {
    "check": lambda found: tuple(map(_wrong, found)), "about": lambda lines: tuple(map(str, lines)), "facts": dict,
    "scan": tuple, "serial_number": lambda told: str(told or ""),
}  # fmt: skip


def kind_of(role: str, name: str) -> Kind | None:
    """The kind of a role; None where there is none. PluginError where another package's cannot be used."""
    if name in ROLES[role].kinds:
        ours: Kind = loaded(_whole(ROLES[role].kinds[name]))
        return ours
    plugin = plugin_named(GROUP, name)
    kind = _of_plugin(plugin) if plugin else None
    return kind if kind and kind.role == role else None


def roles_of(name: str) -> list[str]:
    """Roles that have a kind of this name."""
    return [role for role in ROLES if kind_of(role, name)]


def known(role: str, settings: Any) -> Kind:
    """The kind of settings that come of a file: its reader has looked whether there is one."""
    kind = kind_of(role, settings.kind)
    assert kind is not None, settings
    return kind


def kinds(role: str) -> dict[str, Kind]:
    """Every kind of a role by its name, ours first; those of other packages that cannot be used are left out."""
    return dict(each_kind(role))


def each_kind(role: str) -> Iterator[tuple[str, Kind]]:
    """As ``kinds``, one after the other: who finds one of ours looks at no other package."""
    yield from own_kinds(role)
    for plugin in plugins(GROUP):
        with suppress(PluginError):
            if kind := kind_of(role, plugin.name):
                yield plugin.name, kind


def own_kinds(role: str) -> Iterator[tuple[str, Kind]]:
    """Those of this project."""
    return ((name, known_kind) for name in ROLES[role].kinds if (known_kind := kind_of(role, name)))


@cache
def _of_plugin(plugin: Plugin) -> Kind:
    """What an entry point names. PluginError where it breaks the contract."""
    if plugin.rivals:
        found = f"it in {', '.join((f'{plugin.distribution} {plugin.version}', *plugin.rivals))}"
        do = "Uninstall all but one of them."
        raise PluginError(f"plugin {plugin.name}", wanted="a kind of one package", found=found, do=do)
    kind = plugin.load()
    with blamed(plugin, "a Kind that can be read"):
        return _kept(plugin, kind)


def _kept(plugin: Plugin, kind: Any) -> Kind:
    """The kind, which keeps to the contract."""
    if not isinstance(kind, Kind):
        raise plugin.fault("a Kind of emg2vsa.devices.registry", f"an object of type {type(kind).__name__}")
    if kind.role not in tuple(ROLES):
        raise plugin.fault(f"one of the roles {', '.join(ROLES)}", repr(kind.role))
    base = loaded(ROLES[kind.role].base)
    if not (isinstance(kind.settings, type) and issubclass(kind.settings, base)):
        raise plugin.fault(f"settings that inherit from {base.__module__}.{base.__name__}", repr(kind.settings))
    with blamed(plugin, "settings whose annotations can be read"):
        named = get_args(get_type_hints(kind.settings)["kind"])
    if named != (plugin.name,):
        wanted = f'settings with kind: Literal["{plugin.name}"], as the entry point is called'
        raise plugin.fault(wanted, f"kind: {', '.join(map(repr, named)) or 'any text'}")
    return replace(kind, plugin=plugin)


def _whole(place: Any) -> Any:
    """A place of ours may be told from ``emg2vsa.devices`` on. Such a place is no part of the key of a step: no step
    opens a device. What a step uses, as ``export``, is told whole."""
    return f"{GROUP}.{place}" if isinstance(place, str) and not place.startswith(f"{GROUP}.") else place


def loaded(place: Any) -> Any:
    """The object at "module:name"; any other object as it is."""
    if not isinstance(place, str):
        return place
    module, _, name = place.partition(":")
    return getattr(module_named(module), name)
