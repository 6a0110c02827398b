"""A11: a finite elastic sphere against a rigid, frictionless plane, compared with Hertz theory.

1. static   Axisymmetric small-strain elasticity (Q2 quads) of the whole sphere, pressed on the
            plane by a uniform body force. Contact is nodal and unilateral, with the true circle as
            gap (a QP in the nodal forces, by NNLS). The approach x is the displacement of the
            centre of mass since first contact. Gives F(x).
2. impact   m x'' = -F(x) with that F(x), at V = 1, 0.1, 0.01 m/s.
3. dynamic  The vibrating sphere (Q1 quads, lumped mass, central differences, nodes stopped at the
            plane), with 'lin' = small strain, 'hencky' = finite strain, Kirchhoff stress linear in
            the logarithmic strain ln V, 'nh' = compressible neo-Hooke. With the centre of mass
            driven slowly and damping: quasi-static F(x).

Hertz theory is for half spaces.
Usage: python sphere.py [static] [dyn]     (default: both, some minutes; SI units; prints tables)
"""

import logging, sys, skfem as fe
import numpy as np, scipy.sparse as sp, scipy.sparse.linalg as sl
from scipy.optimize import nnls
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

logging.disable(logging.WARNING)
R, E, NU, RHO = 0.05, 10e6, 0.3, 1000.0
LAM, MU, M = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU), 4 / 3 * np.pi * R**3 * RHO
KH = 4 / 3 * E / (1 - NU**2) * np.sqrt(R)  # Hertz: F = KH x^1.5


def mesh(n, k):
    """Half disc of quads (o-grid, n cells per side of the half core), with a Moebius map.

    The map makes the mesh k times finer at the pole.
    """
    grid = np.arange((n + 1) * (2 * n + 1)).reshape(n + 1, 2 * n + 1)
    pts = [np.array([(i, j - n) for i in range(n + 1) for j in range(2 * n + 1)]) * 0.5 / n]
    quads = [np.array([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]).reshape(4, -1)]
    # Edge of the core, pole to pole.
    path = np.concatenate([grid[:-1, 0], grid[-1, :-1], grid[::-1, -1]])
    th, last = np.linspace(-np.pi / 2, np.pi / 2, len(path)), path
    for s in np.arange(1, n + 1) / n:  # n layers from the core to the circle
        new = sum(map(len, pts)) + np.arange(len(path))
        pts.append((1 - s) * pts[0][path] + s * np.array([np.cos(th), np.sin(th)]).T)
        quads.append(np.array([last[:-1], new[:-1], new[1:], last[1:]]))
        last = new
    p = np.concatenate(pts).T
    a, zeta = (k - 1) / (k + 1), p[1] + 1j * p[0]
    w = (zeta - a) / (1 - a * zeta)
    r, z = R * w.imag, R * (1 + w.real)
    return fe.MeshQuad(np.array([np.where(r < 1e-9, 0, r), z]), np.hstack(quads))


@fe.BilinearForm
def stiff(u, v, w):
    r = w.x[0]
    eu, ev = [(g.grad[0, 0], g.grad[1, 1], g[0] / r, g.grad[0, 1] + g.grad[1, 0]) for g in (u, v)]
    tr = eu[0] + eu[1] + eu[2]
    return (
        2
        * np.pi
        * r
        * (
            LAM * tr * (ev[0] + ev[1] + ev[2])
            + MU * (2 * sum(eu[i] * ev[i] for i in range(3)) + eu[3] * ev[3])
        )
    )


@fe.LinearForm
def volume(v, w):
    return 2 * np.pi * w.x[0] * v[1]


def static(n, k, xs):
    """F and contact radius for each approach in xs (all in one quasi-static table; Q2 elements)."""
    B = fe.Basis(mesh(n, k), fe.ElementVector(fe.ElementQuad2()), intorder=5)
    K, b, (r, z) = stiff.assemble(B), volume.assemble(B), B.doflocs
    isz = np.isin(
        np.arange(B.N), np.concatenate([B.nodal_dofs[1], B.facet_dofs[1], B.interior_dofs[1]])
    )
    free = isz | (r > 1e-9)  # u_r = 0 on the axis
    outer = B.mesh.facets_satisfying(lambda x: np.hypot(x[0], x[1] - R) > R * (1 - 1e-3), True)
    cand = B.get_dofs(outer).all()  # contact candidates; none at the pole (zero Q2 weight)
    cand = cand[isz[cand] & (r[cand] > 1e-9) & (r[cand] < 0.016) & (z[cand] < R)]
    # Mean u_z = 0 <-> body force.
    A = sp.bmat([[K[free][:, free], b[free, None]], [b[None, free], None]], format="csc")
    pos = (np.cumsum(free) - 1)[cand]
    rhs = np.zeros((A.shape[0], len(cand)))
    rhs[pos, np.arange(len(cand))] = 1
    C = sl.splu(A).solve(rhs)[pos]
    C = (C + C.T) / 2  # compliance of the candidates about the centre of mass
    gap, out = R - np.sqrt(R**2 - r[cand] ** 2), []
    for x in xs:  # gap - x + C p >= 0, p >= 0, complementary
        s = gap < 2 * x
        L = np.linalg.cholesky(C[np.ix_(s, s)])
        p = nnls(L.T, np.linalg.solve(L, x - gap[s]), maxiter=5000)[0]
        out.append((p.sum(), r[cand][s][p > 0].max()))
    return np.array(out).T


