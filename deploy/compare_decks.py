#!/usr/bin/env python3
"""Compares what `crumple check` makes of keyword decks with what an independent reader, dynars, finds in them.

    deploy/compare_decks.py CRUMPLE DECK...

Nodes, elements and numbers of materials have to be the same. dynars 0.x reads one part of a *PART with several blocks, and
none under a blank heading: its parts have to be among ours. Ends with 1 if anything differs, with 3 without dynars. Needs `pip install dynars`.
"""

import re
import subprocess
import sys

try:
    import dynars
except ImportError:
    print("there is no dynars: pip install dynars")
    sys.exit(3)


def ours(crumple, deck):
    """Counts of nodes and elements, ids of parts, numbers of untitled materials, as `crumple check` prints them."""
    text = subprocess.run([crumple, "check", deck], check=True, capture_output=True, text=True).stdout
    elements = re.search(r"^elements +(.*)$", text, re.M).group(1)
    table = re.search(r"^ +part +name .*\n((?: +\d+ .*\n)+)", text, re.M).group(1)
    return {
        "nodes": int(re.search(r"^nodes +(\d+)", text, re.M).group(1)),
        "elements": sum(int(n) for n in re.findall(r"\d+", elements)),
        "parts": {int(line.split()[0]) for line in table.splitlines()},
        "materials": {int(n) for n in re.findall(r" mat-(\d+) ", table)},
    }


def theirs(deck):
    """The same by dynars."""
    read = dynars.parse_deck(deck)
    counts = dict(read.definition_counts())
    number = lambda entities: {int(re.search(r"\((?:Part|Material) (\d+)", str(e)).group(1)) for e in entities}
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
            print(f"{deck}: {key} {own[key]}, dynars {other[key]}{'' if same[key] else ' DIFFERENT'}")
    return 1 if wrong or not decks else 0


if __name__ == "__main__":
    sys.exit(main())
