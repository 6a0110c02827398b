#!/usr/bin/env python3
"""Pictures of verification cases that are outside their tolerance.

The thick cylinder that locks (C12), the cube that slides in a drum of facets (C18), and curves of
contact errors (A07, C02, C09, C15).

    crumple verify --only A07,C02,C09,C12,C15,C18 --out DIR
    deploy/failures.py CRUMPLE DIR --out cases/pictures

CRUMPLE is the program. It runs jobs of DIR/jobs again, with fields, in DIR/drawn. Needs pyvista and
matplotlib, but no screen.
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np
from pictures import DISTINCT, read_mesh, read_steps, stop

# C12: inner and outer radius [m], pressure [Pa], Young's modulus [Pa] and Poisson's ratio. The
# displacements are scaled by MAGNIFIED.
CYLINDER = (0.01, 0.02, 10e6, 210e9, 0.499)
MAGNIFIED = 2e3
# C18: number of positions of the cube in the picture, and its initial speed [m/s].
PLACES = 12
SPEED = 10.0
WINDOW = (1100, 560)
# A07: time at which the block should stop [s], and its deceleration [m/s2].
STOPS = 2.6667e-3
SLOWS = 3821.7
# Laws in the curves, and number of field outputs per run.
LAWS = ("lagrange", "kinematic", "penalty")
POINTS = 200


def run(args, job, *settings):
    """Results of a job of the catalogue."""
    source, folder = args.verify / "jobs" / f"{job}.toml", args.verify / "drawn" / job
    if not source.is_file():
        stop(
            f"{source} is missing; run"
            f" `crumple verify --only A07,C02,C09,C12,C15,C18 --out {args.verify}` first"
        )
    command = [args.crumple, "run", source, "--workers", "1", "--quiet", "--overwrite"]
    done = subprocess.run([*command, "--out", folder, *settings])
    if done.returncode != 0:
        stop(f"{source} ended with exit code {done.returncode}")
    return folder


def lame(r):
    """Radial displacement of a thick cylinder under inner pressure, in plane strain.

    Timoshenko & Goodier, section 28.
    """
    a, b, p, e, nu = CYLINDER
    return (1 + nu) * p * a * a / (e * (b * b - a * a)) * ((1 - 2 * nu) * r + b * b / r)


def locked(args, pv):
    """C12: three cells over the wall, hourglass stiffness on the left, assumed strain on the right.

    The line is the exact shape of both faces.
    """
    scene = pv.Plotter(off_screen=True, window_size=WINDOW, shape=(1, 2), border=False)
    angle = np.linspace(0.0, 0.5 * np.pi, 91)
    for column, form in enumerate(("stiffness", "assumed_strain")):
        folder = run(args, f"C12_{form}_nu_0.499_3", "--set", "output.field_interval=1.0")
        mesh = read_mesh(pv, read_steps(folder)[-1][1])
        moved = mesh.point_data["displacement"]
        start = mesh.points - moved
        inner = np.hypot(start[:, 0], start[:, 1]) < 1.001 * CYLINDER[0]
        radial = (moved[:, :2] * start[:, :2]).sum(axis=1) / np.hypot(start[:, 0], start[:, 1])
        mesh.points = start
        scene.subplot(0, column)
        scene.add_mesh(
            mesh.extract_feature_edges(30), color="#8a8f98", line_width=1.5, lighting=False
        )
        mesh.points = start + MAGNIFIED * moved
        scene.add_mesh(
            mesh,
            color="#d7dde6",
            show_edges=True,
            edge_color="#404040",
            line_width=2,
            lighting=False,
        )
        for radius in CYLINDER[:2]:
            r = radius + MAGNIFIED * lame(radius)
            line = np.column_stack(
                [r * np.cos(angle), r * np.sin(angle), np.full(angle.size, 0.003)]
            )
            scene.add_mesh(pv.MultipleLines(line), color=DISTINCT[3], line_width=4, lighting=False)
        share = radial[inner].mean() / lame(CYLINDER[0])
        name = form.replace("_", " ")
        text = f"{name}: {100 * (share - 1):+.1f} % at the inner face"
        scene.add_text(text, position="upper_edge", font_size=10, color="black")
        print(f"C12 {name}: u_r(a) is {share:.4f} of Lame's {lame(CYLINDER[0]):.4e} m")
        view(scene)
    return scene


def round_the_drum(args, pv):
    """C18: the cube in the drum at equal time intervals, coloured by speed; only contact acts."""
    job = "C18_drum_lagrange_0"
    text = (args.verify / "jobs" / f"{job}.toml").read_text()
    end = float(text.split("end_time = ")[1].split()[0])
    folder = run(args, job, "--set", f"output.field_interval={end / (PLACES - 1)!r}")
    scene = pv.Plotter(off_screen=True, window_size=WINDOW, border=False)
    for step, (time, files) in enumerate(read_steps(folder)):
        mesh = read_mesh(pv, files)
        part = mesh.cell_data["part"]
        if step == 0:
            drum = mesh.extract_cells((part == 1).nonzero()[0])
            scene.add_mesh(
                drum.slice((0.0, 1.0, 0.0)), color="#707680", line_width=3, lighting=False
            )
            corners = drum.slice((0.0, 1.0, 0.0)).points
            scene.add_points(corners, color="#707680", point_size=7, lighting=False)
        cube = mesh.extract_cells((part == 2).nonzero()[0])
        speed = float(np.linalg.norm(cube.point_data["velocity"].mean(axis=0)))
        cube.cell_data["speed"] = np.full(cube.n_cells, speed)
        print(f"C18 t = {1e3 * time:.2f} ms: speed {speed:.3f} m/s")
        scene.add_mesh(
            cube,
            scalars="speed",
            cmap="viridis",
            clim=[0.95 * SPEED, SPEED],
            show_edges=True,
            lighting=False,
            scalar_bar_args={
                "title": "speed of the cube [m/s]\n",
                "color": "black",
                "fmt": "%.2f",
                "n_labels": 6,
                "vertical": True,
                "position_x": 0.8,
                "position_y": 0.2,
                "height": 0.6,
            },
        )
    view(scene, (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
    return scene


def moving(args, pv, job, array):
    """Times, and the values of `array` at all nodes [times, nodes, 3]."""
    text = (args.verify / "jobs" / f"{job}.toml").read_text()
    end = float(text.split("end_time = ")[1].split()[0])
    steps = read_steps(run(args, job, "--set", f"output.field_interval={end / POINTS!r}"))
    meshes = [(time, read_mesh(pv, files)) for time, files in steps]
    return np.array([t for t, _ in meshes]), np.array([m.point_data[array] for _, m in meshes])


def curves(args, pv):
    """Contact errors over time, with the exact or allowed values."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(2, 2, figsize=(11, 7.2), constrained_layout=True)
    for law, colour in zip(LAWS, DISTINCT):
        time, v = moving(args, pv, f"C02_{law}_1_mg_on_1_g_nodes", "velocity")
        node = np.abs(v[0]).max(axis=1).argmax()
        panels[0, 0].plot(1e6 * time, v[:, node, 2], color=colour, label=law)
        time, v = moving(args, pv, f"A07_{law}_Shells", "velocity")
        late = time > STOPS - 0.2e-3
        panels[0, 1].plot(
            1e3 * time[late], v[:, v[0, :, 0] > 1.0, 0].mean(axis=1)[late], color=colour, label=law
        )
        time, u = moving(args, pv, f"C09_{law}", "displacement")
        panels[1, 0].plot(
            1e3 * time, 1e6 * u[:, np.abs(u[-1, :, 0]).argmax(), 0], color=colour, label=law
        )
        time, v = moving(args, pv, f"C15a_{law}", "velocity")
        panels[1, 1].plot(1e6 * time, np.abs(v[:, :, 2]).max(axis=1), color=colour, label=law)
    titles = (
        (
            "C02: a node of 1 mg on nodes of 1 g; it may leave at 9.8 to 10.2 m/s",
            "time [us]",
            "its velocity [m/s]",
        ),
        (
            "A07: a block comes to rest by friction; dashed: theory",
            "time [ms]",
            "its velocity [m/s]",
        ),
        ("C09: a block pushed to and fro at 1.5 mu N", "time [ms]", "displacement [um]"),
        (
            "C15: 1 g between plates of 1 kg; all at rest afterwards",
            "time [us]",
            "fastest plate [m/s]",
        ),
    )
    for axis, (title, x, y) in zip(panels.flat, titles):
        axis.set_title(title, fontsize=9)
        axis.set_xlabel(x)
        axis.set_ylabel(y)
        axis.grid(alpha=0.3)
    panels[0, 1].plot(
        1e3 * np.array([STOPS - 0.2e-3, STOPS]),
        [0.2e-3 * SLOWS, 0.0],
        color="#404040",
        linestyle="--",
        linewidth=1,
    )
    panels[1, 1].axhline(0.01, color="#404040", linestyle="--", linewidth=1)
    panels[0, 0].legend()
    figure.savefig(args.out / "contact_failures.png", dpi=110)


def view(scene, towards=(0.0, 0.0, 1.0), up=(0.0, 1.0, 0.0)):
    """Parallel projection that shows the whole model."""
    scene.set_background("white")
    scene.enable_parallel_projection()
    scene.view_vector(towards, up)
    scene.reset_camera()
    scene.camera.zoom(1.15)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("crumple", type=Path, metavar="CRUMPLE", help="the program")
    parser.add_argument(
        "verify", type=Path, metavar="DIR", help="folder that `crumple verify --out` wrote"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("cases/pictures"), help="folder for the pictures"
    )
    args = parser.parse_args()
    try:
        import pyvista as pv
    except ImportError as error:
        stop(f"cannot import pyvista ({error}); pip install pyvista")
    args.out.mkdir(parents=True, exist_ok=True)
    curves(args, pv)
    for name, draw in (("C12_locking", locked), ("C18_drum", round_the_drum)):
        scene = draw(args, pv)
        scene.enable_anti_aliasing("ssaa")
        scene.screenshot(str(args.out / f"{name}.png"))
        scene.close()


if __name__ == "__main__":
    main()
