#!/usr/bin/env python3
"""Pressurised soft bending chamber: static, large-deformation finite elements (FElupe).

An independent reference solution. All numbers are SI units inside.

Geometry   prism 0 <= x <= L = 80 mm, section 16 x 16 mm, hole 12 (y) x 10 (z) mm whose
           middle is at z = dz; at the tip a plate 80 <= x <= 84 mm closes the hole.
           Only y >= 0 is modelled, u_y = 0 on y = 0. The base x = 0 is fixed.
Elements   27-node hexahedra (full 3x3x3 Gauss integration), pure displacements.
Rubber     felupe.NeoHooke: mu/2 (J^-2/3 tr C - 3) + K/2 (J - 1)^2, E, nu below.
Plate      the same law, 100 E and nu = 0.3.
Pressure   follower load on the hole's walls and on the plate's inner face
           (felupe.SolidBodyPressure).
Winding    energy per rest area c/2 (lambda - 1)^2 for lambda > 1, else 0, with
           lambda = |F t|, t = the hoop direction: e_y on z = +-8 mm, e_z on y = 8 mm.
Sheet      energy per rest area c_s/2 (lambda_x - 1)^2 with lambda_x = |F e_x|, on
           z = +8 mm, both in tension and in compression.
           Both are exact surface energies (no thin layer of elements): a "material"
           whose gradient and Hessian per rest area are integrated on a FElupe boundary
           region (3x3 Gauss points per face). F t holds only in-plane derivatives, so
           it depends on the nodes of the face alone.

Cases      A: bare, dz = -1 mm, also the bend stiffness at p = 0
           B: winding + sheet, dz = 0
           C: winding only, dz = -1 mm

Usage      OMP_NUM_THREADS=1 python chamber.py --case A --nx 16 --nw 1
"""

import argparse
import time
import warnings

import felupe as fem
import numpy as np

try:  # MKL's direct solver if it is installed (pip install pypardiso)
    from pypardiso import spsolve
except ImportError:
    from scipy.sparse.linalg import spsolve

MM = 1e-3
LENGTH, PLATE = 80 * MM, 4 * MM  # length of the chamber, thickness of the plate
HALF = 8 * MM  # half of the section's side (both y and z)
HOLE_Y, HOLE_Z = 6 * MM, 5 * MM  # half sizes of the hole
E_RUBBER, NU_RUBBER = 0.94e6, 0.49
E_PLATE, NU_PLATE = 100 * E_RUBBER, 0.3
C_WINDING = C_SHEET = 2e5  # N/m
KPA = 1e3

CASES = {
    "A": dict(dz=-1 * MM, winding=False, sheet=False, pressures=(10, 20, 30)),
    "B": dict(dz=0 * MM, winding=True, sheet=True, pressures=(30, 60, 90, 120)),
    "C": dict(dz=-1 * MM, winding=True, sheet=False, pressures=(30, 60, 90, 120)),
}


# ---------------------------------------------------------------------------- surface law
class LineFibres:
    """Surface energy c/2 (|F t| - 1)^2 per rest area of fibres along the unit vector t.

    The class has the interface of a FElupe material; `x[0]` is the deformation gradient
    with trailing axes (quadrature points, faces).
    """

    def __init__(self, c, t, tension_only):
        self.c, self.t, self.tension_only = c, np.asarray(t, float), tension_only
        self.x = [np.eye(3), np.zeros(0)]

    def _state(self, F):
        f = np.einsum("iJ...,J->i...", F, self.t)  # deformed fibre vector F t
        stretch = np.sqrt((f * f).sum(axis=0))
        on = np.ones_like(stretch)
        if self.tension_only:
            # lambda = 1 (the rest state) counts as taut: it only matters for the
            # tangent of the very first iteration
            on = (stretch >= 1 - 1e-14).astype(float)
        return f, stretch, on

    def gradient(self, x):
        f, lam, on = self._state(x[0])
        force = on * self.c * (lam - 1) / lam  # W'(lambda) / lambda
        return [np.einsum("...,i...,J->iJ...", force, f, self.t), x[-1]]

    def hessian(self, x):
        f, lam, on = self._state(x[0])
        geo = on * self.c * (lam - 1) / lam  # W' / lambda
        mat = (on * self.c - geo) / lam**2  # (W'' - W' / lambda) / lambda^2
        k = np.einsum("...,i...,k...->ik...", mat, f, f)
        k += np.einsum("...,ik->ik...", geo, np.eye(3))
        return [np.einsum("ik...,J,L->iJkL...", k, self.t, self.t)]


