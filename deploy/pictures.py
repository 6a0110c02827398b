#!/usr/bin/env python3
"""Pictures of a run: the deformed shells at given times, from the side, at an angle, and close up at the front.

    deploy/pictures.py DIR --times 0 20 40 65.8 --out DIR/pictures

DIR is the folder that `crumple run --out DIR` wrote; its DIR/fields/fields.pvd is read. A time for which there is no
step gives the nearest step. Needs `pip install pyvista`; needs no screen.
"""

import argparse
import json
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

# Light grey where nothing has yielded.
STRAIN = ["#c3c9d1", "#5b9bd5", "#2ca58d", "#f4d35e", "#ee6c4d", "#9b1d20"]
# name on the command line -> cell array, title of the colour bar, colour map
COLOURS = {
    "plastic_strain": ("plastic_strain", "plastic strain [-]", STRAIN),
    "von_mises": ("von_mises", "von Mises stress [{stress}]", "viridis"),
    "thickness": ("thickness", "thickness [{length}]", "viridis"),
    "part": ("part", "part", "tab10"),
    "worker": ("worker", "worker", "tab10"),
    "class": ("class", "0 interior, 1 interface, 2 exterior", "Set1"),
}
EXTERIOR = 2  # class of such a copy
# view -> window [pixel], direction from the model to the camera. The model points to -x, y is across, z is up;
# the cameras stand behind the wall's face, so that the wall hides nothing.
VIEWS = {
    "side": ((1800, 560), (0.0, -1.0, 0.0)),
    "angle": ((1600, 900), (0.55, -1.0, 0.65)),
    "front": ((1600, 1000), (0.65, -1.0, 0.6)),
}
# Shells of the close-up: those ahead of this fraction of the undeformed length.
FRONT = 0.17
# Room around the model in a picture, and the part of the window at the bottom that the colour bar takes.
MARGIN = 1.06
BAR = 0.16


def stop(message):
    """End with a message and the exit code for bad input."""
    print(f"pictures.py: {message}", file=sys.stderr)
    raise SystemExit(2)


def read_steps(folder):
    """The (time, [files]) of DIR/fields/fields.pvd, ascending in time."""
    collection = folder / "fields" / "fields.pvd"
    if not folder.is_dir():
        stop(f"{folder} is not a folder; give the folder that `crumple run --out` wrote")
    if not collection.is_file():
        stop(f"{collection} is missing; was the run started with output.field_interval < 0, or is it still starting?")
    try:
        root = xml.parse(collection).getroot()
    except xml.ParseError as error:
        stop(f"{collection} is not a ParaView collection: {error}")
    steps = {}
    for entry in root.iter("DataSet"):
        steps.setdefault(float(entry.get("timestep", "0")), []).append(collection.parent / entry.get("file", ""))
    if not steps:
        stop(f"{collection} names no time steps; the run has written no fields yet")
    return sorted(steps.items())


def nearest(steps, times):
    """The steps nearest to the wanted times, each once."""
    chosen = {}
    for wanted in times:
        time, files = min(steps, key=lambda step: abs(step[0] - wanted))
        if abs(time - wanted) > 1e-6 + 1e-3 * abs(wanted):
            print(f"no step at {wanted:g}: using {time:g}")
        chosen[time] = files
    return sorted(chosen.items())


def read_mesh(pv, files):
    """All pieces of one step as one grid, without the copies that workers keep of others' elements."""
    pieces = []
    for file in files:
        if not file.is_file():
            stop(f"{file} is named in fields.pvd but missing; copy the whole fields folder")
        pieces.append(pv.read(file))
    mesh = pieces[0] if len(pieces) == 1 else pv.merge(pieces, merge_points=False)
    if "class" in mesh.cell_data:
        mesh = mesh.extract_cells((mesh.cell_data["class"] != EXTERIOR).nonzero()[0])
    if mesh.n_cells == 0:
        stop(f"{files[0]} holds no elements")
    return mesh


def undeformed(mesh):
    """Points before the deformation."""
    return mesh.points - mesh.point_data["displacement"] if "displacement" in mesh.point_data else mesh.points


def colour_limits(meshes, array, given):
    """One range of colours for all pictures."""
    if given:
        return list(given)
    values = [m.cell_data[array] for m in meshes]
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    return [low, high if high > low else low + 1.0]


def corners(box):
    """The eight corners of a box."""
    return [(x, y, z) for x in box[0:2] for y in box[2:4] for z in box[4:6]]


def aim(scene, view, points):
    """Parallel projection that holds all points, above the colour bar."""
    import numpy as np

    (width, height), towards = VIEWS[view]
    back = np.array(towards) / np.linalg.norm(towards)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    axes = np.stack([right, up, back])
    seen = np.asarray(points, dtype=float) @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    span = (high - low) * MARGIN
    half = 0.5 * max(span[1] / (1.0 - BAR), span[0] * height / width)
    middle = 0.5 * (low + high)
    middle[1] -= BAR * half
    focus = middle @ axes
    scene.enable_parallel_projection()
    scene.camera_position = [tuple(focus + 10.0 * max(span) * back), tuple(focus), tuple(up)]
    scene.camera.parallel_scale = half
    scene.renderer.ResetCameraClippingRange()


