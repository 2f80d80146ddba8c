"""A program of sub-commands: one module each, heavy imports only in the one that runs; its reference and completion."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import casr
from casr.errors import SettingError, UserError, install_extra
from casr.one_thread import one_thread
from casr.terminal import VOICE, coloured, note
from casr.terminal import finite as finite

SOURCE = Path(casr.__file__).parents[1]
"Folder of the packages; in a source checkout the benchmarks lie there too."


def benchmarks(module: str, program: str) -> ModuleType:
    """The module ``benchmarks.<module>``, which ``<program> bench`` runs. SettingError : it is not installed."""
    if not (SOURCE / "benchmarks").is_dir():
        raise SettingError(
            "bench", wanted=f"a source checkout, with benchmarks/ beside {SOURCE / program}", found="none",
            do=f"Get the sources of emg2vsa {casr.__version__} and run there: python -m {program}.cli bench",
        )  # fmt: skip
    if str(SOURCE) not in sys.path:
        sys.path.insert(0, str(SOURCE))
    return import_module(f"benchmarks.{module}")


Group = argparse._ActionsContainer  # a parser or a group of its options
Types = Mapping[str, Any] | None
Names = Sequence[str] | Mapping[str, str]
Commands = Any  # argparse gives its collection of sub-parsers no public type

PAGE_COLUMNS = 100
"Width of the help; a terminal's own width must not change the page."
PAGE_HEAD = """# The commands of {name}

Written by `python -m {name}.cli.reference`; do not edit. The same text is in `{name} COMMAND --help`.

| exit status | meaning |
|---|---|
| 0 | done |
| 1 | done, but something is not good; the help of the command says what |
| 2 | unusable input ({inputs}), said in one line for each problem |
| 130 | stopped with Ctrl-C; what was finished is kept |

