#!/usr/bin/env python3
"""Figures of the two papers, made again with Crumple: one command for each.

    deploy/papers.py --list                     the figures
    deploy/papers.py pronto-14                  one figure
    deploy/papers.py all                        all of them

Each figure is a CSV and a PNG, or pictures, in `papers/` in the folder of its scene under cases/,
or in --out DIR. The script builds nothing: run `cargo build --release -p crumple` first, or name
another program with --crumple. Charts need matplotlib, pictures pyvista (deploy/requirements.txt).

measured: CPU time of the critical path in each cycle, without waiting, in runs on this machine.
More workers than cores take turns, so wall time shows nothing.
modelled: `crumple scale` counts elements, nodes, pairs and messages of each worker and multiplies
them by costs measured here on one worker; a message takes 2 us, and a connection carries 10 GB/s.
"""

import argparse
import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Phases of `workers.csv`: work on elements and nodes, and contact.
ELEMENT_PHASES = ("elements", "assemble", "constraints", "energy", "advance")
CONTACT_PHASES = ("search", "local", "contact")
# Numbers of workers: in runs and in the model.
RUN_ON = (1, 2, 4, 8)
MODEL_ON = (2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
# Cycles of a run with times, and a time within them for the model.
CYCLES = {"beam": 200, "brick-wall": 200, "can-crush": 400}
MODEL_AT = {"beam": (), "brick-wall": (0.15,), "can-crush": (0.2,)}


def stop(message):
    """End with a message and the exit code for bad input."""
    print(f"papers.py: {message}", file=sys.stderr)
    raise SystemExit(2)


class Maker:
    """Runs the program and writes the files of figures."""

    def __init__(self, args):
        self.args = args
        self.program = args.crumple or ROOT / "target/release/crumple"
        if not self.program.exists():
            stop(f"{self.program} is missing; run `cargo build --release -p crumple`")
        self.scratch = tempfile.TemporaryDirectory(prefix="crumple-papers-")

    def folder(self, scene):
        """Folder for the figures of a scene."""
        out = self.args.out or ROOT / "cases" / scene / "papers"
        out.mkdir(parents=True, exist_ok=True)
        return out

    def call(self, command, scene, sets, *words):
        """Run a command of the program on a scene; return the folder of its results."""
        out = Path(tempfile.mkdtemp(dir=self.scratch.name))
        line = [self.program, command, ROOT / "cases" / scene, "--out", out, *words]
        line += [f"--set={s}" for s in sets]
        print(" ".join(["crumple", *map(str, line[1:])]), flush=True)
        done = subprocess.run(list(map(str, line)), capture_output=True, text=True)
        if done.returncode != 0:
            stop(f"`crumple {command}` ended with code {done.returncode}:\n{done.stderr}")
        return out

    def timed(self, scene, workers, sets=()):
        """CPU seconds of the critical path per cycle in a run, by kind of work."""
        cycles = CYCLES[scene]
        sets = [
            f"time.max_cycles={cycles}",
            "output.field_interval=-1",
            "output.field_times=[]",
            "checkpoint.every=off",
            *sets,
        ]
        words = ("--workers", str(workers), "--quiet", "--no-report")
        out = self.call("run", scene, sets, *words)
        summary = json.loads((out / "summary.json").read_text())
        total = {}
        with open(out / "workers.csv") as file:
            for row in csv.DictReader(file):
                of = total.setdefault(row["worker"], dict.fromkeys(("elements", "contact"), 0.0))
                for kind, phases in (("elements", ELEMENT_PHASES), ("contact", CONTACT_PHASES)):
                    of[kind] += sum(float(row[f"cpu {phase} [s]"]) for phase in phases)
        most = {k: max(of[k] for of in total.values()) / cycles for k in ("elements", "contact")}
        step = summary["cpu_s"]["critical_path"] / summary["cycles"]
        return {"elements": sum(summary["elements"].values()), "step": step, "kinds": most}

    def modelled(self, scene, workers, sets=()):
        """Rows of `crumple scale`."""
        words = ["--workers", ",".join(map(str, workers))]
        if MODEL_AT[scene]:
            words += ["--at", ",".join(map(str, MODEL_AT[scene]))]
        out = self.call("scale", scene, sets, *words)
        with open(out / "scale.csv") as file:
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]

    def write(self, scene, name, header, rows):
        """Write the table of a figure."""
        path = self.folder(scene) / f"{name}.csv"
        with open(path, "w", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(header)
            table.writerows([f"{x:.4g}" if isinstance(x, float) else x for x in r] for r in rows)
        print(f"wrote {path}")

    def chart(self, scene, name, title, curves, labels, ideal=None):
        """Curves `(label, style, [(x, y)])` over numbers of workers, on logarithmic axes."""
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        figure, axes = pyplot.subplots(figsize=(7.5, 5.0), layout="constrained")
        for label, style, points in curves:
            axes.plot(*zip(*points), style, label=label, markersize=6)
        if ideal:
            axes.plot(*zip(*ideal), color="#999999", linewidth=1, label="ideal")
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        axes.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
        axes.set_xlabel(labels[0])
        axes.set_ylabel(labels[1])
        axes.set_title(title)
        axes.grid(True, which="major", alpha=0.3)
        axes.legend()
        path = self.folder(scene) / f"{name}.png"
        figure.savefig(path, dpi=110)
        pyplot.close(figure)
        print(f"wrote {path}")


def fixed(scene, name, title):
    """Speed-up of a mesh of fixed size on more and more workers."""

    def make(maker):
        alone = maker.timed(scene, 1)
        runs = [(n, maker.timed(scene, n) if n > 1 else alone) for n in RUN_ON]
        measured = [(n, alone["step"] / run["step"]) for n, run in runs]
        model = maker.modelled(scene, MODEL_ON)
        modelled = [(int(r["workers"]), r["workers"] * r["efficiency [%]"] / 100) for r in model]
        rows = [(n, "measured", alone["elements"] / n, s, 100 * s / n) for n, s in measured]
        rows += [(n, "modelled", alone["elements"] / n, s, 100 * s / n) for n, s in modelled]
        header = ("workers", "kind", "elements per worker", "speed-up", "efficiency [%]")
        maker.write(scene, name, header, rows)
        curves = [
            ("critical path, measured", "o-", measured),
            ("step with messages, modelled", "s--", modelled),
        ]
        ideal = [(1, 1), (MODEL_ON[-1], MODEL_ON[-1])]
        labels = ("workers", "speed-up")
        sized = f"{title}, {alone['elements']} elements, first {CYCLES[scene]} cycles"
        maker.chart(scene, name, sized, curves, labels, ideal)

    return make


def scaled(scene, name, title, grown):
    """Efficiency of a mesh that grows with the number of workers."""

    def make(maker):
        rows, measured, modelled = [], [], []
        alone = maker.timed(scene, 1, ["scene.scale=1"])
        for n in grown:
            sets = [f"scene.scale={n}"]
            if n in RUN_ON:
                run = maker.timed(scene, n, sets) if n > 1 else alone
                measured.append((n, 100 * alone["step"] / run["step"]))
                rows.append((n, "measured", round(run["elements"] / n), measured[-1][1]))
            if n > 1:
                # Against one worker with the whole mesh, as if its cost per element were that of
                # the mesh of one worker.
                row = maker.modelled(scene, (n,), sets)[0]
                modelled.append((n, row["efficiency [%]"]))
                mean = (row["elements least"] + row["elements most"]) / 2
                rows.append((n, "modelled", round(mean), modelled[-1][1]))
        header = ("workers", "kind", "elements per worker", "scaled efficiency [%]")
        maker.write(scene, name, header, rows)
        curves = [
            ("critical path, measured", "o-", measured),
            ("step with messages, modelled", "s--", modelled),
        ]
        labels = ("workers", "scaled efficiency [%]")
        ideal = [(1, 100), (grown[-1], 100)]
        sized = f"{title}, {alone['elements']} elements per worker, first {CYCLES[scene]} cycles"
        maker.chart(scene, name, sized, curves, labels, ideal)

    return make


def grind(scene, name, title, grows):
    """Grind time (equation 1 of the paper) of elements and contact apart."""

    def make(maker):
        rows, curves = [], {"elements": [], "contact": []}
        first = None
        for n in RUN_ON:
            run = maker.timed(scene, n, [f"scene.scale={n}"] if grows else [])
            first = first or run
            part = [1e9 * run["kinds"][k] / run["elements"] for k in ("elements", "contact")]
            whole = 1e9 * run["step"] / run["elements"]
            alone = 1e9 * first["step"] / first["elements"]
            rows.append((n, run["elements"], *part, whole, 100 * alone / (n * whole)))
            for kind, value in zip(curves, part):
                curves[kind].append((n, value))
        header = (
            "workers",
            "elements",
            "grind time of elements [ns]",
            "grind time of contact [ns]",
            "grind time of the critical path [ns]",
            "efficiency [%]",
        )
        maker.write(scene, name, header, rows)
        drawn = [
            ("elements, measured", "o-", curves["elements"]),
            ("contact, measured", "s-", curves["contact"]),
        ]
        start = curves["elements"][0][1]
        ideal = [(n, start / n) for n in RUN_ON]
        labels = ("workers", "CPU time per element and cycle, critical path [ns]")
        maker.chart(scene, name, title, drawn, labels, ideal)

    return make


def picture(scene, name, times, colours, sets=(), workers=1, undeformed=False):
    """Pictures of the model at some times."""

    def make(maker):
        every = [f"output.field_times=[{', '.join(f'{t:.4g}' for t in times)}]"]
        until = f"end_time={max(times)}" if max(times) > 0 else "time.max_cycles=1"
        sets_of_run = [*every, "output.field_interval=-1", until, *sets]
        words = ("--workers", str(workers), "--quiet", "--no-report")
        out = maker.call("run", scene, sets_of_run, *words)
        for flat in (False, True) if undeformed else (False,):
            target = maker.folder(scene) / (f"{name}-undeformed" if flat else name)
            line = [sys.executable, ROOT / "deploy/pictures.py", out, "--out", target]
            line += ["--views", "angle", "--no-wall", "--times", *map(str, times)]
            line += ["--colour", *colours] + (["--undeformed"] if flat else [])
            done = subprocess.run(list(map(str, line)), capture_output=True, text=True)
            if done.returncode != 0:
                stop(f"pictures.py failed:\n{done.stderr}")
            print(f"wrote {target}")

    return make


BOTH = ("worker", "contact_worker")
RCB = ('parallel.contact="rcb"',)
FIGURES = {
    "pronto-10": fixed("beam", "pronto-10", "Vibrating beam"),
    "pronto-11": scaled("beam", "pronto-11", "Vibrating beam", (1, 2, 4, 8, 16, 32)),
    "pronto-12": picture("brick-wall", "pronto-12", [0.0], ["part"]),
    "pronto-13": picture("brick-wall", "pronto-13", [12.0], ["part"]),
    "pronto-14": fixed("brick-wall", "pronto-14", "Brick wall"),
    "pronto-15": scaled("brick-wall", "pronto-15", "Brick wall", (1, 2, 4, 8, 16)),
    "pronto-16": picture("can-crush", "pronto-16", [0.0], ["part"]),
    "pronto-17": grind("can-crush", "pronto-17", "Can crush, mesh of fixed size", False),
    "pronto-18": grind("can-crush", "pronto-18", "Can crush, mesh that grows", True),
    "pronto-19": picture("can-crush", "pronto-19", [0.0], BOTH, RCB, 8),
    "pronto-20": picture("can-crush", "pronto-20", [1.0, 2.0], BOTH, RCB, 8, True),
}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("figures", nargs="*", metavar="FIGURE")
    parser.add_argument("--list", action="store_true", help="list the figures")
    parser.add_argument("--out", type=Path, help="folder for all files")
    parser.add_argument("--crumple", type=Path, help="program (target/release/crumple)")
    args = parser.parse_args()
    if args.list or not args.figures:
        print("\n".join([*FIGURES, "all"]))
        print("Wang et al.: table 1 and figure 4 are deploy/efficiency.py, figures 2 and 3")
        print("deploy/pictures.py on the jeep frame (cases/jeep-frame/README.md).")
        return
    unknown = [f for f in args.figures if f not in FIGURES and f != "all"]
    if unknown:
        stop(f"no figure {', '.join(unknown)}; the figures are {', '.join(FIGURES)}")
    maker = Maker(args)
    for name in FIGURES if "all" in args.figures else args.figures:
        FIGURES[name](maker)


if __name__ == "__main__":
    main()