def wall_plate(pv, args, box):
    """The rigid wall as a plate behind its face, a little larger than the model's section."""
    import numpy as np

    point, normal = np.array(args.wall[:3]), np.array(args.wall[3:])
    normal = normal / np.linalg.norm(normal)
    along = np.cross(normal, (0.0, 0.0, 1.0) if abs(normal[2]) < 0.9 else (0.0, 1.0, 0.0))
    along /= np.linalg.norm(along)
    up = np.cross(along, normal)
    low, high = np.array(box[0::2]), np.array(box[1::2])
    middle = 0.5 * (low + high)
    centre = middle - ((middle - point) @ normal) * normal
    spans = [abs(axis) @ (high - low) for axis in (along, up)]
    sides = [0.5 * span + 0.15 * max(spans) for span in spans]
    edge = [centre + i * sides[0] * along + j * sides[1] * up for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return pv.PolyData(np.array(edge), faces=[4, 0, 1, 2, 3]).extrude(tuple(-0.05 * max(sides) * normal), capping=True)


def draw(pv, mesh, time, view, colour, limits, start, args, file):
    """One picture."""
    from matplotlib.colors import LinearSegmentedColormap

    array, title, colours = COLOURS[colour]
    scene = pv.Plotter(off_screen=True, window_size=VIEWS[view][0])
    scene.set_background("white")
    shown = mesh
    if view == "front":
        flat = mesh.copy()
        flat.points = undeformed(mesh)
        shown = mesh.extract_cells(
            (flat.cell_centers().points[:, 0] < start[0] + FRONT * (start[1] - start[0])).nonzero()[0]
        )
    whole = array in ("part", "worker", "class")
    count = int(limits[1] - limits[0]) + 1
    scene.add_mesh(
        shown,
        scalars=array,
        preference="cell",
        cmap=LinearSegmentedColormap.from_list("strain", colours) if colours is STRAIN else colours,
        ambient=0.2,
        clim=[limits[0] - 0.5, limits[0] + count - 0.5] if whole else limits,
        n_colors=count if whole else 256,
        annotations={float(limits[0] + i): f"{limits[0] + i:.0f}" for i in range(count)} if whole else None,
        show_edges=args.edges == "yes" or (args.edges == "auto" and (view == "front" or mesh.n_cells < 30000)),
        edge_color="#202020",
        edge_opacity=0.4 if view == "front" else 0.15,
        scalar_bar_args={
            "title": title.format(stress=args.stress_unit, length=args.length_unit) + "\n",
            "color": "black",
            "vertical": False,
            "position_x": 0.3,
            "position_y": 0.05 if whole else 0.02,
            "width": 0.4,
            "height": 0.11,
            "title_font_size": 20,
            "label_font_size": 18,
            "n_labels": 0 if whole else 5,
            "fmt": "%.3g",
        },
    )
    # The whole frame's box at the start and now, so that pictures of one view compare.
    points = corners(shown.bounds) if view == "front" else corners(start) + corners(mesh.bounds)
    if args.wall:
        plate = wall_plate(pv, args, start)
        scene.add_mesh(plate, color="#a9aeb8", ambient=0.5)
        scene.add_mesh(plate.extract_feature_edges(30), color="#505560", line_width=2)
        points += corners(plate.bounds)
    scene.add_text(f"t = {time:.4g} {args.time_unit}", position="upper_right", font_size=16, color="black")
    aim(scene, view, points)
    scene.screenshot(str(file))
    scene.close()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, metavar="DIR", help="folder of the run")
    parser.add_argument("--times", type=float, nargs="+", default=[0.0, 20.0, 40.0, 65.8], help="times to draw")
    parser.add_argument("--out", type=Path, help="folder for the pictures (DIR/pictures)")
    parser.add_argument("--colour", nargs="+", choices=COLOURS, default=["plastic_strain", "worker"])
    parser.add_argument("--views", nargs="+", choices=VIEWS, default=list(VIEWS))
    parser.add_argument("--limits", type=float, nargs=2, metavar=("LOW", "HIGH"), help="range of the colours")
    parser.add_argument(
        "--wall",
        type=float,
        nargs=6,
        metavar=("X", "Y", "Z", "NX", "NY", "NZ"),
        default=[-0.5, 0.0, 0.0, 1.0, 0.0, 0.0],
        help="point and normal of the rigid wall (that of the jeep frame)",
    )
    parser.add_argument("--no-wall", action="store_const", const=None, dest="wall", help="draw no wall")
    parser.add_argument("--edges", choices=("auto", "yes", "no"), default="auto", help="draw the shells' edges")
    parser.add_argument("--time-unit", default="ms")
    parser.add_argument("--length-unit", default="mm")
    parser.add_argument("--stress-unit", default="GPa")
    return parser.parse_args()


def main():
    args = arguments()
    steps = read_steps(args.run)
    try:
        import pyvista as pv
    except ImportError as error:
        stop(f"cannot import pyvista ({error}); pip install pyvista")
    first = read_mesh(pv, steps[0][1])
    points = undeformed(first)
    start = [f(points[:, i]) for i in range(3) for f in (min, max)]
    chosen = [(time, read_mesh(pv, files)) for time, files in nearest(steps, args.times)]
    out = args.out or args.run / "pictures"
    out.mkdir(parents=True, exist_ok=True)
    written = []
    for colour in args.colour:
        array = COLOURS[colour][0]
        lacking = [time for time, mesh in chosen if array not in mesh.cell_data]
        if lacking:
            known = ", ".join(sorted(chosen[0][1].cell_data.keys())) or "none"
            print(f"no cell array `{array}` at t = {lacking[0]:g}: leaving this colour out (arrays: {known})")
            continue
        limits = colour_limits([mesh for _, mesh in chosen], array, args.limits)
        for time, mesh in chosen:
            for view in args.views:
                file = out / f"{colour}_{view}_{time:06.2f}.png"
                draw(pv, mesh, time, view, colour, limits, start, args, file)
                written.append(str(file))
    if not written:
        stop("nothing was drawn")
    print(json.dumps(written, indent=1))


if __name__ == "__main__":
    main()
