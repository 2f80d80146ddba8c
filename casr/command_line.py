"""A program of sub-commands: one module each, heavy imports only in the one that runs; and its reference page."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import partial
from typing import Any, NoReturn

from casr.errors import UserError
from casr.json_text import finite as finite
from casr.one_thread import one_thread
from casr.terminal import VOICE, coloured

Group = argparse._ActionsContainer  # a parser or a group of its options
Commands = Any  # argparse gives its collection of sub-parsers no public type

PAGE_COLUMNS = 100
"Of the help; a terminal's own width must not change the page."
PAGE_HEAD = """# The commands of {name}

Written by `python -m {name}.cli.reference`; do not edit. The same text is in `{name} COMMAND --help`.

| exit status | meaning |
|---|---|
| 0 | done |
| 1 | done, but something is not good; the help of the command says what |
| 2 | unusable input ({inputs}), said in one line for each problem |
| 130 | stopped with Ctrl-C; what was finished is kept |

Results go to the standard output; progress, notes and complaints to the error stream. With `--json` the standard output
holds one JSON value.
"""


@dataclass(frozen=True, kw_only=True)
class Program:
    """A program and its sub-commands.

    Parameters
    ----------
    name : as typed. Module ``<name>.cli.<command>`` adds its parser in ``add_to(commands)``, with its work as ``run``.
    version, description, epilog : for ``--version`` and ``--help``; the exit statuses are added to the epilog.
    commands : in the order of the help.
    stopped : what Ctrl-C leaves, said after it.
    extras : library to the extra of the package that installs it.
    """

    name: str
    version: str
    description: str
    epilog: str
    commands: tuple[str, ...]
    stopped: str
    extras: Mapping[str, str] = field(default_factory=dict)

    def main(self, argv: Sequence[str] | None = None) -> int:
        """Run one sub-command; returns the exit status: 0 done, 1 something is not good, 2 unusable input."""
        one_thread()
        words = sys.argv[1:] if argv is None else argv
        only = [name for name in words[:1] if name in self.commands]
        try:
            arguments = self.parser(only or self.commands).parse_args(words)
            VOICE.quiet, VOICE.verbose = arguments.quiet, arguments.verbose
            status: int = arguments.run(arguments)
            sys.stdout.flush()
            return status
        except UserError as error:
            self._complain(error.told_by(self.name))
        except ModuleNotFoundError as error:
            library = str(error.name).partition(".")[0]
            if library not in self.extras:
                raise
            do = f'Install it: pip install "emg2vsa[{self.extras[library]}]".'
            self._complain(f"{self.name}: expected the library {library}, but found none. {do}")
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        except OSError as error:
            self._complain(f"{self.name}: {error.filename or 'input or output'}: {error.strerror or error}")
        except KeyboardInterrupt:
            print(f"\nStopped. {self.stopped}", file=sys.stderr)
            return 130
        return 2

    def _complain(self, text: str) -> None:
        """The error that is being handled, for a person; with ``-v`` where it arose."""
        if VOICE.verbose:
            traceback.print_exc()
        name, colon, rest = text.partition(": ")
        known = colon and name == self.name
        print(f"{coloured(name, 'bad', sys.stderr)}: {rest}" if known else text, file=sys.stderr)

    def parser(self, names: Sequence[str] = ()) -> argparse.ArgumentParser:
        """The parser of the whole command line, or of these commands only."""
        whole = Parser(
            prog=self.name,
            description=self.description,
            epilog=f"{self.epilog} Exit status: 0 done; 1 something is not good; 2 unusable input, nothing was done; "
            "130 stopped.",
        )
        whole.add_argument("--version", action="version", version=f"{self.name} {self.version}")
        add_subcommands(whole, f"{self.name}.cli", names or self.commands)
        return whole

    def reference_page(self, inputs: str) -> str:
        """Help of every command as Markdown. inputs : what can be unusable."""
        parts = []
        for parser in parsers_of(self.parser()):
            parser.formatter_class = partial(argparse.HelpFormatter, width=PAGE_COLUMNS)  # type: ignore[assignment]
            parts.append(f"\n## `{parser.prog}`\n\n```text\n{parser.format_help()}```\n")
        return PAGE_HEAD.format(name=self.name, inputs=inputs) + "".join(parts)


class Parser(argparse.ArgumentParser):
    """A parser that names the nearest word to a mistyped command, option or choice."""

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        found, left = self.parse_known_args(args, namespace)
        if left:
            parser: argparse.ArgumentParser = getattr(found, "parser", self)
            options = list(parser._option_string_actions)
            near = [_hint(word.partition("=")[0], options, parser.prog) for word in left if word.startswith("-")]
            parser.error(f"unrecognized arguments: {' '.join(left)}.{''.join(near)}")
        return found

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            known = [str(each) for each in action.choices]
            listed = f"expected one of {', '.join(known)}, but found {str(value)!r}.{nearest(str(value), known)}"
            raise argparse.ArgumentError(action, listed)

    def error(self, message: str) -> NoReturn:
        self.print_usage(sys.stderr)
        self.exit(2, f"{coloured(self.prog, 'bad', sys.stderr)}: {message}\n")


def _hint(word: str, options: Sequence[str], command: str) -> str:
    """What to do about a word that is no option, or that stands where it is none."""
    return f" Write {word} after {command}." if word in options else nearest(word, options)


def nearest(word: str, known: Iterable[str]) -> str:
    """A question that names the known word that is most like a mistyped one; "" where none is."""
    near = get_close_matches(word, list(known), 1)
    return f" Did you mean {near[0]}?" if near else ""


def parsers_of(whole: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """``whole``, then its commands, each followed by its own."""
    yield whole
    for action in whole._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from parsers_of(command)


def add_subcommands(parser: argparse.ArgumentParser, package: str, names: Sequence[str]) -> None:
    """Let the module ``<package>.<name>`` of each name, with _ for -, add its parser."""
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name in names:
        importlib.import_module(f"{package}.{name.replace('-', '_')}").add_to(commands)


def add_command(commands: Commands, name: str, run: Any, summary: str, epilog: str = "") -> argparse.ArgumentParser:
    """A sub-command whose help opens with its one-line summary."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=summary, epilog=epilog or None
    )
    parser.set_defaults(run=run, parser=parser)
    parser.add_argument("-q", "--quiet", action="store_true", help="leave out progress and notes")
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="say more: reasons, and where in the program an error arose"
    )
    return parser


def add_json(parser: Group) -> None:
    """Output for programs."""
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def print_json(value: object) -> None:
    """JSON with sorted keys; a number that is not finite becomes null, which every reader knows."""
    print(json.dumps(finite(value), indent=2, sort_keys=True))


def whole_number(text: str) -> int:
    """A whole number from 1, for argparse."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1, but found {text!r}")
    return int(text)
