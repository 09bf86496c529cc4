"""Run the benchmarks: ``python -m benchmarks [--largest SUBDIVISIONS]``."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from benchmarks import imports, rods, scans

SMALLEST = 5


def child(module: str, *arguments: str) -> dict:
    """Run one measurement in a process of its own, so that its peak memory is its own."""
    command = [sys.executable, "-m", f"benchmarks.{module}", *arguments]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)


def growth(largest: int) -> dict:
    print("Algorithm 1 on spheres, default schedule, from the smoothest field; seconds of wall clock.")
    print("The limit is one factorisation of the mesh's cotan Laplacian and as many solves with it.\n")
    print(
        f"{'faces':>9} {'start':>7} {'total':>7} {'set-up':>7} {'factor':>7} {'steps':>7} {'n':>4} "
        f"{'limit':>7} {'multiple':>8} {'memory':>8} {'curl':>7}"
    )
    rows = []
    for subdivisions in range(SMALLEST, largest + 1):
        row = child("algorithm1", str(subdivisions))
        rows.append(row)
        print(
            f"{row['faces']:>9,} {row['start']:>7.2f} {row['total']:>7.2f} {row['setup']:>7.2f} "
            f"{row['factor']:>7.2f} {row['steps']:>7.2f} {row['iterations']:>4} {row['limit']:>7.2f} "
            f"{row['multiple']:>7.1f}x {row['memory_gb']:>5.2f} GB {row['curl']:>7.3f}",
            flush=True,
        )
    faces, total = np.array([[row["faces"], row["total"]] for row in rows]).T
    exponent = float(np.polyfit(np.log(faces), np.log(total), 1)[0]) if len(rows) > 1 else float("nan")
    print(f"\ngrowth of the total: faces to the power {exponent:.2f}")
    print("start: smoothest field, not in the total; set-up: operators and ordering; factor runs beside the")
    print("steps, so that the total is less than the sum of its parts; n: linear systems solved.\n")
    return {"rows": rows, "exponent": exponent}


def against_kkt() -> list[dict]:
    print("One delta step: the reduced system against the paper's KKT system, both by SuperLU.")
    print(f"{'faces':>9} {'unknowns':>20} {'seconds':>20} {'ratio':>7} {'fill':>22} {'difference':>11}")
    rows = []
    for subdivisions in (3, 4, 5):
        row = child("kkt", str(subdivisions))
        rows.append(row)
        print(
            f"{row['faces']:>9,} {row['reduced']['unknowns']:>9,} / {row['kkt']['unknowns']:>8,} "
            f"{row['reduced']['seconds']:>9.3f} / {row['kkt']['seconds']:>8.3f} {row['ratio']:>6.1f}x "
            f"{row['reduced']['fill']:>10,} / {row['kkt']['fill']:>10,} {row['difference']:>10.0e}",
            flush=True,
        )
    return rows


def foliations(sizes: tuple[int, ...] = (7_500, 30_000, 120_000)) -> list[dict]:
    print("\nField, s and theta on a surface of genus 4; seconds of wall clock, and the share of each stage.")
    print("The limit of s and theta is as many factorisations of the cotan Laplacian and solves with it.\n")
    stages = ("smoothest", "geodesic", "puncture", "rescaling", "joint")
    print(
        f"{'faces':>9} {'total':>8} "
        + " ".join(f"{stage:>9}" for stage in stages)
        + f" {'limit':>7} {'multiple':>8} {'memory':>8} {'deviation':>9} {'s_min':>6}"
    )
    rows = []
    for size in sizes:
        row = child("foliation", str(size))
        rows.append(row)
        print(
            f"{row['faces']:>9,} {row['total']:>6.2f} s "
            + " ".join(f"{row[stage] / row['total']:>9.0%}" for stage in stages)
            + f" {row['limit']:>7.2f} {row['multiple']:>7.1f}x {row['memory_gb']:>5.2f} GB "
            f"{row['median_deviation_deg']:>9.2f} {row['s_min']:>6.3f}",
            flush=True,
        )
    return rows


COVER_LIMITS = {5_600: (5.0, 3.0, 42.0), 30_000: (40.0, 3.0, 794.0)}
"""Faces of the bunny: seconds and gigabytes allowed, and CPU seconds of the authors' code."""


def covers() -> list[dict]:
    print("\nFrom RoSy to crossings on bunnies, sixfold cover; seconds of wall clock (and of CPU).")
    print("The limit of s and theta: as many factorisations of their cotan Laplacian and solves with it.\n")
    stages = ("rosy", "cover", "field", "foliation", "ribbons", "interlacing")
    print(
        f"{'faces':>7} {'wall':>8} {'CPU':>8} {'allowed':>8} {'share':>6} "
        + " ".join(f"{stage:>11}" for stage in stages)
        + f" {'multiple':>8} {'memory':>8} {'authors, CPU':>12}"
    )
    rows = []
    for faces, (seconds, gigabytes, authors) in COVER_LIMITS.items():
        row = child("cover", str(faces))
        row |= {"allowed": seconds, "allowed_gb": gigabytes, "authors_cpu": authors}
        rows.append(row)
        print(
            f"{row['faces']:>7,} {row['total']:>6.2f} s {row['cpu']:>6.2f} s {seconds:>6.1f} s "
            f"{row['total'] / seconds:>6.0%} "
            + " ".join(f"{row['seconds'][stage] / row['total']:>11.0%}" for stage in stages)
            + f" {row['seconds']['foliation'] / row['limit']:>7.1f}x {row['memory_gb']:>5.2f} GB "
            f"{authors:>10,.0f} s",
            flush=True,
        )
    return rows


def speed(faces: int = 30_000) -> dict:
    row = child("speed", str(faces))
    print(f"\nThe regular weave of a bunny of {faces:,} faces; seconds of CPU.")
    print("The limit of theta and s: four factorisations of their joint matrix and the solves, all in")
    print("double precision.\n")
    print("   phase    total    joint    limit  multiple  factored  crossings")
    for name in ("regular", "free"):
        one = row[name]
        print(
            f"{name:>8} {one['total']:>6.2f} s {one['joint']:>6.2f} s {one['limit']:>6.2f} s "
            f"{one['multiple']:>8.1f}x {one['factorisations']:>9} {one['crossings']:>10,}"
        )
    print(f"theta and s, regular against free: {row['phase_against_free']:.2f}")
    for each in row["searches"]:
        print(f"{each['wanted']} ribbons asked: {each['found']} found, {each['integrations']} integrations")
    return row


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "--largest", type=int, default=8, help="subdivisions of the largest sphere (8: 1.3 M faces)"
    )
    largest = parser.parse_args().largest
    results = {"growth": growth(largest), "kkt": against_kkt(), "foliations": foliations()}
    results["covers"] = covers()
    results["speed"] = speed()
    results["imports"] = imports.table()
    print()
    results["rods"] = rods.table([])
    path = Path("build/bench/results.json")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    print(f"\nwritten to {path}")
    scans.table([*scans.FEW])


if __name__ == "__main__":
    main()
