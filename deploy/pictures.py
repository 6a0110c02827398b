#!/usr/bin/env python3
"""Pictures of a run: the deformed shells, solids and particles at given times.

Views: from the side (the whole, and the front of the far side close up, seen from the middle), at
an angle, and close up at the front. Grey lines are the outline before the deformation.

    deploy/pictures.py DIR --times 0 20 40 65.8 --out DIR/pictures

DIR is the folder of `crumple run --out DIR`; the script reads its DIR/fields/fields.pvd. For a time
without a step it uses the nearest step. Needs `pip install pyvista`, but no screen.
"""

import argparse
import json
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

# Light grey for zero plastic strain.
STRAIN = ["#c3c9d1", "#5b9bd5", "#2ca58d", "#f4d35e", "#ee6c4d", "#9b1d20"]
# Colours that are easy to distinguish, also in print.
DISTINCT = ["#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#76b7b2", "#edc948", "#b07aa1", "#9c755f"]
# Name on the command line -> cell array, title of the colour bar, colour map
COLOURS = {
    "plastic_strain": ("plastic_strain", "plastic strain [-]", STRAIN),
    "damage": ("damage", "damage [-]", STRAIN),
    "von_mises": ("von_mises", "von Mises stress [{stress}]", "viridis"),
    "thickness": ("thickness", "thickness [{length}]", "viridis"),
    "part": ("part", "part", "tab10"),
    "worker": ("worker", "worker", "tab10"),
    "contact_worker": ("contact_worker", "worker of the contact search", "tab10"),
    "class": ("class", "0 interior, 1 interface, 2 exterior", "Set1"),
}
WHOLE = ("part", "worker", "contact_worker", "class")  # arrays of integers
EXTERIOR = 2  # class of a ghost element
# View -> window [pixel] and its panels from the top down: share of the height, direction from the
# model to the camera, visible part. The model points to -x, y is across, z is up. The cameras of
# the oblique views are behind the face of the wall, so that the wall hides nothing.
SIDE = (0.0, -1.0, 0.0)
VIEWS = {
    "side": ((1600, 1000), [(0.3, SIDE, "all"), (0.7, SIDE, "far front")]),
    "angle": ((1600, 900), [(1.0, (0.55, -1.0, 0.65), "all")]),
    "front": ((1600, 1000), [(1.0, (0.65, -1.0, 0.6), "front")]),
}
# Shells of a close-up: those ahead of the fraction FRONT of the undeformed length; on the far side,
# those beyond the fraction FAR of half the width.
FRONT = 0.17
FAR = 0.8
# Point and normal of the wall of the jeep frame.
JEEP_WALL = [-0.5, 0.0, 0.0, 1.0, 0.0, 0.0]
# Margin around the model, and share of the window's height for the colour bar at the bottom.
MARGIN = 1.06
BAR = 0.14
# Largest number of digits of all labels of a colour bar, which overlap otherwise.
LABELS = 60
# Largest share of shells above the range of the colours, so that a few creases do not set it.
ABOVE = 0.01


def stop(message):
    """End with a message and the exit code for bad input."""
    print(f"pictures.py: {message}", file=sys.stderr)
    raise SystemExit(2)


def read_steps(folder):
    """Pairs (time, [files]) of DIR/fields/fields.pvd, ascending in time."""
    collection = folder / "fields" / "fields.pvd"
    if not folder.is_dir():
        stop(f"{folder} is not a folder; give the folder that `crumple run --out` wrote")
    if not collection.is_file():
        stop(
            f"{collection} is missing; was the run started with output.field_interval < 0,"
            " or is it still starting?"
        )
    try:
        root = xml.parse(collection).getroot()
    except xml.ParseError as error:
        stop(f"{collection} is not a ParaView collection: {error}")
    steps = {}
    for entry in root.iter("DataSet"):
        steps.setdefault(float(entry.get("timestep", "0")), []).append(
            collection.parent / entry.get("file", "")
        )
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
    """All pieces of one step as one grid, without ghost elements."""
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
    return (
        mesh.points - mesh.point_data["displacement"]
        if "displacement" in mesh.point_data
        else mesh.points
    )


