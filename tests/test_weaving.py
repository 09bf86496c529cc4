"""The command that weaves is tested as a user runs it, in test_cli.py; here, that it is there."""

from geoweave import cli, weaving


def test_the_command_line_offers_the_command() -> None:
    assert cli.commands.commands["weave"] is weaving.weave
