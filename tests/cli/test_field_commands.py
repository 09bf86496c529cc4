"""The commands that design are tested as a user runs them, in test_cli.py; here, that they are all there."""

from geoweave.cli import field_commands, main


def test_the_command_line_offers_every_designing_command() -> None:
    assert main.commands.commands["field"] is field_commands.field
    assert main.commands.commands["foliate"] is field_commands.foliate
