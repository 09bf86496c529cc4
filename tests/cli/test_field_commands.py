"""The commands that design are tested as a user runs them, in test_cli.py; here, that they are all there."""

from geoweave import cli, design


def test_the_command_line_offers_every_designing_command() -> None:
    assert cli.commands.commands["field"] is design.field
    assert cli.commands.commands["foliate"] is design.foliate