def round_up(value, steps=(1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)):
    """The next larger number with few digits."""
    import math

    power = 10.0 ** math.floor(math.log10(value))
    return next(
        (step * power for step in steps if step * power >= value * (1.0 - 1e-9)), 10.0 * power
    )


def colour_limits(meshes, array, given):
    """One range of colours for all pictures; and True if a value is above it."""
    import numpy as np

    values = [m.cell_data[array] for m in meshes]
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    if given:
        limits = list(given)
    elif array in WHOLE or high <= low:
        limits = [low, high if high > low else low + 1.0]
    elif low < 0.0 or low > 0.5 * high:
        limits = [low, high]
    else:
        most = max(float(np.quantile(v, 1.0 - ABOVE)) for v in values)
        limits = [0.0, round_up(max(most, 1e-3 * high))]
    return limits, high > limits[1] * (1.0 + 1e-9)


def number_anew(meshes, names):
    """Replace whole numbers that are far apart, such as ids of parts, by 0, 1, 2 and so on.

    `names` gets the numbers of an array, in this order.
    """
    import numpy as np

    for array in WHOLE:
        if not all(array in mesh.cell_data for mesh in meshes):
            continue
        known = np.unique(np.concatenate([mesh.cell_data[array] for mesh in meshes]))
        if known[-1] - known[0] >= 2 * len(known):
            names[array] = known
            for mesh in meshes:
                mesh.cell_data[array] = np.searchsorted(known, mesh.cell_data[array])


def corners(box):
    """The eight corners of a box."""
    return [(x, y, z) for x in box[0:2] for y in box[2:4] for z in box[4:6]]


def screen_axes(towards):
    """Axes right, up and back of a camera in this direction from the model."""
    import numpy as np

    back = np.array(towards) / np.linalg.norm(towards)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def aim(scene, towards, points, width, height, bar):
    """Parallel projection that shows all points, in a panel of this size [pixel].

    The model is above the colour bar, which has the fraction `bar` of the height. Returns the lower
    right corner of the visible region and the length of a pixel.
    """
    import numpy as np

    axes = screen_axes(towards)
    right, up, back = axes
    seen = np.asarray(points, dtype=float) @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    span = (high - low) * MARGIN
    half = 0.5 * max(span[1] / (1.0 - bar), span[0] * height / width)
    middle = 0.5 * (low + high)
    middle[1] -= bar * half
    focus = middle @ axes
    scene.enable_parallel_projection()
    scene.camera_position = [tuple(focus + 10.0 * max(span) * back), tuple(focus), tuple(up)]
    scene.camera.parallel_scale = half
    scene.renderer.ResetCameraClippingRange()
    return (
        focus + half * width / height * right - half * up + 2.0 * max(span) * back,
        2.0 * half / height,
    )


def scale_bar(pv, scene, towards, corner, pixel, bar, unit):
    """Length scale at the lower right, above the colour bar; its length is a round number."""
    right, up, _ = screen_axes(towards)
    length = round_up(120.0 * pixel, (1.0, 2.0, 5.0, 10.0))
    start = corner - (40.0 * pixel + length) * right + (25.0 + bar) * pixel * up
    scene.add_mesh(pv.Line(start, start + length * right), color="black", line_width=4)
    label = start + 10.0 * pixel * up
    scene.add_point_labels(
        [label],
        [f"{length:g} {unit}"],
        font_size=18,
        text_color="black",
        shape=None,
        show_points=False,
        always_visible=True,
        justification_horizontal="left",
        justification_vertical="bottom",
    )


def hit_a_wall(folder):
    """True if a rigid wall received an impulse in the run."""
    try:
        summary = json.loads((folder / "summary.json").read_text())
    except (OSError, ValueError):
        return False
    return any(summary.get("momentum", {}).get("wall_impulse", []))


