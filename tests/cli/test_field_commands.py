"""The commands are tested as a user runs them, in test_main.py; here, that they are all there."""

import click

from geoweave.cli import field_commands, main


def test_the_command_line_offers_both_commands() -> None:
    context = click.Context(main.commands)
    assert main.commands.get_command(context, "field") is field_commands.field
    assert main.commands.get_command(context, "foliate") is field_commands.foliate
