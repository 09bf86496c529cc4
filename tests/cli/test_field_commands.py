"""The commands are tested as a user runs them, in test_main.py; here, that they are all there."""

import click

from geoweave.cli import field_commands, main
from geoweave.cli.field_commands import curl_text


def test_the_command_line_offers_both_commands() -> None:
    context = click.Context(main.commands)
    assert main.commands.get_command(context, "field") is field_commands.field
    assert main.commands.get_command(context, "foliate") is field_commands.foliate


def test_it_is_said_when_total_curl_rose() -> None:
    assert curl_text(0.07234, 0.09826).startswith("0.0723 -> 0.0983: it rose")
    assert curl_text(12.45, 5.746) == "12.4500 -> 5.7460"
    assert curl_text(1e-15, 1e-9) == "0.0000 -> 0.0000"
