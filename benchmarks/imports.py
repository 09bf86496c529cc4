"""Measure what starting costs: commands in new processes, as multiples of ``import numpy``."""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time

COMMANDS = {
    "import numpy": ("-c", "import numpy"),
    "geoweave --version": ("-m", "geoweave", "--version"),
    "geoweave info bunny": ("-m", "geoweave", "info", "bunny"),
}
"""What is run, by what it is called; the first is the measure of the others."""

ALLOWED = {"geoweave --version": 2.0, "geoweave info bunny": 4.0}
"""Multiples of ``import numpy`` that each may take at most."""

ROUNDS = 7


def seconds(arguments: tuple[str, ...]) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def measured(rounds: int = ROUNDS) -> list[dict]:
    """Medians over several rounds, in each of which every command runs once, so that load falls on all."""
    for arguments in COMMANDS.values():
        seconds(arguments)  # files come from memory from here on
    taken = [{name: seconds(arguments) for name, arguments in COMMANDS.items()} for _ in range(rounds)]
    middle = {name: statistics.median(each[name] for each in taken) for name in COMMANDS}
    measure = middle["import numpy"]
    return [
        {"command": name, "seconds": value, "multiple": value / measure, "allowed": ALLOWED.get(name)}
        for name, value in middle.items()
    ]


def table(rounds: int = ROUNDS) -> list[dict]:
    print(f"\nStarting, in a new process each; medians of {rounds} rounds, multiples of 'import numpy'.\n")
    print(f"{'command':<20} {'seconds':>8} {'multiple':>9} {'allowed':>8}")
    rows = measured(rounds)
    for row in rows:
        allowed = "" if row["allowed"] is None else f"{row['allowed']:.0f}x"
        print(f"{row['command']:<20} {row['seconds']:>6.2f} s {row['multiple']:>8.1f}x {allowed:>8}")
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.imports", description=__doc__)
    parser.add_argument("--rounds", type=int, default=ROUNDS, help=f"measurements of each ({ROUNDS})")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    arguments = parser.parse_args()
    if arguments.json:
        print(json.dumps(measured(arguments.rounds)))
    else:
        table(arguments.rounds)


if __name__ == "__main__":
    main()
