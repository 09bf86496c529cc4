"""The commands are tested as a user runs them, in test_main.py; here, that they are all there."""

import click
import pytest

from geoweave.cli import artifact_commands, main


@pytest.mark.parametrize("name", ["doctor", "fetch", "figures"])
def test_the_command_line_offers_every_command(name: str) -> None:
    found = main.commands.get_command(click.Context(main.commands), name)
    assert found is getattr(artifact_commands, name)
