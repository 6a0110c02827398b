#!/usr/bin/env python3
"""Parallel efficiency against crash time, as in table 1 of Wang et al. (2007).

    deploy/efficiency.py                  the jeep frame on 1, 2, 4 and 8 workers to 70 ms
    deploy/efficiency.py --end-time 10 --workers 1 2 --repeats 1 --out out/efficiency-trial

Writes a table, a CSV and a chart. Run `cargo build --release -p crumple` first; this script does
not build. It runs the job on each number of workers, `--repeats` times in alternation, and takes
medians. Nothing else should run at the same time, because the measured rows are wall time.

measured: wall(1) / (N wall(N)), for N up to the number of cores of the machine.
modelled: cpu(1) / (N (critical path + redecomposition + messages)); the report defines these terms.

Runs are kept in --runs. `--reuse` writes the report again from these runs.
Needs only Python 3.9.
"""

import argparse
import csv
import json
import os
import platform
import shlex
import shutil
import statistics
import subprocess
import sys
import textwrap
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Wang et al. 2007, table 1: crash time [ms] -> parallel efficiency [%] on 4 processors.
PAPER = {10: 68.4, 20: 69.2, 30: 70.1, 40: 72.2, 50: 75.8, 60: 79.3, 70: 84.4}
PAPER_WORKERS = 4
# Columns of history.csv. Older runs have no column for redecompositions.
WALL, TOTAL, CRITICAL, RENEWAL = (
    "wall [s]",
    "cpu of all workers [s]",
    "cpu of the critical path [s]",
    "cpu of renewals [s]",
)
LOW, HIGH = "low redecompositions", "high redecompositions"
# Shares of the processor time N T: key -> words in the report. Their sum is 100 %.
SHARES = {
    "useful": "work of the serial run",
    "extra": "work and cache misses that the serial run does not have",
    "imbalance": "waiting for the slowest worker, without contact and in contact",
    "renewal": "redecompositions",
    "messages": "messages",
}
COLOURS = {1: "#888888", 2: "#2a78d6", 4: "#d1571b", 8: "#1b8a5a"}
MORE_COLOURS = ["#8a4fbf", "#b58900", "#c2407a"]


def stop(message):
    """End with a message and the exit code for bad input."""
    print(f"efficiency.py: {message}", file=sys.stderr)
    raise SystemExit(2)


@dataclass
class Point:
    """State of a run at a time; times in seconds."""

    wall: float
    total: float
    critical: float
    renewal: float
    cycles: float
    renewals: float


@dataclass
class Run:
    """Data from the folder of one run."""

    summary: dict
    rows: list
    exact_renewal: bool

    def at(self, t):
        """State of the run at time t, by linear interpolation between rows of the history."""
        before = after = self.rows[0]
        for row in self.rows:
            before, after = after, row
            if row[0] >= t:
                break
        span = after[0] - before[0]
        part = min(max((t - before[0]) / span, 0.0), 1.0) if span > 0 else 1.0
        return Point(*(a + part * (b - a) for a, b in zip(before[1:], after[1:])))


@dataclass
class Result:
    """Medians over repeats for one number of workers and one time, and derived values."""

    workers: int
    time: float
    point: Point
    network: float
    modelled: float
    measured: float = None
    shares: dict = field(default_factory=dict)


def read_run(folder):
    """Summary and history of one run."""
    try:
        summary = json.loads((folder / "summary.json").read_text())
        with open(folder / "history.csv", newline="") as file:
            table = list(csv.DictReader(file))
    except (OSError, ValueError) as error:
        stop(f"{folder} has no finished run: {error}")
    if summary["status"] != "completed":
        stop(f"{folder}: the run has {summary['status']}: {summary['reason']}")
    missing = [c for c in (WALL, TOTAL, CRITICAL, LOW, HIGH) if c not in table[0]]
    if missing:
        stop(f"{folder}/history.csv lacks the columns {', '.join(missing)}; rebuild crumple")
    moment = next(c for c in table[0] if c.startswith("time ["))
    exact = RENEWAL in table[0]
    renewals = [float(r[LOW]) + float(r[HIGH]) for r in table]
    rows = [
        (
            float(r[moment]),
            float(r[WALL]),
            float(r[TOTAL]),
            float(r[CRITICAL]),
            float(r[RENEWAL]) if exact else 0.0,
            float(r["cycle"]),
            n,
        )
        for r, n in zip(table, renewals)
    ]
    return Run(summary, rows, exact)