def wall_plate(pv, args, box):
    """The rigid wall as a plate behind its face, slightly larger than the section of the model."""
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
    edge = [
        centre + i * sides[0] * along + j * sides[1] * up
        for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return pv.PolyData(np.array(edge), faces=[4, 0, 1, 2, 3]).extrude(
        tuple(-0.05 * max(sides) * normal), capping=True
    )


def outline(mesh):
    """Sharp and free edges of the model before the deformation."""
    flat = mesh.copy()
    flat.points = undeformed(mesh)
    surface = flat.extract_surface(algorithm="dataset_surface").clean(tolerance=1e-6)
    return surface.extract_feature_edges(
        30, boundary_edges=True, non_manifold_edges=True, manifold_edges=False
    )


def panel(pv, scene, mesh, colour, limits, above, start, what, towards, size, bar, args):
    """One view of the model. `bar` is the height of its colour bar [pixel]; 0 for no bar."""
    from matplotlib.colors import LinearSegmentedColormap, ListedColormap

    array, title, colours = COLOURS[colour]
    cut = start[0] + FRONT * (start[1] - start[0])
    shown, ghost = mesh, outline(mesh)
    close = what != "all"
    if close:
        flat = mesh.copy()
        flat.points = undeformed(mesh)
        at = flat.cell_centers().points
        chosen = at[:, 0] < cut
        ghost = ghost.clip("x", origin=(cut, 0.0, 0.0))
        if what == "far front":
            far = 0.5 * (start[2] + start[3]) + FAR * 0.5 * (start[3] - start[2])
            chosen &= at[:, 1] > far
            ghost = ghost.clip("-y", origin=(0.0, far, 0.0))
        shown = mesh.extract_cells(chosen.nonzero()[0])
    whole = array in WHOLE
    count = int(limits[1] - limits[0]) + 1
    numbers = args.names.get(array, range(int(limits[0]), int(limits[0]) + count))
    if colours is STRAIN:
        colours = LinearSegmentedColormap.from_list("strain", colours)
    elif whole:
        colours = ListedColormap([DISTINCT[i % len(DISTINCT)] for i in range(count)])
    title = title.format(stress=args.stress_unit, length=args.length_unit)
    scene.add_mesh(
        shown,
        scalars=array,
        preference="cell",
        cmap=colours,
        point_size=9,  # of particles
        render_points_as_spheres=True,
        ambient=0.2,
        clim=[limits[0] - 0.5, limits[0] + count - 0.5] if whole else limits,
        n_colors=count if whole else 256,
        annotations=(
            {float(limits[0] + i): f"{numbers[i]:.0f}" for i in range(count)}
            if whole and sum(len(str(number)) for number in numbers) <= LABELS
            else None
        ),
        show_edges=args.edges == "yes"
        or (args.edges == "auto" and (close or mesh.n_cells < 30000)),
        edge_color="#202020",
        edge_opacity=0.4 if close else 0.15,
        show_scalar_bar=bar > 0,
        scalar_bar_args=(
            {
                "title": title
                + (f", {limits[1]:g} and above in the last colour" if above else "")
                + "\n",
                "color": "black",
                "vertical": False,
                "position_x": 0.3,
                "position_y": (0.3 if whole else 0.1) * bar / size[1],
                "width": 0.4,
                "height": 0.75 * bar / size[1],
                "title_font_size": 20,
                "label_font_size": 18,
                "n_labels": 0 if whole else 6,
                "fmt": "%.3g",
            }
            if bar > 0
            else None
        ),
    )
    scene.add_mesh(ghost, color="#6b7078", line_width=1.5)
    # The box at the start and now, so that pictures of one view have the same frame.
    points = corners(shown.bounds) + corners(ghost.bounds)
    if args.wall:
        plate = wall_plate(pv, args, start)
        scene.add_mesh(plate, color="#a9aeb8", ambient=0.5)
        scene.add_mesh(plate.extract_feature_edges(30), color="#505560", line_width=2)
        points += corners(plate.bounds)
    corner, pixel = aim(scene, towards, points, *size, bar / size[1])
    scale_bar(pv, scene, towards, corner, pixel, bar, args.length_unit)
    scene.renderer.ResetCameraClippingRange()


def draw(pv, mesh, time, view, colour, limits, above, start, args, file):
    """One picture."""
    (width, height), panels = VIEWS[view]
    weights = [share for share, _, _ in panels]
    scene = pv.Plotter(
        off_screen=True,
        window_size=(width, height),
        shape=(len(panels), 1),
        row_weights=weights,
        border=False,
    )
    scene.set_background("white")
    scene.enable_anti_aliasing("ssaa")
    for row, (share, towards, what) in enumerate(panels):
        scene.subplot(row, 0)
        bar = BAR * height if row + 1 == len(panels) else 0.0
        size = (width, share * height)
        panel(pv, scene, mesh, colour, limits, above, start, what, towards, size, bar, args)
        if row == 0:
            scene.add_text(
                f"t = {time:.4g} {args.time_unit}",
                position="upper_right",
                font_size=14,
                color="black",
            )
    scene.screenshot(str(file))
    scene.close()


def arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("run", type=Path, metavar="DIR", help="folder of the run")
    parser.add_argument(
        "--times", type=float, nargs="+", default=[0.0, 20.0, 40.0, 65.8], help="times to draw"
    )
    parser.add_argument("--out", type=Path, help="folder for the pictures (DIR/pictures)")
    parser.add_argument(
        "--colour", nargs="+", choices=COLOURS, default=["plastic_strain", "worker"]
    )
    parser.add_argument("--views", nargs="+", choices=VIEWS, default=list(VIEWS))
    parser.add_argument(
        "--limits", type=float, nargs=2, metavar=("LOW", "HIGH"), help="range of the colours"
    )
    parser.add_argument(
        "--wall",
        type=float,
        nargs=6,
        metavar=("X", "Y", "Z", "NX", "NY", "NZ"),
        help="point and normal of a rigid wall to draw"
        " (that of the jeep frame if the run has a wall with an impulse)",
    )
    parser.add_argument("--no-wall", action="store_true", help="draw no wall")
    parser.add_argument(
        "--undeformed", action="store_true", help="draw the elements where they were at the start"
    )
    parser.add_argument(
        "--edges", choices=("auto", "yes", "no"), default="auto", help="draw the shells' edges"
    )
    parser.add_argument("--time-unit", default="ms")
    parser.add_argument("--length-unit", default="mm")
    parser.add_argument("--stress-unit", default="GPa")
    return parser.parse_args()


def main():
    args = arguments()
    if args.no_wall:
        args.wall = None
    elif args.wall is None and hit_a_wall(args.run):
        args.wall = JEEP_WALL
    steps = read_steps(args.run)
    try:
        import pyvista as pv
    except ImportError as error:
        stop(f"cannot import pyvista ({error}); pip install pyvista")
    first = read_mesh(pv, steps[0][1])
    points = undeformed(first)
    start = [f(points[:, i]) for i in range(3) for f in (min, max)]
    chosen = [(time, read_mesh(pv, files)) for time, files in nearest(steps, args.times)]
    if args.undeformed:
        for _, mesh in chosen:
            mesh.points = undeformed(mesh)
            mesh.point_data.pop("displacement", None)
    args.names = {}
    if not args.limits:
        number_anew([mesh for _, mesh in chosen], args.names)
    out = args.out or args.run / "pictures"
    out.mkdir(parents=True, exist_ok=True)
    written = []
    for colour in args.colour:
        array = COLOURS[colour][0]
        lacking = [time for time, mesh in chosen if array not in mesh.cell_data]
        if lacking:
            known = ", ".join(sorted(chosen[0][1].cell_data.keys())) or "none"
            print(
                f"no cell array `{array}` at t = {lacking[0]:g}:"
                f" this colour is left out (arrays: {known})"
            )
            continue
        limits, above = colour_limits([mesh for _, mesh in chosen], array, args.limits)
        for time, mesh in chosen:
            for view in args.views:
                file = out / f"{colour}_{view}_{time:06.2f}.png"
                draw(pv, mesh, time, view, colour, limits, above, start, args, file)
                written.append(str(file))
    if not written:
        stop("nothing was drawn")
    print(json.dumps(written, indent=1))


if __name__ == "__main__":
    main()
