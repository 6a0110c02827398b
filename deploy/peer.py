#!/usr/bin/env python3
"""Times Crumple and another solver in turns on the same deck, and prints the ratio of each phase.

The other solver is a command in CRUMPLE_PEER. It runs in an empty folder, where `{deck}` in the
command stands for the starter file of a Radioss deck; the engine file lies next to it. The command
has to run starter and engine on one core. Its phases are read from the summary of CPU time that
the engine prints or writes to a file *.out (/MON/ON, which this script adds to the engine file):

    CONTACT SORTING.............: .1625E+03     5.06 %

A solver that prints nothing of the kind is timed as a whole. Crumple reads the same deck and runs
on one core too. The order alternates from round to round; the table has medians over the rounds,
and ratios are medians of the ratios of each round. Exits with 1 if a run fails.
"""

import argparse
import json
import os
import platform
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Phases: a name, those of the engine's summary, and those of Crumple's summary.json.
PHASES = [
    ("elements", ["ELEMENT FORCES"], ["elements"]),
    ("contact search", ["CONTACT SORTING"], ["search", "local"]),
    ("contact forces", ["CONTACT FORCES"], ["contact"]),
    ("the rest", None, None),
]
LINE = re.compile(r"^\s*([A-Z][A-Z ()/]+?)\.{3,}:\s*([0-9.E+-]+)\s+[0-9.]+ %", re.MULTILINE)


class Failed(Exception):
    """A run that failed; the message says which."""


def run(command, folder, name):
    """Runs a command and returns its output and its duration [s]."""
    began = time.perf_counter()
    ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - began
    if ended.returncode != 0:
        last = "\n".join((ended.stdout + ended.stderr).splitlines()[-10:])
        raise Failed(f"{name} ended with {ended.returncode}:\n{last}")
    return ended.stdout, seconds


def peer_times(command, deck, folder):
    """Returns the phases of the other solver [s]; only `total` if it prints none."""
    for file in (deck, deck.with_name(deck.name.replace("_0000", "_0001"))):
        (folder / file.name).write_bytes(file.read_bytes())
    words = [word.replace("{deck}", deck.name) for word in shlex.split(command)]
    text, seconds = run(words, folder, "the other solver")
    for listing in sorted(folder.glob("*.out")):
        text += listing.read_text(errors="replace")
    found = {name.strip(): float(value) for name, value in LINE.findall(text)}
    times = {"total": seconds}
    if found:
        phases = {
            name: sum(found.get(key, 0.0) for key in theirs) for name, theirs, _ in PHASES[:-1]
        }
        rest = max(0.0, found.get("TOTAL", seconds) - sum(phases.values()))
        times |= phases | {"the rest": rest}
    return times


def own_times(binary, deck, folder):
    """Returns the phases of Crumple [s]."""
    asked = [binary, "run", str(deck), "--workers", "1", "--quiet", "--no-report", "--overwrite"]
    _, seconds = run([*asked, "--out", str(folder)], folder, "crumple")
    phases = json.loads((folder / "summary.json").read_text())["phase_s"]
    times = {"total": seconds}
    for name, _, ours in PHASES[:-1]:
        times[name] = sum(phases.get(key, {}).get("mean", 0.0) for key in ours)
    times["the rest"] = seconds - sum(times[name] for name, *_ in PHASES[:-1])
    return times


def processor():
    """Returns the name of the processor and its number of cores."""
    name = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return f"{name}, {os.cpu_count()} cores"


def table(rounds):
    """Returns the table as lines."""
    head = "| phase | crumple [s] | other solver [s] | other solver / crumple |"
    lines = [head, "|---|---|---|---|"]
    for name in ["total", *(name for name, *_ in PHASES)]:
        pairs = [(ours[name], theirs[name]) for ours, theirs in rounds if name in theirs]
        ours = statistics.median(ours[name] for ours, _ in rounds)
        if not pairs:
            lines.append(f"| {name} | {ours:.3f} | - | - |")
            continue
        theirs = statistics.median(b for _, b in pairs)
        ratios = [b / a for a, b in pairs if a > 0.0]
        ratio = f"{statistics.median(ratios):.2f}" if ratios else "-"
        lines.append(f"| {name} | {ours:.3f} | {theirs:.3f} | {ratio} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", nargs="?", default="cases/tube-crush", help="job to time")
    parser.add_argument("--end-time", type=float, help="end of the run, in the units of the job")
    parser.add_argument("--rounds", type=int, default=5, help="runs of each solver (default 5)")
    args = parser.parse_args()
    command, binary = os.environ.get("CRUMPLE_PEER"), os.environ.get("CRUMPLE_BIN", "crumple")
    if not command or "{deck}" not in command:
        sys.exit(
            "peer: ERROR: set CRUMPLE_PEER to the command of the other solver, with {deck} for the"
            " starter file, such as CRUMPLE_PEER='my-radioss.sh {deck}'"
        )
    if args.rounds < 1:
        parser.error("--rounds has to be at least 1")
    load = os.getloadavg()[0]
    if load > 0.5:
        print(f"peer: WARNING: the load of this machine is {load:.1f}; times are not exact",
              file=sys.stderr)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        deck = folder / "PEER_0000.rad"
        try:
            job = args.case
            asked = [binary, "convert", job, str(deck), "--overwrite"]
            if args.end_time is not None:
                asked += ["--set", f"end_time={args.end_time}"]
            said, _ = run(asked, Path.cwd(), "crumple convert")
            engine = folder / "PEER_0001.rad"
            engine.write_text(engine.read_text().rstrip() + "\n/MON/ON\n")
            rounds = []
            for number in range(args.rounds):
                places = [folder / f"{number}-{who}" for who in ("ours", "theirs")]
                for place in places:
                    place.mkdir()
                turns = [
                    lambda: own_times(binary, deck, places[0]),
                    lambda: peer_times(command, deck, places[1]),
                ]
                if number % 2 == 0:
                    ours, theirs = turns[0](), turns[1]()
                else:
                    theirs = turns[1]()
                    ours = turns[0]()
                rounds.append((ours, theirs))
                print(f"peer: round {number + 1} of {args.rounds}: crumple {ours['total']:.2f} s,"
                      f" other solver {theirs['total']:.2f} s", file=sys.stderr)
        except Failed as why:
            print(f"peer: ERROR: {why}", file=sys.stderr)
            return 1
        version, _ = run([binary, "--version"], folder, "crumple")
    print(f"{args.case}, {args.rounds} rounds in turns; {processor()}; {version.strip()}")
    print(f"RUSTFLAGS: {os.environ.get('RUSTFLAGS') or 'those of .cargo/config.toml'}\n")
    print("\n".join(table(rounds)))
    losses = [line for line in said.splitlines() if line.startswith("- ")]
    if losses:
        print("\nWhat the deck does not have as the job has it:")
        print("\n".join(losses))
    return 0


if __name__ == "__main__":
    sys.exit(main())
