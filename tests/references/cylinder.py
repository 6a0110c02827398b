"""C12: a thick cylinder in plane strain under inner pressure, as a row of cells over the wall.

By symmetry a cell has one displacement u at its inner radius and one at its outer radius. Its mean
strains are those of one point. Four assumptions for the strain that varies over the cell:
(a) none,
(b) the strain of the hourglass modes in worker/fem/src/elements/hexahedron/hourglass.rs (assumed
    strain), with E/(1-nu^2),
(c) the same with shear only, 2 G in both directions,
(d) the strain at 2 points on the radius of a displacement that is linear along it, deviator only.
Prints u(a) over that of Lame, minus one.

    python3 tests/references/cylinder.py > tests/references/cylinder.txt
"""

import numpy as np

A, B = 10.0, 20.0


def solve(n, nu, kind):
    e = 1.0
    g = e / (2 * (1 + nu))
    lame = e * nu / ((1 + nu) * (1 - 2 * nu))
    c = np.array([[lame + 2 * g, lame], [lame, lame + 2 * g]])
    r = np.linspace(A, B, n + 1)
    k = np.zeros((n + 1, n + 1))
    for i in range(n):
        r1, r2 = r[i], r[i + 1]
        h, s = r2 - r1, r1 + r2
        area = 0.5 * h * s  # per radian
        mean = np.array([[-1 / h, 1 / h], [1 / s, 1 / s]])
        stiff = area * mean.T @ c @ mean
        # Amplitude of the hoop strain that varies over the cell: the mode minus the linear field of
        # the trapezoid.
        vary = (np.array([-1.0, 1.0]) - mean[1] * h) / s
        if kind == "assumed strain":
            stiff += area / 3 * e / (1 - nu**2) * np.outer(vary, vary)
        elif kind == "pure shear":
            stiff += area / 3 * 4 * g * np.outer(vary, vary)
        elif kind == "stiffness of the deviator":
            for xi in (-1, 1):
                at = 0.5 * s + 0.5 * h * xi / np.sqrt(3)
                hoop = np.array([(r2 - at) / h, (at - r1) / h]) / at - mean[1]
                weight = 0.5 * h * at
                # Deviator of (0, hoop, 0): 2 G (2/3) hoop^2.
                stiff += weight * 4 / 3 * g * np.outer(hoop, hoop)
        k[i : i + 2, i : i + 2] += stiff
    f = np.zeros(n + 1)
    f[0] = A
    exact = (1 + nu) * A / e * A**2 / (B**2 - A**2) * (1 - 2 * nu + B**2 / A**2)
    return np.linalg.solve(k, f)[0] / exact - 1


for kind in ("one point", "assumed strain", "pure shear", "stiffness of the deviator"):
    for nu in (0.3, 0.49, 0.499):
        errors = [solve(n, nu, kind) for n in (3, 8, 16)]
        order = np.log2(errors[1] / errors[2]) if abs(errors[2]) > 1e-9 else float("nan")
        shown = "  ".join(f"{n}: {100 * x:+.3f} %" for n, x in zip((3, 8, 16), errors))
        print(f"{kind:26} nu {nu:<6} cells over the wall {shown}   order {order:.2f}")