# ---------------------------------------------------------------------------- the model
def spaced(n, grade, ends):
    """n + 1 numbers from 0 to 1 whose spacing narrows towards 0 ("l"), 1 ("r") or both.

    grade = 1 gives equal steps; near a graded end the numbers go like s**grade, which
    suits the corner singularities (hole's edges, clamped base, joint with the plate).
    """
    s = np.linspace(0, 1, n + 1)
    if ends == "l":
        return s**grade
    if ends == "r":
        return 1 - (1 - s) ** grade
    return np.where(s <= 0.5, (2 * s) ** grade / 2, 1 - abs(2 - 2 * s) ** grade / 2)


def build_mesh(dz, nx, nw, ny, nz, grade=1.0, gradex=1.0, outer=False):
    """Hex27 mesh; returns the mesh and a flag per cell (True = plate)."""

    def line(*parts):
        "Grid lines from pieces (start, end, number of elements, grading, graded ends)."
        return np.concatenate(
            [[parts[0][0]]] + [a + (b - a) * spaced(n, g, e)[1:] for a, b, n, g, e in parts]
        )

    g, lo, hi = grade, *(("lr", "lr") if outer else ("r", "l"))
    low, high = dz - HOLE_Z, dz + HOLE_Z
    xs = line((0, LENGTH, nx, gradex, "lr"), (LENGTH, LENGTH + PLATE, nw, 1, "l"))
    ys = line((0, HOLE_Y, ny, g, "r"), (HOLE_Y, HALF, nw, g, hi))
    zs = line((-HALF, low, nw, g, lo), (low, high, nz, g, "lr"), (high, HALF, nw, g, hi))
    n = (len(xs), len(ys), len(zs))
    cube = fem.Cube(a=(0, 0, 0), b=[k - 1 for k in n], n=n)  # index coordinates
    i, j, k = np.rint(cube.points).astype(int).T
    points = np.column_stack([xs[i], ys[j], zs[k]])
    mid = points[cube.cells].mean(axis=1)
    hole = (mid[:, 0] < LENGTH) & (mid[:, 1] < HOLE_Y) & (abs(mid[:, 2] - dz) < HOLE_Z)
    cells = cube.cells[~hole]
    used, inverse = np.unique(cells, return_inverse=True)  # drop the hole's own nodes
    mesh = fem.Mesh(points[used], inverse.reshape(cells.shape), "hexahedron")
    mesh = mesh.add_midpoints_edges().add_midpoints_faces()
    mesh = mesh.add_midpoints_volumes()
    mesh = fem.Mesh(mesh.points, mesh.cells, "hexahedron27")
    return mesh, mesh.points[mesh.cells].mean(axis=1)[:, 0] > LENGTH


