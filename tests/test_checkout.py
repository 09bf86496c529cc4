"""The folder for figures follows the environment, and the checkout where nothing is set."""

from pathlib import Path

import pytest

from geoweave.checkout import FIGURES_VARIABLE, figures_folder, repository
from geoweave.errors import GeoweaveError

ROOT = Path(__file__).resolve().parent.parent


def test_the_variable_names_the_base_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(FIGURES_VARIABLE, str(tmp_path))
    assert figures_folder() == tmp_path
    assert figures_folder("default") == tmp_path
    assert figures_folder("paper") == tmp_path / "paper"
    assert not (tmp_path / "paper").exists()


def test_by_hand_it_is_the_checkout(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(FIGURES_VARIABLE, raising=False)
    monkeypatch.chdir(ROOT / "tests")
    assert repository() == ROOT
    assert figures_folder() == ROOT / "figures"
    monkeypatch.chdir(tmp_path)
    assert figures_folder("paper") == ROOT / "figures" / "paper"


@pytest.mark.parametrize("name", ["", "../outside", "a/b"])
def test_a_profile_is_a_plain_word(name: str) -> None:
    with pytest.raises(GeoweaveError, match="no name of a profile"):
        figures_folder(name)