Results go to the standard output; progress, notes and complaints to the error stream. With `--json` the standard output
holds one JSON value; an error is one too, with the keys `error` and `status`, beside its text on the error stream.
Every command takes `-h` (help), `-q` (leave out progress and notes) and `-v` (say more: reasons, and where in the
program an error arose); they are left out below, and so is the text of `--json`.
"""
_OF_ALL = re.compile(r"^  (?:-h, --help|-q, --quiet|-v, --verbose|--json) .*\n(?: {8,}.*\n)*|\noptions:\n(?=\n)", re.M)
"""Options of every command in its help, and the heading where there are no others."""


@dataclass(frozen=True, kw_only=True)
class Program:
    """A program and its sub-commands.

    name : as typed. Module ``<name>.cli.<command>`` adds its parser in ``add_to(commands)``, with its work as ``run``.
    version, description, epilog : for ``--version`` and ``--help``; the exit statuses are added to the epilog.
    commands : as for `add_subcommands`. stopped : what Ctrl-C leaves, said after it; a command may set its own.
    extras : library to the extra of the package that installs it.
    moved : an older spelling to the one of today, each of one or two words. The older one still runs, and says so.
    """

    name: str
    version: str
    description: str
    epilog: str
    commands: Names
    stopped: str
    extras: Mapping[str, str] = field(default_factory=dict)
    moved: Mapping[str, str] = field(default_factory=dict)

    def main(self, argv: Sequence[str] | None = None) -> int:
        """Run one sub-command; returns the exit status: 0 done, 1 something is not good, 2 unusable input."""
        one_thread()
        words = list(sys.argv[1:] if argv is None else argv)
        # also as argparse takes them: shortened, and several letters together
        VOICE.quiet = any(re.fullmatch("-v?q[vq]*|--q(u(i(et?)?)?)?", word) for word in words)
        VOICE.json = any(re.fullmatch("--js(on?)?(=.*)?", word, re.DOTALL) for word in words)
        arguments = argparse.Namespace()
        try:
            arguments = self.parser().parse_args(self._of_today(words))
            VOICE.quiet, VOICE.verbose = arguments.quiet, arguments.verbose
            status: int = arguments.run(arguments)
            if sys.stdout is not None:  # a shell may have closed it
                sys.stdout.flush()
            return status
        except UserError as error:
            return self._failed(error.told_by(self.name), message=str(error), **_parts(error))
        except ModuleNotFoundError as error:
            library = str(error.name).partition(".")[0]
            if library not in self.extras:
                raise
            do = f"Install it: {install_extra(self.extras[library])}."
            return self._failed(f"{self.name}: expected the library {library}, but found none. {do}", do=do)
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        except OSError as error:
            text = f"{error.filename or 'input or output'}: {error.strerror or error}"
            return self._failed(f"{self.name}: {text}", message=text)
        except KeyboardInterrupt:
            text = f"Stopped. {getattr(arguments, 'stopped', self.stopped)}"
            print(f"\n{text}", file=sys.stderr)
            _print_error(130, message=text)
            return 130

    def _of_today(self, words: list[str]) -> list[str]:
        """The words with an older spelling of the command replaced."""
        for count in (2, 1):
            new = self.moved.get(" ".join(words[:count]))
            if new is not None:
                note(f'{self.name}: "{self.name} {" ".join(words[:count])}" is now "{self.name} {new}".')
                return [*new.split(), *words[count:]]
        return words

    def _failed(self, text: str, **parts: object) -> int:
        """The error that is being handled, for a person and for a program; with ``-v`` where it arose."""
        if VOICE.verbose:
            import traceback

            traceback.print_exc()
        name, colon, rest = text.partition(": ")
        known = colon and name == self.name
        print(f"{coloured(name, 'bad', sys.stderr)}: {rest}" if known else text, file=sys.stderr)
        _print_error(2, **({"message": rest} | parts))
        return 2

    def parser(self) -> argparse.ArgumentParser:
        """The parser of the whole command line; modules of commands are imported when they are asked for."""
        whole = Parser(
            prog=self.name,
            description=self.description,
            epilog=f"{self.epilog} Exit status: 0 done; 1 something is not good; 2 unusable input, nothing was done; "
            "130 stopped.",
        )
        whole.former = self.moved
        whole.add_argument("--version", action="version", version=f"{self.name} {self.version}")
        add_subcommands(whole, f"{self.name}.cli", self.commands)
        return whole

    def reference_page(self, inputs: str) -> str:
        """Help of every command as Markdown. inputs : what can be unusable."""
        parts = []
        for parser in parsers_of(self.parser()):
            parser.formatter_class = partial(argparse.HelpFormatter, width=PAGE_COLUMNS)  # type: ignore[assignment]
            text = parser.format_help().replace(parser.format_usage(), _short_usage(parser), 1)
            parts.append(f"\n## `{parser.prog}`\n\n```text\n{_OF_ALL.sub('', text)}```\n")
        return PAGE_HEAD.format(name=self.name, inputs=inputs) + "".join(parts)


def _short_usage(parser: argparse.ArgumentParser) -> str:
    """The usage without the options that the page lists beneath it."""
    shown = [action for action in parser._actions if action.required or not action.option_strings]
    formatter = parser._get_formatter()
    formatter.add_usage(None, shown, [])
    json_too = " [--json]" if "--json" in parser._option_string_actions else ""
    return f"{formatter.format_help().rstrip()} [OPTIONS]{json_too}\n"


def _parts(error: UserError) -> dict[str, object]:
    """What an error says of where it is, what was wanted and found, and what to do; as far as it does."""
    names = {"what": "where", "wanted": "wanted", "found": "found", "do": "do", "problems": "problems"}
    return {name: getattr(error, of) for name, of in names.items() if hasattr(error, of)}


def _print_error(status: int, **parts: object) -> None:
    """The error as one line of JSON, where JSON was asked for."""
    if VOICE.json:
        print(json.dumps(finite({"error": parts, "status": status}), sort_keys=True), flush=True)


class SubCommands(argparse._SubParsersAction):  # type: ignore[type-arg]
    """Sub-commands, imported when they are asked for, and all of them for the help.

    modules : name to the module whose ``add_to`` adds it, perhaps with others, in the order of the help.
    """

    modules: Mapping[str, str] = {}

    def load(self, *names: str) -> None:
        """Import these, or all."""
        for name in names or self.modules:
            if name not in self.choices:
                importlib.import_module(self.modules[name]).add_to(self)

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        self.load(values[0])
        super().__call__(parser, namespace, values, option_string)

    def _get_subactions(self) -> Any:
        self.load()
        order = list(self.modules)
        return sorted(super()._get_subactions(), key=lambda action: order.index(action.dest))


class Parser(argparse.ArgumentParser):
    """A parser that names the nearest word to a mistyped command, option or choice. former : that still run."""

    former: Collection[str] = ()

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        found, left = self.parse_known_args(args, namespace)
        if left:
            parser: argparse.ArgumentParser = getattr(found, "parser", self)
            options = list(parser._option_string_actions)
            wrong = [word.partition("=")[0] for word in left if word.startswith("-")]
            near = [
                f" Write {word} after {parser.prog}." if word in options else nearest(word, options) for word in wrong
            ]
            parser.error(f"unrecognized arguments: {' '.join(left)}.{''.join(near)}")
        return found

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        choices = action.modules if isinstance(action, SubCommands) else action.choices
        if choices is not None and value not in choices:
            known = [str(each) for each in choices]
            near = nearest(str(value), [*known, *self.former])
            listed = f"expected one of {', '.join(known)}, but found {str(value)!r}.{near}"
            raise argparse.ArgumentError(action, listed)

    def error(self, message: str) -> NoReturn:
        self.print_usage(sys.stderr)
        _print_error(2, message=f"{self.prog}: {message}")
        self.exit(2, f"{coloured(self.prog, 'bad', sys.stderr)}: {message}\n")


def nearest(word: str, known: Iterable[str]) -> str:
    """A question that names the known word that is most like a mistyped one; "" where none is."""
    from difflib import get_close_matches  # who types well does without it

    near = get_close_matches(word, list(known), 1)
    return f" Did you mean {near[0]}?" if near else ""


def parsers_of(whole: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """``whole``, then its commands, each followed by its own."""
    yield whole
    for action in whole._actions:
        if isinstance(action, SubCommands):
            action.load()
            for name in action.modules:
                yield from parsers_of(action.choices[name])


def add_group(commands: Commands, name: str, summary: str, package: str, names: Names, epilog: str = "") -> Any:
    """A command whose own commands are in the modules of a package; its parser."""
    parser = commands.add_parser(name, help=summary, description=summary, epilog=epilog or None)
    add_subcommands(parser, package, names)
    return parser


def add_subcommands(parser: argparse.ArgumentParser, package: str, names: Names) -> None:
    """Let a module of the package add the parser of each name when it is asked for.

    names : in the order of the help; or each name to its module, where several share one. Otherwise the module has the
    name of its command.
    """
    commands: Any = parser.add_subparsers(title="commands", required=True, metavar="COMMAND", action=SubCommands)
    of = names if isinstance(names, Mapping) else {name: name for name in names}
    commands.modules = {name: f"{package}.{module}" for name, module in of.items()}


def add_command(
    commands: Commands, name: str, run: Any, summary: str, epilog: str = "", options: str = "", /, types: Types = None,
    **more: dict[str, Any],
) -> argparse.ArgumentParser:  # fmt: skip
    """A sub-command whose help opens with its one-line summary; its options are as for `add_options`."""
    after = " ".join(epilog.split()) or None
    parser: argparse.ArgumentParser = commands.add_parser(name, help=summary, description=summary, epilog=after)
    parser.set_defaults(run=run, parser=parser)
    add_options(parser, VOICES + options, types, **more)
    return parser


VOICES = """
-q --quiet  leave out progress and notes
-v --verbose  say more: reasons, and where in the program an error arose
"""
JSON = "--json  print the result as JSON\n"
TYPES: Mapping[str, Any] = {
    **dict.fromkeys(("DIR", "FOLDER", "FILE", "STUDY"), Path), **dict.fromkeys(("X", "HZ", "S"), float),
}  # fmt: skip
"""What makes the value of an option from its text, by the word that stands for it in the help."""


def add_options(parser: Group, table: str, /, types: Types = None, **more: dict[str, Any]) -> None:
    """Options and arguments from a table, such as ``--work DIR = .  folder of results``.

    table : one a row: its names, its value, two blanks, its help; an indented row goes on with the help. Without a
    value it is a switch. ``= X`` after the value is the default; ``VALUE...`` may be repeated; ``{a,b}`` lists all
    values. An argument is written ``files FILE...``; ``[FILE]`` may be left out, and so may ``[FILE...]``.
    types : the word that stands for a value to its type, beside `TYPES`. more : keywords of ``add_argument`` by name.
    """
    for row in filter(None, re.split(r"\n(?! )", table)):
        spec, _, text = row.partition("  ")
        spec, _, default = spec.partition(" = ")
        *names, value = spec.split() if not spec.split()[-1].startswith("-") else [*spec.split(), ""]
        option, bare = names[0].startswith("-"), value.strip("[].")
        given: dict[str, Any] = {"help": " ".join(text.split())}
        if not value:
            given["action"] = "store_true"
        elif value.startswith("{"):
            given["choices"] = tuple(bare.strip("{}").split(","))
        else:
            given |= {"metavar": bare, "type": {**TYPES, **(types or {})}.get(bare)}
        if value.endswith(("...", "...]")):
            given |= {"action": "append", "default": []} if option else {"nargs": "*" if value[0] == "[" else "+"}
        elif value.startswith("["):
            given["nargs"] = "?"
        given |= {"default": default} if default else {}
        parser.add_argument(*names, **given | more.get(names[-1].lstrip("-").replace("-", "_"), {}))


def add_json(parser: Group) -> None:
    """Output for programs."""
    add_options(parser, JSON)


def answer(as_json: bool, value: object, lines: Iterable[str]) -> None:
    """The result of a command: its value for programs, or its lines for people."""
    if as_json:
        print_json(value)
    else:
        for line in lines:
            print(line)


def print_json(value: object) -> None:
    """JSON with sorted keys; a number that is not finite becomes null, which every reader knows."""
    print(json.dumps(finite(value), indent=2, sort_keys=True))


def wanted(what: str, parse: Callable[[str], Any]) -> Callable[[str], Any]:
    """For argparse: what ``parse`` makes of a text. A text of which that is None or a ValueError is refused."""

    def value(text: str) -> Any:
        try:
            found = parse(text)
        except ValueError:
            found = None
        if found is None:
            raise argparse.ArgumentTypeError(f"expected {what}, but found {text!r}")
        return found

    return value


def whole(low: int, high: float = float("inf")) -> Callable[[str], int | None]:
    """What makes a whole number within limits of a text, for `wanted`."""
    return lambda text: int(text) if text.isdecimal() and low <= int(text) <= high else None


whole_number = wanted("a whole number from 1", whole(1))


SHELLS = ("bash", "zsh", "tcsh")


def command_of(name: str, above: str = "") -> Callable[[Commands], None]:
    """Adds the command ``completion`` to the program ``name``, whose module ``<name>.cli`` holds it as ``PROGRAM``.

    above : the words before it, where it is a command of a group.
    """
    summary = "Print the completion of commands, options and files for a shell."
    epilog = f"""bash: {above or name} completion bash > ~/.local/share/bash-completion/completions/{name}. zsh: write
        it as _{name} into a folder of $fpath. Open a new shell afterwards."""

    def add_to(commands: Commands) -> None:
        add_command(commands, "completion", run, summary, epilog, f"shell {{{','.join(SHELLS)}}}\n{JSON}")

    def run(arguments: argparse.Namespace) -> int:
        script = completion(import_module(f"{name}.cli").PROGRAM, arguments.shell)
        answer(arguments.json, {"shell": arguments.shell, "script": script}, [script])
        return 0

    return add_to


def completion(program: Program, shell: str) -> str:
    """The script for one of `SHELLS`."""
    import shtab

    whole = program.parser()
    for parser in parsers_of(whole):
        for action in parser._actions:
            if action.type is Path:
                action.complete = shtab.DIRECTORY if action.metavar in ("DIR", "FOLDER") else shtab.FILE  # type: ignore[attr-defined]
            elif isinstance(action, argparse._SubParsersAction):
                action.metavar = None  # shtab takes it for a value to complete
    return str(shtab.complete(whole, shell))
