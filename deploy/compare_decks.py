#!/usr/bin/env python3
"""Compares the results of `crumple check` on keyword decks with an independent reader, dynars.

    deploy/compare_decks.py CRUMPLE DECK...

Nodes, elements and numbers of materials must be equal. dynars 0.x reads only one part of a *PART
with several blocks, and none with a blank heading. So each part of dynars must be a part of
Crumple. Exit code 1 at a difference, 3 without dynars. Needs `pip install dynars`.
"""

import re
import subprocess
import sys

try:
    import dynars
except ImportError:
    print("dynars is missing: pip install dynars")
    sys.exit(3)


def ours(crumple, deck):
    """Counts of nodes and elements, ids of parts and of untitled materials.

    From the output of `crumple check`.
    """
    text = subprocess.run(
        [crumple, "check", deck], check=True, capture_output=True, text=True
    ).stdout
    elements = re.search(r"^elements +(.*)$", text, re.M).group(1)
    table = re.search(r"^ +part +name .*\n((?: +\d+ .*\n)+)", text, re.M).group(1)
    return {
        "nodes": int(re.search(r"^nodes +(\d+)", text, re.M).group(1)),
        "elements": sum(int(n) for n in re.findall(r"\d+", elements)),
        "parts": {int(line.split()[0]) for line in table.splitlines()},
        "materials": {int(n) for n in re.findall(r" mat-(\d+) ", table)},
    }


def theirs(deck):
    """The same from dynars."""
    read = dynars.parse_deck(deck)
    counts = dict(read.definition_counts())
    number = lambda entities: {
        int(re.search(r"\((?:Part|Material) (\d+)", str(e)).group(1)) for e in entities
    }
    return {
        "nodes": counts["Node"],
        "elements": counts["Element"],
        "parts": number(read.parts()),
        "materials": number(read.materials()),
    }


def main():
    crumple, decks = sys.argv[1], sys.argv[2:]
    wrong = 0
    for deck in decks:
        own, other = ours(crumple, deck), theirs(deck)
        same = {key: own[key] == other[key] for key in ("nodes", "elements", "materials")}
        same["parts"] = other["parts"] <= own["parts"]
        wrong += not all(same.values())
        for key in own:
            print(
                f"{deck}: {key} {own[key]}, dynars {other[key]}{'' if same[key] else ' DIFFERENT'}"
            )
    return 1 if wrong or not decks else 0


if __name__ == "__main__":
    sys.exit(main())