class Chamber:
    def __init__(self, case, nx, nw, ny, nz, grade=1.0, gradex=1.0, reduced=False,
                 sri=False, outer=False):
        spec = CASES[case]
        dz = spec["dz"]
        self.mesh, in_plate = build_mesh(dz, nx, nw, ny, nz, grade, gradex, outer)
        x, y, z = self.mesh.points.T
        tol = 1e-9

        def near(a, b):
            return abs(a - b) < tol

        def part(cells):
            m = self.mesh.copy()
            m.update(cells=cells)
            return m

        # --- bodies
        def body(cells, order=2, **moduli):
            region = fem.RegionTriQuadraticHexahedron(
                part(cells), quadrature=fem.GaussLegendre(order=order, dim=3)
            )
            field = fem.FieldContainer([fem.Field(region, dim=3)])
            return fem.SolidBody(fem.NeoHooke(**moduli), field)

        def moduli(E, nu):
            return dict(mu=E / (2 * (1 + nu)), bulk=E / (3 * (1 - 2 * nu)))

        whole = fem.RegionTriQuadraticHexahedron(self.mesh)
        self.field = fem.FieldContainer([fem.Field(whole, dim=3)])
        m = moduli(E_RUBBER, NU_RUBBER)
        cells = self.mesh.cells[~in_plate]
        if sri:  # volumetric part with 2x2x2 points only: approaches from the soft side
            rubber = [body(cells, mu=m["mu"]), body(cells, order=1, bulk=m["bulk"])]
        else:
            rubber = [body(cells, **m)]
        plate = body(self.mesh.cells[in_plate], **moduli(E_PLATE, NU_PLATE))

        # --- boundary regions
        def boundary(mask, order=2):
            region = fem.RegionTriQuadraticHexahedronBoundary(
                self.mesh,
                quadrature=fem.GaussLegendreBoundary(order=order, dim=3),
                only_surface=True,
                mask=mask,
            )
            return region, fem.FieldContainer([fem.Field(region, dim=3)])

        zin = abs(z - dz) < HOLE_Z + tol
        yin = y < HOLE_Y + tol
        wet = (x < LENGTH + tol) & (
            (near(y, HOLE_Y) & zin)
            | (near(abs(z - dz), HOLE_Z) & yin)
            | (near(x, LENGTH) & yin & zin)
        )
        region, field = boundary(wet)
        self.pressure = fem.SolidBodyPressure(field)
        area = LENGTH * (2 * HOLE_Y + 2 * HOLE_Z) + 2 * HOLE_Y * HOLE_Z
        assert np.isclose(region.dV.sum(), area), "inner surface"

        self.items = [*rubber, plate, self.pressure]
        self.fibres = []
        side = x < LENGTH + tol
        order = 1 if reduced else 2  # Gauss points per direction on a face: order + 1
        surfaces = []
        if spec["winding"]:
            surfaces += [
                (side & near(z, HALF), (0, 1, 0), C_WINDING, True, HALF),
                (side & near(z, -HALF), (0, 1, 0), C_WINDING, True, HALF),
                (side & near(y, HALF), (0, 0, 1), C_WINDING, True, 2 * HALF),
            ]
        if spec["sheet"]:
            surfaces += [(side & near(z, HALF), (1, 0, 0), C_SHEET, False, HALF)]
        for mask, t, c, tension_only, width in surfaces:
            region, field = boundary(mask, order)
            assert np.isclose(region.dV.sum(), LENGTH * width), "outer surface"
            item = fem.SolidBody(LineFibres(c, t, tension_only), field)
            self.items.append(item)
            self.fibres.append(item)

        # --- degrees of freedom
        fixed = np.zeros((self.mesh.npoints, 3), bool)
        fixed[near(x, 0)] = True
        fixed[near(y, 0), 1] = True
        self.free = np.flatnonzero(~fixed.ravel())
        self.plate_nodes = np.flatnonzero(x > LENGTH - tol)
        self.outer_nodes = np.flatnonzero(near(x, LENGTH + PLATE))
        self.end_region, self.end_field = boundary(near(x, LENGTH + PLATE))

    # --- assembly: residual and tangent of all items at the current displacements
    def residual(self):
        f = np.zeros(3 * self.mesh.npoints)
        for item in self.items:
            item.field[0].values = self.field[0].values
            r = item.assemble.vector(item.field).toarray().ravel()
            f += r * (item.assemble.multiplier or 1.0)
        return f[self.free]

    def tangent(self):
        "Tangent at the state of the last call of `residual`."
        K = 0
        for item in self.items:
            K = K + item.assemble.matrix(item.field) * (item.assemble.multiplier or 1.0)
        return K.tocsr()[self.free][:, self.free]

    # --- results
    def angle(self, u=None, nodes=None):
        "Rotation of the plate about y (least squares over its nodes), + towards +z."
        nodes = self.plate_nodes if nodes is None else nodes
        u = self.field[0].values if u is None else u
        X = self.mesh.points[nodes][:, [0, 2]]
        x = X + u[nodes][:, [0, 2]]
        X, x = X - X.mean(axis=0), x - x.mean(axis=0)
        return np.arctan2(
            (X[:, 0] * x[:, 1] - X[:, 1] * x[:, 0]).sum(), (X * x).sum()
        )

    def bend_stiffness(self):
        "Couple / angle (N m/rad, whole section) at p = 0, from the tangent at rest."
        self.field[0].values[:] = 0
        self.pressure.update(0.0)
        self.residual()
        K = self.tangent()
        # tractions t_x = -a z on the plate's outer face: a pure couple about y that
        # turns the tip towards +z; its size is M = a * integral of z^2 dA (half: y > 0)
        a = 1e-3 / (2 * HALF * (2 * HALF) ** 3 / 12)  # M = 1e-3 N m, whole section
        r = self.end_region
        zq = fem.Field(r, dim=3, values=self.mesh.points.copy()).interpolate()[2]
        t = np.zeros((3, *zq.shape))
        t[0] = -a * zq
        form = fem.IntegralForm([t], v=self.end_field, dV=r.dV, grad_v=[False])
        f = form.assemble().toarray().ravel()
        # (moment of the assembled forces as a check of the load)
        moment = -2 * (f.reshape(-1, 3)[:, 0] * self.mesh.points[:, 2]).sum()
        assert np.isclose(moment, 1e-3)
        u = np.zeros(f.size)
        u[self.free] = spsolve(K, f[self.free])
        u = u.reshape(-1, 3)
        s = 1e-3  # a small copy, so that the angle is the linear one
        return moment * s / self.angle(u * s)

    def report(self, p):
        u = self.field[0].values
        tip = u[self.outer_nodes].mean(axis=0)
        y, z = self.mesh.points[:, 1:].T
        bulge = (u[:, 1] * (y > HALF - 1e-9)).max()
        lam = [
            np.sqrt((np.einsum("iJqc,J->iqc", b.results.kinematics[0], b.umat.t) ** 2).sum(0))
            for b in self.fibres
        ]
        slack = [l for l, b in zip(lam, self.fibres) if b.umat.tension_only]
        return dict(
            p=p / KPA,
            deg=np.degrees(self.angle()),
            outer=np.degrees(self.angle(nodes=self.outer_nodes)),
            ux=tip[0] / MM,
            uz=tip[2] / MM,
            bulge=bulge / MM,
            lam_max=max((l.max() for l in lam), default=np.nan),
            slack=np.mean(np.concatenate([l.ravel() for l in slack]) < 1) if slack else np.nan,
        )

    # --- Newton iterations with a backtracking line search at one pressure
    def newton(self, p, tol=1e-8, maxiter=25, verbose=False):
        self.pressure.update(p)
        # reference force: the nodal pressure forces at p
        load = np.linalg.norm(
            self.pressure.assemble.vector(self.pressure.field).toarray().ravel()[self.free]
        )
        r = self.residual()
        norm = np.linalg.norm(r)
        for it in range(maxiter):
            if norm < tol * load:
                return it
            dx = spsolve(self.tangent(), -r)
            if not np.isfinite(dx).all():
                break
            u0, step = self.field[0].values.copy(), 1.0
            while True:
                u = u0.copy().ravel()
                u[self.free] += step * dx
                self.field[0].values = u.reshape(-1, 3)
                with np.errstate(all="ignore"):
                    r = self.residual()
                new = np.linalg.norm(r)
                J = np.linalg.det(
                    np.moveaxis(self.items[0].results.kinematics[0], (0, 1), (-2, -1))
                )
                # full Newton steps may raise the residual for a while (bending is
                # geometrically soft): only steps that turn cells inside out or
                # that blow up are shortened
                grow = 1e3 if it < 4 else 2.0
                if J.min() > 0.05 and new < grow * max(norm, load):
                    break
                step /= 2
                if step < 1 / 64:
                    return None
            norm = new
            if verbose:
                print(f"      it {it} step {step:.3f} |r|/load {norm / load:.2e}", flush=True)
        return None

    def solve_to(self, p0, p1, dp, verbose=False):
        "From the solution at p0 to p1 with increments <= dp, halved when they fail."
        p, inc, its = p0, dp, 0
        while p < p1 - 1e-6:
            target = min(p + inc, p1)
            keep = self.field[0].values.copy()
            n = self.newton(target, verbose=verbose)
            if n is None:
                self.field[0].values = keep
                self.pressure.update(p)
                self.residual()
                inc /= 2
                if inc < 20:
                    raise RuntimeError(f"no convergence beyond {p / KPA} kPa")
            else:
                its += n
                p = target
        return its