def command_of(args, workers, folder):
    """The command line of one run."""
    job = [
        str(args.crumple),
        "run",
        str(args.job),
        "--out",
        str(folder),
        "--end-time",
        f"{args.end_time:g}",
        "--quiet",
        "--overwrite",
    ]
    # No field files: their cost does not depend on the number of workers.
    job += ["--set", "output.field_interval=-1", "--set", "output.field_times=[]"]
    for item in args.set:
        job += ["--set", item]
    if args.mpirun and workers > 1:
        return shlex.split(args.mpirun) + ["-n", str(workers + 1)] + job
    return job + ["--workers", str(workers)]


def run_all(args):
    """All runs.

    Each round has all numbers of workers, so that a slow period of the machine affects all alike.
    """
    folders = {n: [] for n in args.workers}
    for repeat in range(args.repeats):
        for n in args.workers:
            folder = args.runs / f"workers-{n}-run-{repeat + 1}"
            folders[n].append(folder)
            if args.reuse:
                continue
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            said = f"run {repeat + 1} of {args.repeats}, {n} worker{'s' if n > 1 else ''}"
            print(f"{said} (load average {os.getloadavg()[0]:.1f}) ...", end=" ", flush=True)
            began = time.monotonic()
            ended = subprocess.run(
                command_of(args, n, folder),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
            )
            if ended.returncode != 0:
                print()
                stop(f"{said} ended with code {ended.returncode}:\n{ended.stderr.strip()}")
            summary = json.loads((folder / "summary.json").read_text())
            cpu = summary["cpu_s"]["total"]
            print(
                f"{time.monotonic() - began:.1f} s wall, {cpu:.1f} s of CPU,"
                f" grind {summary['grind_ns']:.0f} ns",
                flush=True,
            )
    return folders


def median_point(runs, t):
    """Medians over repeats."""
    points = [r.at(t) for r in runs]
    return Point(
        *(statistics.median(getattr(p, f) for p in points) for f in Point.__dataclass_fields__)
    )


def network_s(args, summary, cycles):
    """Modelled time of the messages of a worker [s]."""
    traffic = summary["cpu_s"]
    per_cycle = traffic["messages_per_cycle"] * args.latency * 1e-6 + traffic["bytes_per_cycle"] / (
        args.bandwidth * 1e9
    )
    return cycles * per_cycle


def work_out(args, runs, marks):
    """A result for every number of workers and time."""
    results = {}
    for n, of_n in runs.items():
        for t in marks:
            serial, p = median_point(runs[1], t), median_point(of_n, t)
            network = network_s(args, of_n[0].summary, p.cycles) if n > 1 else 0.0
            renewal = p.renewal if n > 1 else 0.0
            span = n * (p.critical + renewal + network)
            result = Result(n, t, p, network, serial.total / span)
            shares = {
                "useful": serial.total,
                "extra": p.total - serial.total,
                "imbalance": n * p.critical - p.total,
                "renewal": n * renewal,
                "messages": n * network,
            }
            result.shares = {name: 100.0 * s / span for name, s in shares.items()}
            if 1 < n <= args.cores:
                result.measured = serial.wall / (n * p.wall)
            results[n, t] = result
    return results


def percent(value):
    """One decimal, or a dash."""
    return "–" if value is None else f"{100.0 * value:.1f}"


