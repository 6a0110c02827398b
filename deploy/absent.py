#!/usr/bin/env python3
"""Cost of features that a job does not use: a scene with and without a feature, in alternation.

    deploy/absent.py PROGRAM [--against OLDER_PROGRAM] [--rounds N] > cases/bench/ABSENT.md

A pair of runs has the same mesh and the same number of cycles. The table has the ratio of their CPU
times (median over the rounds), its range, and the ratio of the shortest times, which a busy machine
disturbs least. With --against, scenes of solids are run by an older program too.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

QUIET = ["output.field_interval=-1", "output.field_times=[]"]
NO_COPIES = ["checkpoint.every=off", "checkpoint.in_memory=off"]
# Scene, cycles, name of the absent feature, settings without it, settings with it.
PAIRS = [
    ("plate", 2000, "contact", [], ["contact.friction=0.0"]),
    ("can-crush", 1000, "friction: mu = 0 against 0.1", ["contact.friction=0.0"], []),
    (
        "can-crush",
        1000,
        "rates: none against Cowper-Symonds",
        [],
        ["material.mild steel.cowper_symonds=[3.2, 5.0]"],
    ),
    ("tumble", 10000, "checkpoints and copies in memory", NO_COPIES, []),
    ("can-crush", 1000, "checkpoints and copies in memory", NO_COPIES, []),
    ("tube-crush", 3000, "checkpoints and copies in memory", NO_COPIES, []),
    ("pipe-whip", 6000, "checkpoints and copies in memory", NO_COPIES, []),
    ("jeep-frame", 2000, "checkpoints and copies in memory", NO_COPIES, []),
]
# Scenes of solids alone, for --against. They are long enough that elements at rest, which cost
# less, do not matter.
SOLIDS = [("brick-wall", 1000), ("can-crush", 1000)]

HEAD = """\
# Cost of features that a job does not use

A feature that a job does not use must cost nothing. Written by `deploy/absent.py`: CPU time, one
worker, {rounds} rounds. The runs without and with the feature alternate.

A ratio below 1 is the cost of the feature where it is used. A ratio above 1 is noise. The range
shows the size of the noise.

| scene | absent | CPU time without / with, median | range | of the shortest | seconds in contact \
without, with |
|---|---|---|---|---|---|"""


def run(program, scene, cycles, sets):
    """Summary of a run with one worker."""
    with tempfile.TemporaryDirectory() as out:
        command = [program, "run", f"cases/{scene}", "--workers", "1", "--out", out]
        for s in [f"time.max_cycles={cycles}", *QUIET, *sets]:
            command += ["--set", s]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}\n{done.stderr}")
        return json.loads((Path(out) / "summary.json").read_text())


def spread(values):
    """Median and range as cells of a table."""
    values = sorted(values)
    return f"{statistics.median(values):.3f} | {values[0]:.3f} to {values[-1]:.3f}"


def compare(one, other, rounds):
    """CPU time ratios of two alternating runs as cells of a table, and the last two summaries."""
    ratios, times = [], ([], [])
    for number in range(rounds):
        # The first one changes, so that not always the same one has the warmer machine.
        order = (one, other) if number % 2 == 0 else (other, one)
        done = {id(job): run(*job) for job in order}
        first, second = done[id(one)], done[id(other)]
        for column, summary in zip(times, (first, second)):
            column.append(summary["cpu_s"]["total"])
        ratios.append(times[0][-1] / times[1][-1])
    return f"{spread(ratios)} | {min(times[0]) / min(times[1]):.3f}", first, second


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("program")
    parser.add_argument("--against")
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args()
    print(HEAD.format(rounds=args.rounds))
    for scene, cycles, what, less, more in PAIRS:
        ratios, first, second = compare(
            (args.program, scene, cycles, less), (args.program, scene, cycles, more), args.rounds
        )
        spent = [
            sum(s["phase_s"][p]["mean"] for p in ("search", "local", "contact"))
            for s in (first, second)
        ]
        print(f"| {scene} | {what} | {ratios} | {spent[0]:.3f}, {spent[1]:.3f} |", flush=True)
    if not args.against:
        return
    print(
        "\nSolids alone have no rotations. This version against one that stored, updated and summed"
    )
    print("rotations for all nodes.\n")
    print("| scene | CPU time now / then, median | range | of the shortest | same digest |")
    print("|---|---|---|---|---|")
    for scene, cycles in SOLIDS:
        ratios, now, then = compare(
            (args.program, scene, cycles, []), (args.against, scene, cycles, []), args.rounds
        )
        same = "yes" if now["state_digest"] == then["state_digest"] else "NO"
        print(f"| {scene} | {ratios} | {same} |", flush=True)


if __name__ == "__main__":
    main()
