"""The `ggo` command: recordings in, gaits out, each checked before it is written."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

import ggo_factors as ggo
from ggo_factors.cli.compare import compare
from ggo_factors.cli.flags import with_flags
from ggo_factors.cli.generate import stairs, step_over, stride, walk
from ggo_factors.cli.learn import learn
from ggo_factors.cli.logs import convert, export, import_command, inspect
from ggo_factors.cli.plan import plan
from ggo_factors.cli.plot import plot
from ggo_factors.cli.report import report
from ggo_factors.cli.see import see
from ggo_factors.cli.sweep import sweep
from ggo_factors.cli.verify import verify
from ggo_factors.support.files import printable

EXIT_OTHER, EXIT_INPUT, EXIT_UNSAFE = 1, 2, 3
"""Exit codes of whatever else went wrong, of bad input, and of no safe gait."""


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(ggo.__version__, prog_name="ggo")
def cli() -> None:
    """Variable gaits for lower-limb exoskeletons, bent from one recorded base gait.

    BASE is a gait file (CSV), a file of base gaits for each leg (`import --leg each`), or the word `paper` for the base
    gait of the paper. Lengths are in metres, in the body
    frame of the step: origin at the ankle of the supporting foot, x forward.

    Exit codes: 0 done, 2 bad input, 3 no safe gait, 1 anything else.

    Completion by the Tab key, a line in your shell's start file: eval "$(_GGO_COMPLETE=bash_source ggo)" for bash,
    zsh_source for zsh; _GGO_COMPLETE=fish_source ggo | source for fish.
    """


for command in (
    import_command,
    learn,
    stride,
    step_over,
    stairs,
    walk,
    plan,
    verify,
    inspect,
    plot,
    report,
    convert,
    export,
    compare,
    see,
    sweep,
):
    cli.add_command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; every error is one line on stderr and an exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        result = cli.main(args=arguments, prog_name="ggo", standalone_mode=False)
        return result if isinstance(result, int) else 0
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.exceptions.NoArgsIsHelpError as help_text:
        click.echo(help_text.format_message(), err=True)
        return EXIT_INPUT
    except click.ClickException as error:
        return _fail(error.format_message(), EXIT_INPUT)
    except click.Abort:
        return _fail("stopped", EXIT_OTHER)
    except ggo.InfeasibleGaitError as error:
        return _fail(with_flags(str(error), cli, given), EXIT_UNSAFE)
    except (ggo.InputError, ggo.LogError) as error:
        return _fail(with_flags(str(error), cli, given), EXIT_INPUT)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_OTHER
    except Exception as error:
        if os.environ.get("GGO_DEBUG"):
            raise
        return _fail(f"{type(error).__name__}: {error} (GGO_DEBUG=1 shows where)", EXIT_OTHER)


def _fail(message: str, code: int) -> int:
    click.echo("ggo: " + printable(" ".join(message.split())), err=True)
    return code