def table(header, rows):
    """A Markdown table with numbers aligned to the right."""
    lines = ["| " + " | ".join(header) + " |", "|---" + "|---:" * (len(header) - 1) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def paragraph(text, indent=""):
    """Markdown text in lines of at most 99 columns; `indent` starts all lines but the first."""
    return textwrap.fill(
        text, 99, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def machine(args):
    """Name of the processor, number of cores and system, without the name of the host."""
    model = platform.processor() or platform.machine()
    try:
        info = Path("/proc/cpuinfo").read_text().splitlines()
        model = next(
            (line.split(":", 1)[1].strip() for line in info if line.startswith("model name")), model
        )
    except OSError:
        pass
    cores = f"{args.cores} core{'s' if args.cores > 1 else ''}"
    return f"{model}, {cores}, {platform.system()} {platform.machine()}"


def own_command(args):
    """Command that makes this report; paths in the repository are relative to its root."""

    def inside(path):
        try:
            return str(Path(path).resolve().relative_to(ROOT))
        except ValueError:
            return Path(path).name

    words = [
        "deploy/efficiency.py",
        "--workers",
        *map(str, args.workers),
        "--repeats",
        str(args.repeats),
    ]
    if inside(args.job) != "cases/jeep-frame":
        words += ["--job", inside(args.job)]
    words += ["--end-time", f"{args.end_time:g}"]
    for name, value, default in (
        ("every", args.every, 10),
        ("latency", args.latency, 2),
        ("bandwidth", args.bandwidth, 10),
    ):
        if value != default:
            words += [f"--{name}", f"{value:g}"]
    if args.crumple.resolve() != ROOT / "target/release/crumple":
        words += ["--crumple", inside(args.crumple)]
    for item in args.set:
        words += ["--set", item]
    if args.mpirun:
        words += ["--mpirun", args.mpirun]
    return shlex.join(words)


def efficiency_rows(args, results, marks, named):
    """Rows of the main table: those of the paper, then measured and modelled ones."""
    rows = []
    if named:
        rows.append(
            [
                f"Wang et al. 2007, {PAPER_WORKERS} processors",
                *(f"{PAPER[t]:.1f}" if t in PAPER else "–" for t in marks),
            ]
        )
    parallel = [n for n in args.workers if n > 1]
    for n in (n for n in parallel if n <= args.cores):
        rows.append([f"{n} workers, measured", *(percent(results[n, t].measured) for t in marks)])
    rows += [
        [f"{n} workers, modelled", *(percent(results[n, t].modelled) for t in marks)]
        for n in parallel
    ]
    return rows


def limits(args, runs, results, marks):
    """Losses of efficiency by cause: a table, and one list item for each number of workers."""
    parallel = [n for n in args.workers if n > 1]
    t, text = marks[-1], []
    header = [f"% of processor time up to {t:g}", *(f"{n} workers" for n in parallel)]
    rows = [
        [words, *(f"{results[n, t].shares[name]:.1f}" for n in parallel)]
        for name, words in SHARES.items()
    ]
    text.append(table(header, rows))
    for n in parallel:
        lost = sorted(
            ((s, name) for name, s in results[n, t].shares.items() if name != "useful" and s > 0),
            reverse=True,
        )
        said = ", ".join(f"{s:.1f} % {SHARES[name]}" for s, name in lost)
        item = f"- **{n} workers** lose {100.0 - results[n, t].shares['useful']:.1f} %: {said}."
        r = results[n, t]
        if r.measured is not None:
            gap = (
                n * (r.point.wall - r.point.critical - r.point.renewal) / (n * r.point.wall) * 100.0
            )
            idle = (1.0 - results[1, t].point.total / results[1, t].point.wall) * 100.0
            item += (
                f" Measured, {gap:.1f} % of the wall time is in neither the critical path nor"
                " redecompositions. The causes are start-up, other activity of the machine, and"
                " threads that sleep until a late message arrives. (In the serial run, which never"
                f" waits, it is {idle:.1f} %.)"
            )
        text.append(paragraph(item, "  "))
    return text


def report(args, runs, results, marks, named):
    """Text of EFFICIENCY.md."""
    parallel = [n for n in args.workers if n > 1]
    unit = (
        next(c for c in open_header(args) if c.startswith("time ["))
        .removeprefix("time [")
        .removesuffix("]")
    )
    digests = {r.summary["state_digest"] for of_n in runs.values() for r in of_n}
    busy = results[1, marks[-1]].point
    exact = all(r.exact_renewal for n in parallel for r in runs[n])
    header = [f"efficiency [%] up to [{unit}]", *(f"{t:g}" for t in marks)]
    out = ["# Parallel efficiency against crash time", ""]
    repeats = f"{args.repeats} run{'s' if args.repeats > 1 else ''}"
    out += [paragraph(f"Medians of {repeats} on {machine(args)}. Command:"), ""]
    out += ["```", own_command(args), "```", ""]
    out += [
        table(header, efficiency_rows(args, results, marks, named)),
        "",
        "![efficiency against time](efficiency.svg)",
        "",
    ]
    if busy.wall > 1.1 * busy.total:
        out += [
            paragraph(
                "**Other programs ran at the same time, or the runs were short**: the serial run"
                f" took {busy.wall:.1f} s of wall time for {busy.total:.1f} s of CPU. Do not rely"
                " on the measured rows."
            ),
            "",
        ]
    if len(digests) == 1:
        out += [f"All runs end with the same `state_digest` ({digests.pop()[:16]}…).", ""]
    else:
        out += [
            f"**Error: the runs end with {len(digests)} different `state_digest`s.**",
            "",
        ]
    out += [
        "## Rows of the table",
        "",
        paragraph(
            "All rows are cumulative, from the start to the time of the column. The serial run is"
            " the same program with one worker. It has no neighbours, no ghosts and no"
            " redecompositions."
        ),
        "",
        paragraph(
            "- **Measured**: wall(1) / (N wall(N)). Only for N up to the"
            f" {args.cores} cores of the machine above.",
            "  ",
        ),
        paragraph(
            "- **Modelled**: cpu(1) / (N (critical path + redecomposition + messages)). This is not"
            " a measurement on N processors: the N workers shared the cores of the machine above.",
            "  ",
        ),
        paragraph(
            "  - cpu(1): CPU time of the one worker of the serial run, without start-up and field"
            " files.",
            "    ",
        ),
        paragraph(
            "  - Critical path: the largest CPU time of one worker per cycle without contact, plus"
            " the largest one of contact, without waiting, summed over cycles. Workers wait for"
            " each other between the two, and in contact for each message, which is left out."
            " The share of contact is measured in one of ten cycles."
            " Two effects make the true path somewhat shorter: an interrupt of one worker counts"
            " as imbalance, and on shared cores the caches are cold after each turn.",
            "    ",
        ),
        paragraph(
            "  - Redecomposition: "
            + (
                "CPU time of the worker that spent most on redecompositions."
                if exact
                else f"**left out**. The `history.csv` of these runs has no column `{RENEWAL}`, so"
                " the modelled rows are too high."
            ),
            "    ",
        ),
        paragraph(
            f"  - Messages: cycles × (messages × {args.latency:g} µs + bytes /"
            f" ({args.bandwidth:g} GB/s)), with the mean number of messages and bytes of a worker"
            " per cycle (below). Messages are counted one after the other, and none is hidden"
            " behind work. The number includes the hops of the global maximum (log2 N per cycle)"
            " and each contact sweep between workers with common pairs. Packing and unpacking are"
            " part of the critical path.",
            "    ",
        ),
        "",
        table(
            [
                "workers",
                "wall [s]",
                "grind [ns]",
                "cycles",
                "repartitions / membership updates",
                "messages per cycle",
                "kB per cycle",
                "sweeps per cycle",
            ],
            [
                [
                    str(n),
                    f"{statistics.median(r.summary['wall_s'] for r in of_n):.1f}",
                    f"{statistics.median(r.summary['grind_ns'] for r in of_n):.0f}",
                    str(s["cycles"]),
                    f"{s['redecompositions']['low']} / {s['redecompositions']['high']}",
                    f"{s['cpu_s']['messages_per_cycle']:.1f}",
                    f"{s['cpu_s']['bytes_per_cycle'] / 1e3:.1f}",
                    f"{s['contact']['sweeps_per_cycle']:.1f}",
                ]
                for n, of_n in runs.items()
                for s in [of_n[0].summary]
            ],
        ),
        "",
        paragraph(
            "Wall and grind time have no meaning for more workers than cores. The last four columns"
            " are those of the first run."
        ),
        "",
        "## Losses",
        "",
        "Shares of the processor time N × (critical path + redecomposition + messages):",
        "",
    ]
    parts = limits(args, runs, results, marks)
    out += [parts[0], "", *parts[1:]]
    if named:
        out += [
            "",
            paragraph(
                "Wang et al. used a cluster of 2007, another frame, another mesh and an unknown"
                " speed. Only the shape of the curve and its level can be compared."
            ),
        ]
    return "\n".join(out) + "\n"


def open_header(args):
    """Column names of a history."""
    with open(args.runs / f"workers-{args.workers[0]}-run-1" / "history.csv", newline="") as file:
        return next(csv.reader(file))


def write_csv(path, results):
    """Writes all numbers of the report."""
    with open(path, "w", newline="") as file:
        out = csv.writer(file)
        header = [
            "time",
            "workers",
            "cycles",
            "wall [s]",
            "cpu of all workers [s]",
            "cpu of the critical path [s]",
        ]
        header += [
            "renewal [s]",
            "messages, modelled [s]",
            "renewals",
            "efficiency measured [%]",
            "efficiency modelled [%]",
        ]
        out.writerow(header + [f"share of {name} [%]" for name in SHARES])
        for r in results.values():
            p = r.point
            row = [
                f"{r.time:g}",
                r.workers,
                f"{p.cycles:.0f}",
                *(f"{a:.4f}" for a in (p.wall, p.total, p.critical, p.renewal)),
            ]
            row += [
                f"{r.network:.4f}",
                f"{p.renewals:.0f}",
                "" if r.measured is None else percent(r.measured),
                percent(r.modelled),
            ]
            out.writerow(row + [f"{r.shares[name]:.2f}" for name in SHARES])


def chart(args, results, marks, named):
    """The table as a line chart, in SVG."""
    parallel = [n for n in args.workers if n > 1]
    series = []
    if named:
        series.append(
            (
                f"Wang 2007, {PAPER_WORKERS} processors",
                "#777777",
                "2 5",
                [(t, PAPER[t]) for t in marks if t in PAPER],
            )
        )
    for i, n in enumerate(parallel):
        colour = COLOURS.get(n, MORE_COLOURS[i % len(MORE_COLOURS)])
        series.append(
            (
                f"{n} workers, modelled",
                colour,
                "",
                [(t, 100.0 * results[n, t].modelled) for t in marks],
            )
        )
        if results[n, marks[0]].measured is not None:
            series.append(
                (
                    f"{n} workers, measured",
                    colour,
                    "8 4",
                    [(t, 100.0 * results[n, t].measured) for t in marks],
                )
            )
    width, height, left, right, top, bottom = 860, 460, 60, 190, 24, 52
    values = [v for s in series for _, v in s[3]]
    low = min(50.0, 10.0 * int(min(values) // 10))
    high = max(100.0, 10.0 * -int(-max(values) // 10))
    first, last = (0.0, marks[-1]) if len(marks) > 1 else (0.0, 2.0 * marks[0])
    across = lambda t: left + (t - first) / (last - first) * (width - left - right)
    up = lambda v: height - bottom - (v - low) / (high - low) * (height - top - bottom)
    text = lambda x, y, words, more="": f'<text x="{x:.1f}" y="{y:.1f}" {more}>{words}</text>'
    svg = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"'
        ' font-family="sans-serif" font-size="13" fill="#222">',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
    ]
    for v in range(int(low), int(high) + 1, 10):
        svg.append(f'<path d="M{left} {up(v):.1f}H{width - right}" stroke="#ddd"/>')
        svg.append(text(left - 8, up(v) + 4, f"{v}", 'text-anchor="end"'))
    svg += [text(across(t), height - bottom + 20, f"{t:g}", 'text-anchor="middle"') for t in marks]
    svg.append(
        text(0.5 * (left + width - right), height - 10, "crash time", 'text-anchor="middle"')
    )
    svg.append(
        text(
            16,
            0.5 * (height - bottom + top),
            "parallel efficiency [%]",
            f'text-anchor="middle" transform="rotate(-90 16 {0.5 * (height - bottom + top):.0f})"',
        )
    )
    # Names at the ends of the lines, moved apart where they would overlap.
    ends = sorted((up(s[3][-1][1]), i) for i, s in enumerate(series) if s[3])
    places, floor = {}, top
    for y, i in ends:
        places[i] = floor = max(y, floor)
        floor += 17
    over = max(0.0, floor - 17 - (height - bottom))
    for i, (name, colour, dash, points) in enumerate(series):
        if not points:
            continue
        line = "L".join(f"{across(t):.1f} {up(v):.1f}" for t, v in points)
        svg.append(
            f'<path d="M{line}" fill="none" stroke="{colour}" stroke-width="2.5"'
            f' stroke-dasharray="{dash}"/>'
        )
        svg += [
            f'<circle cx="{across(t):.1f}" cy="{up(v):.1f}" r="3.5" fill="{colour}"/>'
            for t, v in points
        ]
        t, v = points[-1]
        y = places[i] - over
        svg.append(
            f'<path d="M{across(t) + 6:.1f} {up(v):.1f}L{across(t) + 18:.1f} {y:.1f}"'
            f' stroke="{colour}" opacity="0.6"/>'
        )
        svg.append(text(across(t) + 22, y + 4, name, f'fill="{colour}"'))
    return "\n".join(svg + ["</svg>"]) + "\n"


def arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--crumple",
        type=Path,
        default=ROOT / "target/release/crumple",
        help="the binary (target/release/crumple)",
    )
    parser.add_argument(
        "--job",
        type=Path,
        default=ROOT / "cases/jeep-frame",
        help="job or folder of a job (cases/jeep-frame)",
    )
    parser.add_argument(
        "--workers",
        type=int,
        nargs="+",
        default=[1, 2, 4, 8],
        help="numbers of workers, including 1",
    )
    parser.add_argument(
        "--repeats", type=int, default=3, help="runs of each; medians are taken (3)"
    )
    parser.add_argument("--end-time", type=float, default=70.0, help="end of the runs (70)")
    parser.add_argument("--every", type=float, default=10.0, help="distance of the columns (10)")
    parser.add_argument(
        "--latency", type=float, default=2.0, help="latency of a message in the model [µs] (2)"
    )
    parser.add_argument(
        "--bandwidth", type=float, default=10.0, help="bandwidth in the model [GB/s] (10)"
    )
    parser.add_argument(
        "--cores",
        type=int,
        default=len(os.sched_getaffinity(0)),
        help="cores that runs may use (all available)",
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="passed to crumple"
    )
    parser.add_argument(
        "--mpirun",
        metavar="COMMAND",
        help="run more than one worker under this launcher, e.g. mpirun",
    )
    parser.add_argument(
        "--runs",
        type=Path,
        default=ROOT / "out/efficiency",
        help="folder for the runs (out/efficiency)",
    )
    parser.add_argument("--reuse", action="store_true", help="do not run, read the runs in --runs")
    parser.add_argument("--out", type=Path, help="folder for the report (JOB/efficiency)")
    args = parser.parse_args()
    args.workers = sorted(set(args.workers))
    if args.workers[0] != 1 or len(args.workers) < 2:
        stop("--workers must include 1, the reference, and at least one more number")
    if args.repeats < 1 or args.end_time < args.every or args.every <= 0:
        stop("--repeats must be at least 1, --every positive, --end-time at least --every")
    if not args.reuse and not args.crumple.is_file():
        stop(
            f"{args.crumple} is missing; run `cargo build --release -p crumple`"
            " or give its path with --crumple"
        )
    args.out = args.out or (args.job if args.job.is_dir() else args.job.parent) / "efficiency"
    return args


def main():
    args = arguments()
    if not args.reuse and os.getloadavg()[0] > 0.3:
        print(
            f"warning: load average {os.getloadavg()[0]:.1f}: wall times will not be reliable",
            file=sys.stderr,
        )
    folders = run_all(args)
    runs = {n: [read_run(folder) for folder in of_n] for n, of_n in folders.items()}
    marks = [args.every * (i + 1) for i in range(int(args.end_time / args.every + 1e-9))]
    # The row of the paper is written only for its own scene.
    named = (
        args.job.resolve().name == "jeep-frame" or args.job.resolve().parent.name == "jeep-frame"
    )
    results = work_out(args, runs, marks)
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "EFFICIENCY.md").write_text(report(args, runs, results, marks, named))
    (args.out / "efficiency.svg").write_text(chart(args, results, marks, named))
    write_csv(args.out / "efficiency.csv", results)
    for row in efficiency_rows(args, results, marks, named):
        print("  ".join([f"{row[0]:32}", *(f"{cell:>6}" for cell in row[1:])]))
    print(f"written: {args.out}/EFFICIENCY.md, efficiency.csv, efficiency.svg")


if __name__ == "__main__":
    main()