def main():
    a = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    a.add_argument("--case", choices="ABC", required=True)
    a.add_argument("--nx", type=int, default=16, help="elements along x (0..80 mm)")
    a.add_argument("--nw", type=int, default=1, help="elements through each wall")
    a.add_argument("--ny", type=int, help="elements over half the hole's width (nw + 1)")
    a.add_argument("--nz", type=int, help="elements over the hole's height (2 nw)")
    a.add_argument("--dp", type=float, default=10.0, help="largest increment, kPa")
    a.add_argument("--grade", type=float, default=1.0,
                   help="section mesh graded towards the hole's corners (1 = even)")
    a.add_argument("--outer", action="store_true",
                   help="grade the walls towards the outer surface too")
    a.add_argument("--pressures", type=float, nargs="+", help="kPa, instead of the case's")
    a.add_argument("--gradex", type=float, default=1.0,
                   help="mesh along x graded towards base and plate (1 = even)")
    a.add_argument("--sri", action="store_true",
                   help="rubber's volumetric energy with 2x2x2 Gauss points only")
    a.add_argument("--reduced", action="store_true",
                   help="2x2 instead of 3x3 Gauss points per face for winding and sheet")
    a.add_argument("--verbose", action="store_true")
    o = a.parse_args()
    warnings.filterwarnings("ignore")
    start = time.time()
    ny, nz = o.ny or o.nw + 1, o.nz or 2 * o.nw
    ch = Chamber(o.case, o.nx, o.nw, ny, nz, o.grade, o.gradex, o.reduced, o.sri,
                 o.outer)
    print(f"case {o.case}: dz {CASES[o.case]['dz'] / MM:g} mm, nx {o.nx}, nw {o.nw}, hole "
          f"{ny} x {nz}, {ch.mesh.ncells} hex27, {3 * ch.mesh.npoints} dof, face Gauss "
          f"{'2x2' if o.reduced else '3x3'}, grade {o.grade:g}{' (and outer)' if o.outer else ''}, gradex {o.gradex:g}, "
          f"{'SRI' if o.sri else 'full'} integration", flush=True)
    if o.case == "A":
        print(f"bend stiffness at p = 0: {ch.bend_stiffness():.6f} N m/rad", flush=True)
    print("  p kPa  bend deg  (outer face)  tip ux mm  tip uz mm  side bulge mm"
          "  max stretch  slack  its  time s")
    p = 0.0
    for target in o.pressures or CASES[o.case]["pressures"]:
        its = ch.solve_to(p, target * KPA, o.dp * KPA, o.verbose)
        p = target * KPA
        s = ch.report(p)
        print(f"{s['p']:7.1f} {s['deg']:9.4f}  {s['outer']:12.4f} {s['ux']:10.4f} "
              f"{s['uz']:10.4f} {s['bulge']:14.4f} {s['lam_max']:12.5f} {s['slack']:6.3f} "
              f"{its:4d} {time.time() - start:7.1f}", flush=True)


if __name__ == "__main__":
    main()