def impact(V, xs, ratio):
    """t_c, largest approach, F_max of m x'' = -F(x).

    F = ratio * Hertz, with the ratio interpolated in sqrt(x).
    """
    G = PchipInterpolator(np.append(0, np.sqrt(xs)), np.append(1, ratio))
    F = lambda x: KH * max(x, 0) ** 1.5 * G(np.sqrt(max(x, 0)))
    end = lambda t, y: y[0] if y[1] < 0 else 1.0
    end.terminal, end.direction = True, -1
    s = solve_ivp(
        lambda t, y: [y[1], -F(y[0]) / M],
        (0, 0.03 / V**0.2),
        [0, V],
        events=[end, lambda t, y: y[1]],
        rtol=1e-9,
        atol=1e-13,
    )
    return s.t_events[0][0], s.y_events[1][0][0], F(s.y_events[1][0][0])


def piola(H, law):
    """First Piola-Kirchhoff stress (rr, rz, zr, zz, hoop).

    H = (u_r,r  u_r,z  u_z,r  u_z,z  u_r/r).
    """
    if law == "lin":
        t = LAM * (H[0] + H[3] + H[4])
        s = MU * (H[1] + H[2])
        return np.array([t + 2 * MU * H[0], s, s, t + 2 * MU * H[3], t + 2 * MU * H[4]])
    a, b, c, d, h = 1 + H[0], H[1], H[2], 1 + H[3], 1 + H[4]  # F = [[a, b], [c, d]], hoop stretch h
    j = a * d - b * c
    lnJ = np.log(j * h)
    Br, Bz, Bx = a * a + b * b, c * c + d * d, a * c + b * d  # B = F F^T
    if law == "nh":  # Kirchhoff stress tr, tz, tx, th
        tr, tz, tx, th = MU * (Br - 1), MU * (Bz - 1), MU * Bx, MU * (h * h - 1)
    else:  # ln V = (f0 I + f1 B) / 2
        D = np.sqrt((Br - Bz) ** 2 + 4 * Bx**2) + 1e-14
        l2 = (Br + Bz - D) / 2
        f1 = np.log1p(D / l2) / D
        f0 = np.log(l2) - f1 * l2
        tr, tz, tx, th = MU * (f0 + f1 * Br), MU * (f0 + f1 * Bz), MU * f1 * Bx, 2 * MU * np.log(h)
    tr, tz, th = tr + LAM * lnJ, tz + LAM * lnJ, th + LAM * lnJ
    return np.array(
        [
            (tr * d - tx * b) / j,
            (-tr * c + tx * a) / j,
            (tx * d - tz * b) / j,
            (-tx * c + tz * a) / j,
            th / h,
        ]
    )


