"""The end of a run says what was made and what failed."""

from geoweave.artifact.results import Result, summary


def test_the_end_says_what_was_made() -> None:
    results = [
        Result("a", "paper", "done", figures=("paper/a.png", "paper/a.csv", "paper/a.json")),
        Result("b", "paper", "fresh", figures=("paper/b.png",)),
        Result("c", "paper", "failed", problem="cell In[3]: AssertionError"),
    ]
    assert summary(results, "paper", 245.3).splitlines() == [
        "3 notebooks in 4:05 min: 1 executed, 1 up to date, 1 failed",
        "2 pictures and 1 tables lie in figures/paper/ (all: figures/INDEX.md)",
        "failed: c: cell In[3]: AssertionError",
    ]
