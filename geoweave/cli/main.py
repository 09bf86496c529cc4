"""The ``geoweave`` command, a contract that others script against.

Results go to stdout, progress to stderr and only if that is a terminal; ``--json`` prints one JSON object
and nothing else. Exit status 0: done; 2: bad usage or bad input, with one line on stderr that names the file,
what is wrong and what to do; 130: interrupted; 1: anything else. Heavy imports wait until a command needs
them.
"""

from __future__ import annotations

import importlib
import io
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress

import click

from geoweave.errors import GeoweaveError, RenderError

INTERRUPTED = 130
"""Exit status after Ctrl-C: 128 and the number of the signal, as shells have it."""

COMMANDS = {
    "cut": "cut_command",
    "doctor": "artifact_commands",
    "edit": "edit_command",
    "fetch": "artifact_commands",
    "field": "field_commands",
    "figures": "artifact_commands",
    "foliate": "field_commands",
    "info": "info_command",
    "relax": "relax_command",
    "show": "show_command",
    "sweep": "sweep_command",
    "twin": "twin_command",
    "weave": "weave_command",
}
"""The module of each command, which is imported when the command is called or its help is asked for."""


class LazyGroup(click.Group):
    """Commands that are imported when they are needed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of all commands."""
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of a name, None if there is none."""
        if cmd_name not in COMMANDS:
            return None
        found = getattr(importlib.import_module(f"geoweave.cli.{COMMANDS[cmd_name]}"), cmd_name)
        assert isinstance(found, click.Command)
        return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status; ``arguments`` default to those of the process."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a file name must not break a result
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    try:
        with commands.make_context("geoweave", list(arguments)) as context:
            commands.invoke(context)
        sys.stdout.flush()
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx is not None else "geoweave"
        return _refuse(f"{error.format_message().rstrip('.')}; see '{command} --help'", 2)
    except click.ClickException as error:
        return _refuse(error.format_message(), 2)
    except RenderError as error:
        return _refuse(str(error), 1)
    except GeoweaveError as error:
        return _refuse(str(error), 2)
    except KeyboardInterrupt:
        # A second Ctrl-C must not break in on what tidies up.
        with suppress(ValueError):  # only the main thread may say so
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        return _refuse("interrupted; no file was left half-written", INTERRUPTED)
    except BrokenPipeError:
        # the reader of our output went away; the interpreter must not complain about it when it ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except MemoryError:
        return _refuse("not enough memory; ask for fewer triangles with --faces", 1)
    except Exception:
        import traceback

        traceback.print_exc()
        return _refuse("this is a fault of geoweave; please report it with the lines above", 1)
    return 0


def _refuse(message: str, status: int) -> int:
    line = " ".join(message.split())
    print(f"geoweave: {line}", file=sys.stderr)
    return status


def _version(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted:
        from geoweave.checkout import package_version

        click.echo(f"geoweave {package_version()}")
        context.exit()


@click.group(cls=LazyGroup, no_args_is_help=False, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_version, help="Print the version."
)
def commands() -> None:
    """Geodesic fields, foliations and weaves on triangle meshes."""