def dynamic(n, k, V, law, drive=None, damp=0.0, avg=1e-4):
    """Explicit run.

    drive = None: free impact. drive = x_end: the centre of mass moves at V (quasi-static F(x)).
    """
    m = mesh(n, k)
    X, T = m.p.copy(), m.t
    N, ne = X.shape[1], T.shape[1]
    g, rows, cols, vals, W, mass = 1 / np.sqrt(3), [], [], [], [], np.zeros(N)
    sx, sy, smooth = (
        np.array([-1, 1, 1, -1]),
        np.array([-1, -1, 1, 1]),
        lambda P, w: np.convolve(P, np.ones(w) / w, "same"),
    )
    for q, (x, y) in enumerate(zip(g * sx, g * sy)):  # 2 x 2 Gauss points
        S = (1 + sx * x) * (1 + sy * y) / 4
        dS = np.array([sx * (1 + sy * y), sy * (1 + sx * x)]) / 4
        J = np.einsum("ia,jae->eij", dS, X[:, T])
        G = np.linalg.solve(J, np.broadcast_to(dS, (ne, 2, 4)))
        r = S @ X[0, T]
        W.append(2 * np.pi * r * np.abs(np.linalg.det(J)))
        for a in range(4):
            np.add.at(mass, T[a], RHO * W[-1] * S[a])
            for comp, dof, v in (
                (0, 0, G[:, 0, a]),
                (1, 0, G[:, 1, a]),
                (2, 1, G[:, 0, a]),
                (3, 1, G[:, 1, a]),
                (4, 0, S[a] / r),
            ):
                rows.append((comp * 4 + q) * ne + np.arange(ne))
                cols.append(2 * T[a] + dof)
                vals.append(v)
    D = sp.csr_matrix(
        (np.concatenate(vals), (np.concatenate(rows), np.concatenate(cols))), shape=(20 * ne, 2 * N)
    )
    Dt, W, mm, Mt, axis = (
        sp.csr_matrix(D.T),
        np.concatenate(W),
        np.repeat(mass, 2),
        mass.sum(),
        2 * np.flatnonzero(X[0] == 0),
    )
    f = lambda u, law: Dt @ (piola((D @ u).reshape(5, -1), law) * W).ravel()
    v = np.random.default_rng(0).standard_normal(2 * N)
    for _ in range(60):  # power iteration: the highest mode sets the time step
        v[axis] = 0
        v = f(v, "lin") / mm
        om2 = np.linalg.norm(v)
        v /= om2
    dt = (0.8 if law == "lin" else 0.6) * 2 / np.sqrt(1.05 * om2)
    edge = np.flatnonzero((np.abs(np.hypot(X[0], X[1] - R) - R) < 1e-9) & (X[1] < R))
    ez = 2 * edge + 1
    u, v, t, rec, quiet = np.zeros(2 * N), np.tile([0.0, -V], N), 0.0, [], 0
    while True:
        v -= dt * f(u, law) / mm
        v[axis] = 0
        if drive:
            v[1::2] -= mass @ v[1::2] / Mt
            v *= 1 - damp * dt
            v[1::2] -= V
        stop = np.maximum(v[ez], -(X[1, edge] + u[ez]) / dt)  # no node below the plane
        P = mm[ez] @ (stop - v[ez]) / dt
        v[ez] = stop
        u += dt * v
        t += dt
        x = -(mass @ u[1::2]) / Mt
        rec.append((t, x, P))
        quiet = 0 if P else quiet + 1
        if (drive and x > drive) or (
            not drive and quiet > 200 and x < 0.15 * (M * V * V / KH) ** 0.4
        ):
            t, x, P = np.array(rec).T
            return t, x, P, smooth(P, max(1, int(avg / dt))), (mass @ v[1::2]) / Mt


def main(what):
    if "static" in what:
        xs = (
            np.array(
                [0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1, 1.25, 1.5, 1.75, 2, 2.3, 2.6]
            )
            * 1e-3
        )
        for n in (12, 24, 48):  # small loads on a mesh 20 x finer at the pole
            F, a = np.hstack([static(n, 20, xs[:4]), static(n, 8, xs[4:])])
            ratio = F / (KH * xs**1.5)
            print(f"\nSTATIC n={n}\n x mm   F N        F/F_Hertz  a mm    (F/F_Hertz-1)/sqrt(x/R)")
            for q in zip(xs * 1e3, F, ratio, a * 1e3, (ratio - 1) / np.sqrt(xs / R)):
                print("%6.3f %10.4f %8.4f %8.3f %8.3f" % q)
            for V in (1, 0.1, 0.01):
                y, h = np.array(impact(V, xs, ratio)), np.array(impact(V, xs, ratio * 0 + 1))
                print(f"V={V}  t_c, x, F_max:", y, " Hertz:", h, " ratio:", np.round(y / h, 4))
    if "dyn" in what:
        print(
            "\nDYNAMIC  (F_max: moving average 0.1 ms; durations: first to last touch,"
            " and F > 0.3, 1, 2 % of F_max)"
        )
        for n, V, law in [
            (12, 1, "lin"),
            (24, 1, "lin"),
            (48, 1, "lin"),
            (24, 1, "hencky"),
            (48, 1, "hencky"),
            (24, 1, "nh"),
            (24, 0.1, "lin"),
        ]:
            t, x, P, Ps, vo = dynamic(n, 5 if V == 1 else 8, V, law)
            on = [t[q] for q in [P > 0] + [Ps > c * Ps.max() for c in (0.003, 0.01, 0.02)]]
            print(
                "n=%d V=%g %-6s t_c %.4f (%.3f %.3f %.3f) ms"
                "  x %.4f mm  F_max %.2f N  v_out/V %.4f"
                % (n, V, law, *[1e3 * (q[-1] - q[0]) for q in on], x.max() * 1e3, Ps.max(), vo / V),
                flush=True,
            )
        print(
            "\nQUASI-STATIC by the explicit solver (0.1 m/s, damped):"
            " F at x = 0.5, 1, 1.5, 2, 2.5 mm"
        )
        for law in ("lin", "hencky", "nh"):
            t, x, P, Ps, _ = dynamic(12, 5, 0.1, law, drive=2.6e-3, damp=3000.0, avg=5e-4)
            print(law, np.round(np.interp(np.arange(0.5, 2.6, 0.5) * 1e-3, x, Ps), 2), flush=True)


main(sys.argv[1:] or ["static", "dyn"])
