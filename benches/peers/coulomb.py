"""MuJoCo's bodies and collisions with Coulomb's law as it stands, and momenta that are kept: an arbiter.

    python coulomb.py DESIGN|RUN|FOLDER... [--rate HZ] [--twice] [--drake] [--csv FILE]

MuJoCo's contacts are the solution of a convex problem, which lifts a contact that slides off the
ground: its normal acceleration has a term mu * b * (sliding speed), b = 2 / time constant. A
contact that slides therefore hops, the more so the stiffer it is (sliding.py), and what hops goes
elsewhere. To tell whether that is why a gait differs, this takes from MuJoCo all that it knows
of masses, joints and shapes, and where these touch, but does the rest by itself, in double precision:

- Momenta: of a body over a step, its mass times the way of its centre, and for the rotation R -> R'
  vee(R' J R^T - R J R'^T) / h with J = tr(I) / 2 - I (Moser and Veselov, 1991). Before and after a step,
  projected onto what the joints allow where the step begins, they differ by the impulses of gravity, servos and
  contacts. So the discrete principle of Hamilton says (Marsden and West, 2001), which is of second order
  and keeps the momenta of the whole. It is solved by iterating with the mass matrix of that place;
  what an iteration leaves is paid in the next step.
- Servos: torques at the beginning of a step of angles and rates with weights 9/16, 6/16, 1/16 of the next step
  and of the last two (second order, damps what is too stiff: Ascher, Ruuth and Wetton, 1995).
- Contacts (cone.py): rigid, a round cone, in displacements over the step as bodies really move, so that
  what sticks does not creep (Moreau; Stewart and Trinkle).

It shares no code with sgc; test_coulomb.py has its tests. It is compiled when it is first used, which takes a minute.

Where more rigid points press than statics can tell apart (a row of blocks on the ground), Coulomb's law has more than
one solution. Here all points give way alike, by next to nothing: the limit of blocks of equal softness. With `hull`,
points between others of the same body carry nothing, the other extreme. How far the two are apart is what rigid
bodies leave open.

Values in the design's unit: `sgc` at 1/1920 s, `law` at the rate, `twice` at twice the rate, `hull`, `mujoco` and
`drake` at the rate. `ice`: how far the centre of mass goes without friction, at most, level, in um by this program;
it should go nowhere. `left`: steps in per cent that were not solved to a millionth. `seconds`: of one core for `law`.
"""

import argparse
import csv
import time
from collections import namedtuple

import mujoco
import numba
import numpy as np

import cone
import in_mujoco
from program import designs, score, value

# Gaps in m up to which shapes are contacts, beyond what bodies may go in a step.
NEAR = 3e-4
# Overlaps in m that stay; deeper ones are mended by this share in a step, at most so fast in m/s.
SLOP, MEND, FASTEST = 1e-5, 0.2, 0.2
# What is solved: contacts to a share of the greatest impulse, velocities to a share of themselves.
CONTACTS, VELOCITIES = 1e-7, 1e-9
# At most so many iterations of a step.
ITERATIONS = 40
# Steps with a greater share than this left are counted.
UNSOLVED = 1e-6

# A tree of bodies, the first one free and each other one with a hinge; places and axes in the frames of the bodies,
# SI units.
Tree = namedtuple("Tree", "parent offset turn pin axis zero centre mass inertia low high kp kv torque")
# Where a tree is: rotations and places of bodies, their centres of mass, and hinge axes and points on these (world).
Pose = namedtuple("Pose", "turn place centre axis pin")
# Contacts: points, frames (normal first, from the first to the second), gaps, friction, bodies (-1: the world), and
# the middle of each shape that is round, as that rolls.
Touch = namedtuple("Touch", "point frame gap friction bodies round middle")


@numba.njit(cache=True)
def cross(a, b):
    """The cross product."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@numba.njit(cache=True)
def times(matrix, vector):
    """A matrix times a vector (numba's own needs scipy)."""
    out = np.zeros(len(matrix))
    for i in range(len(matrix)):
        for j in range(len(vector)):
            out[i] += matrix[i, j] * vector[j]
    return out


@numba.njit(cache=True)
def product(a, b):
    """The product of two rotations."""
    out = np.zeros((3, 3))
    for i in range(3):
        for k in range(3):
            for j in range(3):
                out[i, j] += a[i, k] * b[k, j]
    return out


@numba.njit(cache=True)
def rotation(axis, angle):
    """The rotation about a unit vector."""
    x, y, z = axis
    c, s = 1 - np.cos(angle), np.sin(angle)
    return np.array(
        [
            [1 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y],
            [c * x * y + s * z, 1 - c * (x * x + z * z), c * y * z - s * x],
            [c * x * z - s * y, c * y * z + s * x, 1 - c * (x * x + y * y)],
        ]
    )


@numba.njit(cache=True)
def advance(place, quaternion, angles, v, h):
    """Coordinates after a step with velocities v: the root's rotation (world) and place, and the hinges."""
    speed = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    half = h * speed / 2
    share = np.sin(half) / speed if speed > 0 else h / 2
    a, b = np.cos(half), share * v[:3]
    w, u = quaternion[0], quaternion[1:]
    out = np.empty(4)
    out[0] = a * w - (b * u).sum()
    out[1:] = a * u + w * b + cross(b, u)
    return place + h * v[3:6], out / np.sqrt((out * out).sum()), angles + h * v[6:]


@numba.njit(cache=True)
def pose(tree, place, quaternion, angles):
    """Where the bodies are."""
    n = len(tree.mass)
    turns, places, centres = np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3))
    axes, pins = np.zeros((n, 3)), np.zeros((n, 3))
    for i in range(n):
        if i == 0:
            size = np.sqrt((quaternion[1:] ** 2).sum())
            axis = quaternion[1:] / size if size > 0 else quaternion[1:]
            turns[0], places[0] = rotation(axis, 2 * np.arctan2(size, quaternion[0])), place
        else:
            p = tree.parent[i]
            rest = product(turns[p], tree.turn[i])
            pins[i] = places[p] + times(turns[p], tree.offset[i]) + times(rest, tree.pin[i])
            axes[i] = times(rest, tree.axis[i])
            turns[i] = product(rest, rotation(tree.axis[i], angles[i - 1] - tree.zero[i]))
            places[i] = pins[i] - times(turns[i], tree.pin[i])
        centres[i] = places[i] + times(turns[i], tree.centre[i])
    return Pose(turns, places, centres, axes, pins)


@numba.njit(cache=True)
def rotations(tree, at, v):
    """Angular velocities of the bodies (world)."""
    out = np.empty((len(tree.mass), 3))
    out[0] = v[:3]
    for i in range(1, len(out)):
        out[i] = out[tree.parent[i]] + v[5 + i] * at.axis[i]
    return out


@numba.njit(cache=True)
def momenta(tree, one, two, h):
    """Of each body between two poses: angular momentum about its centre, momentum (world)."""
    out = np.empty((len(tree.mass), 6))
    for i in range(len(out)):
        inertia = tree.inertia[i]
        own = -inertia.copy()
        for k in range(3):
            own[k, k] += (inertia[0, 0] + inertia[1, 1] + inertia[2, 2]) / 2
        a = product(product(two.turn[i], own), one.turn[i].T)
        out[i, 0], out[i, 1], out[i, 2] = a[2, 1] - a[1, 2], a[0, 2] - a[2, 0], a[1, 0] - a[0, 1]
        out[i, :3] /= h
        out[i, 3:] = tree.mass[i] * (two.centre[i] - one.centre[i]) / h
    return out


@numba.njit(cache=True)
def project(tree, at, wrench):
    """What wrenches on bodies (torque about the centre, force) are in the coordinates of a tree."""
    n = len(wrench)
    whole = wrench.copy()
    out = np.empty(n + 5)
    for i in range(n):
        # About the place of the root, until all are added.
        whole[i, :3] += cross(at.centre[i] - at.place[0], wrench[i, 3:])
    for i in range(n - 1, 0, -1):
        force = whole[i, 3:]
        out[5 + i] = (at.axis[i] * (whole[i, :3] - cross(at.pin[i] - at.place[0], force))).sum()
        whole[tree.parent[i]] += whole[i]
    out[:6] = whole[0]
    return out


@numba.njit(cache=True)
def mass_matrix(tree, at):
    """By composite bodies, all about the root's place: rotations first."""
    n = len(tree.mass)
    inertia, axes, out = np.zeros((n, 6, 6)), np.zeros((n + 5, 6)), np.zeros((n + 5, n + 5))
    for i in range(n):
        c, m = at.centre[i] - at.place[0], tree.mass[i]
        inertia[i, :3, :3] = product(product(at.turn[i], tree.inertia[i]), at.turn[i].T)
        for k in range(3):
            for j in range(3):
                inertia[i, k, j] -= m * c[k] * c[j]
            inertia[i, k, k] += m * (c * c).sum()
            inertia[i, 3 + k, 3 + k] = m
        for k, j, sign in ((0, 1, -1), (1, 2, -1), (2, 0, -1), (1, 0, 1), (2, 1, 1), (0, 2, 1)):
            # m times the cross product with c, at the upper right, and its transpose.
            inertia[i, k, 3 + j] = inertia[i, 3 + j, k] = sign * m * c[3 - k - j]
        if i > 0:
            axes[5 + i, :3] = at.axis[i]
            axes[5 + i, 3:] = cross(at.pin[i] - at.place[0], at.axis[i])
    for i in range(n - 1, 0, -1):
        inertia[tree.parent[i]] += inertia[i]
        push = times(inertia[i], axes[5 + i])
        j = i
        while j > 0:
            out[5 + i, 5 + j] = out[5 + j, 5 + i] = (push * axes[5 + j]).sum()
            j = tree.parent[j]
        out[5 + i, :6], out[:6, 5 + i] = push, push
    out[:6, :6] = inertia[0]
    return out


@numba.njit(cache=True)
def cholesky(matrix):
    """The lower triangle L of L L^T."""
    n = len(matrix)
    low = matrix.copy()
    for j in range(n):
        for k in range(j):
            for i in range(j, n):
                low[i, j] -= low[i, k] * low[j, k]
        low[j:, j] /= np.sqrt(low[j, j])
        low[:j, j] = 0
    return low


@numba.njit(cache=True)
def forward(low, columns):
    """L^-1 times columns, in place."""
    for i in range(len(low)):
        for k in range(i):
            if low[i, k] != 0:
                columns[i] -= low[i, k] * columns[k]
        columns[i] /= low[i, i]


@numba.njit(cache=True)
def backward(low, vector):
    """L^-T times a vector, in place."""
    for i in range(len(low) - 1, -1, -1):
        vector[i] /= low[i, i]
        vector[:i] -= low[i, :i] * vector[i]


@numba.njit(cache=True)
def rows_of(tree, at, touch, near):
    """The Jacobian of contacts (three rows each) and of hinges near a limit (the same, tangents nought), transposed."""
    count = len(touch.gap)
    out = np.zeros((len(tree.mass) + 5, 3 * (count + len(near))))
    for c in range(count):
        for side in range(2):
            body, sign = touch.bodies[c, side], 2.0 * side - 1
            if body < 0:
                continue
            for row in range(3):
                n = sign * touch.frame[c, row]
                out[:3, 3 * c + row] += cross(touch.point[c] - at.place[0], n)
                out[3:6, 3 * c + row] += n
                i = body
                while i > 0:
                    out[5 + i, 3 * c + row] += (at.axis[i] * cross(touch.point[c] - at.pin[i], n)).sum()
                    i = tree.parent[i]
    for c in range(len(near)):
        hinge, sign = near[c] // 2, 1 - 2 * (near[c] % 2)
        out[6 + hinge, 3 * (count + c)] = sign
    return out


@numba.njit(cache=True)
def outer(points, bodies):
    """Which contacts of a body with the world are not at another one, nor on the line between two others (to 10 um)."""
    keep = np.ones(len(points), np.bool_)
    for c in range(len(points)):
        body = bodies[c].max()
        for x in range(len(points)):
            if bodies[c].min() >= 0 or bodies[x].min() >= 0 or bodies[x].max() != body or x == c or not keep[x]:
                continue
            a = points[x] - points[c]
            keep[c] &= (a * a).sum() > 1e-10
            for y in range(x):
                if keep[y] and y != c and bodies[y].min() < 0 and bodies[y].max() == body:
                    b = points[y] - points[c]
                    off = cross(a, b)
                    if (a * b).sum() < 0 and (off * off).sum() < 1e-10 * ((a - b) ** 2).sum():
                        keep[c] = False
    return keep


@numba.njit(cache=True)
def ways(touch, one, two, rows):
    """How far the second body goes from the first at each contact, in its frame, as bodies move from a pose to another.

    Along the normal, something round goes as its middle does and its rotation's vector says: it rolls.
    """
    out = np.zeros(rows)
    for c in range(len(touch.gap)):
        for side in range(2):
            body, sign = touch.bodies[c, side], 2.0 * side - 1
            if body < 0:
                continue
            turn = product(two.turn[body], one.turn[body].T)
            away = touch.point[c] - one.centre[body]
            material = two.centre[body] + times(turn, away) - touch.point[c]
            for row in range(3):
                out[3 * c + row] += sign * (touch.frame[c, row] * material).sum()
            if touch.round[c, side]:
                middle = touch.middle[c, side]
                rolled = two.centre[body] + times(turn, middle - one.centre[body]) - middle
                vector = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
                rolled += cross(vector, touch.point[c] - middle)
                out[3 * c] += sign * (touch.frame[c, 0] * (rolled - material)).sum()
    return out


@numba.njit(cache=True)
def move(tree, at, state, impulse, limits, strained, touch, aim, gravity, h, share):
    """One step from a pose.

    `state` has the coordinates, the velocities of the last step (rotation and place of the root, hinges), those of the
    hinges in the one before, the momenta of the bodies in the last step, and what is missing in these. To start from,
    and overwritten: impulses of contacts (3 each) and of the limits of hinges (2 each), and which servos are at the end
    of their torque (1, -1). `share` is that of the step for which forces act. Returns the pose after the step, the
    state, the residual of contacts, the change of the last iteration, iterations, and sweeps.
    """
    place, quaternion, angles, v, rates, before, owed = state
    n, hinges = len(tree.mass), len(angles)
    wrench = before.copy()
    for i in range(n):
        wrench[i, 3:] += h * share * tree.mass[i] * gravity
    given = project(tree, at, wrench) + owed
    mass = mass_matrix(tree, at)
    near = np.empty(2 * hinges, np.int64)
    count = 0
    for i in range(hinges):
        reach = 0.05 + 2 * h * abs(v[6 + i])
        for side, room in enumerate((angles[i] - tree.low[i + 1], tree.high[i + 1] - angles[i])):
            if room < reach:
                near[count] = 2 * i + side
                count += 1
    near = near[:count]
    contacts = len(touch.gap)
    total = contacts + count
    jacobian = rows_of(tree, at, touch, near)
    friction, allowance, r = np.zeros(total), np.zeros(3 * total), np.zeros(3 * total)
    friction[:contacts] = touch.friction
    r[: 3 * contacts] = impulse
    for c in range(total):
        if c < contacts:
            gap, slop, fastest = touch.gap[c], SLOP, FASTEST
        else:
            i, side = near[c - contacts] // 2, near[c - contacts] % 2
            gap = tree.high[i + 1] - angles[i] if side else angles[i] - tree.low[i + 1]
            slop, fastest = 1e-4, 10.0
            r[3 * c] = limits[near[c - contacts]]
        allowance[3 * c] = gap / h if gap > 0 else -min(MEND * max(-gap - slop, 0.0) / h, fastest)
    # The torque of a servo is c0 - c1 times the rate to come, within bounds.
    last = v[6:].copy()
    c0 = tree.kp[1:] * (aim - angles + h * (8 * last + rates) / 32) - tree.kv[1:] * (6 * last + rates) / 16
    c1 = tree.kp[1:] * h * 9 / 32 + tree.kv[1:] * 9 / 16
    most = tree.torque[1:]
    # A thousandth of the speed that gravity gives in a step counts as none.
    floor = tree.mass.sum() * h * max(np.abs(gravity).max(), 0.1)
    rest = 1e-6 * floor * floor / tree.mass.sum()
    off, change, sweeps, iteration = 0.0, np.inf, 0, 0
    matrix, low, columns, g = mass, mass, jacobian, np.zeros((0, 0))
    v = v.copy()
    new_place, new_quaternion, new_angles = advance(place, quaternion, angles, v, h)
    two = pose(tree, new_place, new_quaternion, new_angles)
    after = momenta(tree, at, two, h)
    held = project(tree, at, after)
    fresh = True
    while iteration < ITERATIONS:
        iteration += 1
        if fresh:
            matrix = mass.copy()
            for i in range(hinges):
                if strained[i] == 0:
                    matrix[6 + i, 6 + i] += h * share * c1[i]
            low = cholesky(matrix)
            columns = jacobian.copy()
            forward(low, columns)
            g = np.zeros((3 * total, 3 * total))
            for k in range(n + 5):
                for i in range(3 * total):
                    if columns[k, i] != 0:
                        g[i] += columns[k, i] * columns[k]
            give = cone.GIVE * np.diag(g).sum() / max(1, 3 * contacts + count)
            for i in range(3 * total):
                g[i, i] += give
        free = given - held + times(mass, v)
        for i in range(hinges):
            free[6 + i] += h * share * (c0[i] if strained[i] == 0 else strained[i] * most[i])
        forward(low, free)
        new = free.copy()
        if total > 0:
            # What contacts go beyond what is linear in the velocities, from the last iteration.
            b = allowance + ways(touch, at, two, 3 * total) / h
            b[: 3 * contacts] -= times(jacobian[:, : 3 * contacts].T, v)
            b += times(columns.T, free)
            off, more = cone.solve(g, b, friction, r, 1e-2 * floor, CONTACTS)
            sweeps += more
            new += times(columns, r)
        backward(low, new)
        way = new - v
        change = (way * times(mass, way)).sum()
        done = change <= VELOCITIES**2 * ((new * times(mass, new)).sum() + rest)
        v = new
        # Servos at the end of their torque, and back: at first all at once, then the one that is most astray.
        fresh, worst, which = False, 1e-9, 0
        for i in range(hinges):
            torque = c0[i] - c1[i] * v[6 + i]
            astray = (most[i] - torque * strained[i] if strained[i] != 0 else abs(torque) - most[i]) / most[i]
            if astray > 1e-9:
                fresh = True
                if iteration < 6:
                    strained[i] = 0 if strained[i] != 0 else np.sign(torque)
            if astray > worst:
                worst, which = astray, i
        if fresh and iteration >= 6:
            strained[which] = 0 if strained[which] != 0 else np.sign(c0[which] - c1[which] * v[6 + which])
        new_place, new_quaternion, new_angles = advance(place, quaternion, angles, v, h)
        two = pose(tree, new_place, new_quaternion, new_angles)
        after = momenta(tree, at, two, h)
        held = project(tree, at, after)
        if done and not fresh:
            break
    left = given - held + times(jacobian, r)
    for i in range(hinges):
        left[6 + i] += h * share * min(max(c0[i] - c1[i] * v[6 + i], -most[i]), most[i])
    impulse[:] = r[: 3 * contacts]
    limits[:] = 0
    for c in range(count):
        limits[near[c]] = r[3 * (contacts + c)]
    change = np.sqrt(change / ((v * times(mass, v)).sum() + rest))
    state = (new_place, new_quaternion, new_angles, v, last, after, left)
    return two, state, off, change, iteration, sweeps


class Stepper:
    """A model (one free body and hinges on it), and its state.

    `place`, `quaternion` and `angles` are the root's and the hinges', `v` their velocities in the step that led
    there: the root's rotation (world) and place, hinges. Steps are counted, and those that were not solved. With
    `hull`, points between others carry nothing.
    """

    def __init__(self, model, v=None, hull=False):
        self.model, self.data, self.hull = model, mujoco.MjData(model), hull
        n = model.nbody - 1
        free = [mujoco.mjtJoint.mjJNT_FREE] + [mujoco.mjtJoint.mjJNT_HINGE] * (n - 1)
        if list(model.jnt_type) != free or (model.body_jntnum[1:] != 1).any() or model.body_parentid[1] != 0:
            raise ValueError("only one free body and bodies that hang on it by a hinge each")
        if any(
            some.any() for some in (model.dof_damping, model.dof_armature, model.dof_frictionloss, model.jnt_stiffness)
        ):
            raise ValueError("joints have springs and dampers, which only servos may have here")

        def matrices(quaternions):
            out = np.empty((n, 9))
            for i in range(n):
                mujoco.mju_quat2Mat(out[i], quaternions[i])
            return out.reshape(n, 3, 3)

        own = matrices(model.body_iquat[1:])
        inertia = np.einsum("nij,nj,nkj->nik", own, model.body_inertia[1:], own)
        servo = np.zeros((3, n))
        servo[2] = np.inf
        for i, joint in enumerate(model.actuator_trnid[:, 0]):
            bound = model.actuator_forcerange[i, 1] if model.actuator_forcelimited[i] else np.inf
            servo[:, joint] = model.actuator_gainprm[i, 0], -model.actuator_biasprm[i, 2], bound
        self.order = model.actuator_trnid[:, 0] - 1
        limited = model.jnt_limited.astype(bool)
        low, high = (np.where(limited, model.jnt_range[:, i], end) for i, end in ((0, -np.inf), (1, np.inf)))
        zero = np.concatenate([[0.0], model.qpos0[7:]])
        self.tree = Tree(
            *(model.body_parentid[1:].astype(np.int64) - 1, model.body_pos[1:].copy(), matrices(model.body_quat[1:])),
            *(model.jnt_pos.copy(), model.jnt_axis.copy(), zero, model.body_ipos[1:].copy()),
            *(model.body_mass[1:].copy(), inertia, low, high, servo[0], servo[1], servo[2]),
        )
        mujoco.mj_kinematics(model, self.data)
        qpos = self.data.qpos
        self.place, self.quaternion, self.angles = qpos[:3].copy(), qpos[3:7].copy(), qpos[7:].copy()
        self.v = np.zeros(n + 5) if v is None else np.array(v, dtype=float)
        h = model.opt.timestep
        self.pose = pose(self.tree, self.place, self.quaternion, self.angles)
        # A step about now: as exact as the steps are.
        sides = [
            pose(self.tree, *advance(self.place, self.quaternion, self.angles, s * self.v, h)) for s in (-0.5, 0.5)
        ]
        self.momenta, self.owed = momenta(self.tree, *sides, h), np.zeros(n + 5)
        self.rates, self.limits, self.memory = self.v[6:].copy(), np.zeros(2 * n - 2), {}
        self.gravity = model.opt.gravity.copy()
        self.size = model.geom_rbound + np.linalg.norm(model.geom_pos, axis=1)
        self.bodies = model.geom_bodyid - 1
        self.round = np.isin(model.geom_type, (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CYLINDER))
        self.target, self.strained = None, np.zeros(n - 1, np.int64)
        self.steps = self.unsolved = self.iterations = self.sweeps = 0
        model.opt.ccd_tolerance = 1e-9

    def contacts(self):
        """What may touch in this step, and a name for each."""
        model, data, h = self.model, self.data, self.model.opt.timestep
        # The gap of a pair counts with the sum of the margins: how far a geom may go in this step.
        moving = self.bodies >= 0
        on = self.bodies[moving]
        speed = np.linalg.norm(self.momenta[:, 3:], axis=1) / self.tree.mass
        turning = np.linalg.norm(rotations(self.tree, self.pose, self.v), axis=1)
        margin = np.full(model.ngeom, NEAR / 2)
        margin[moving] += 1.5 * h * (speed[on] + turning[on] * self.size[moving])
        model.geom_margin[:] = margin
        if model.npair:
            model.pair_margin[:] = margin[model.pair_geom1] + margin[model.pair_geom2]
        self.show()
        mujoco.mj_collision(model, data)
        found = data.contact
        geoms = found.geom
        # MuJoCo knows no friction below 1e-5.
        friction = found.friction[:, 0] * (found.friction[:, 0] > 1e-5)
        touch = Touch(
            *(found.pos.copy(), found.frame.reshape(-1, 3, 3).copy(), found.dist.copy(), friction),
            *(self.bodies[geoms], self.round[geoms], data.geom_xpos[geoms]),
        )
        if self.hull:
            keep = outer(touch.point, touch.bodies)
            touch, geoms = Touch(*(some[keep] for some in touch)), geoms[keep]
        names, count = [], {}
        for pair in map(tuple, geoms):
            count[pair] = count.get(pair, 0) + 1
            names.append((*pair, count[pair]))
        return touch, names

    def show(self):
        """Tells MuJoCo where the bodies are."""
        self.data.qpos[:3], self.data.qpos[3:7], self.data.qpos[7:] = self.place, self.quaternion, self.angles
        mujoco.mj_kinematics(self.model, self.data)

    def step(self, targets):
        """Moves on by one step; `targets` are those of its end, in the order of the actuators."""
        aim = self.angles.copy()
        aim[self.order] = targets
        # Forces act where a step begins. Before the first one there is but half of their time.
        first, self.target, aim = self.target is None, aim, aim if self.target is None else self.target
        touch, names = self.contacts()
        impulse = np.concatenate([self.memory.get(name, np.zeros(3)) for name in names]) if names else np.zeros(0)
        state = (self.place, self.quaternion, self.angles, self.v, self.rates, self.momenta, self.owed)
        h, share = self.model.opt.timestep, 0.5 if first else 1.0
        self.pose, state, off, change, rounds, sweeps = move(
            self.tree, self.pose, state, impulse, self.limits, self.strained, touch, aim, self.gravity, h, share
        )
        self.place, self.quaternion, self.angles, self.v, self.rates, self.momenta, self.owed = state
        self.memory = {name: impulse[3 * i : 3 * i + 3] for i, name in enumerate(names)}
        self.steps, self.iterations, self.sweeps = self.steps + 1, self.iterations + rounds, self.sweeps + sweeps
        self.unsolved += off > UNSOLVED or change > UNSOLVED
        return touch, impulse

    def centre(self):
        """The centre of mass (world)."""
        return self.tree.mass @ self.pose.centre / self.tree.mass.sum()

    def momentum(self):
        """Momentum and angular momentum about the centre of mass (world) of the last step."""
        arms = self.pose.centre - self.centre()
        return self.momenta[:, 3:].sum(0), (self.momenta[:, :3] + np.cross(arms, self.momenta[:, 3:])).sum(0)


def ice(model):
    """Takes all friction away."""
    model.geom_friction[:, 0] = 0
    model.pair_friction[:, :2] = 0
    return model


def simulate(model, drive, stepper=None):
    """The poses of all elements at times from zero: [row, element, 7]."""
    stepper = stepper or Stepper(model)
    stepper.show()
    every = round(1 / in_mujoco.ROWS / model.opt.timestep)
    rows = [in_mujoco.poses(model, stepper.data)]
    for now, targets in enumerate(drive, 1):
        stepper.step(targets)
        if now % every == 0:
            stepper.show()
            rows.append(in_mujoco.poses(model, stepper.data))
    return np.array(rows)


def on_ice(model, drive):
    """How far the centre of mass goes without friction, at most, level, in m."""
    stepper = Stepper(ice(model))
    start, far = stepper.centre(), 0.0
    for targets in drive:
        stepper.step(targets)
        far = max(far, np.hypot(*(stepper.centre() - start)[:2]))
    return far


def measure(name, design, rate, twice=False, drake=False):
    """One row of the table."""

    def scored(rows):
        return float("nan") if rows is None or not np.isfinite(rows).all() else score(design, in_mujoco.motion(rows))

    row = {"design": name, "sgc": value(design, "--step", repr(1 / 1920))}
    model, drive = in_mujoco.load(design, 1 / rate)
    stepper, began = Stepper(model), time.process_time()
    row["law"] = scored(simulate(model, drive, stepper))
    seconds = time.process_time() - began
    if twice:
        row["twice"] = scored(simulate(*in_mujoco.load(design, 0.5 / rate)))
    row["hull"] = scored(simulate(model, drive, Stepper(model, hull=True)))
    row["mujoco"] = scored(in_mujoco.simulate(*in_mujoco.load(design, 1 / rate)))
    if drake:
        import in_drake

        row["drake"] = scored(in_drake.simulate(*in_mujoco.load(design, 1 / rate)))
    row["ice"] = 1e6 * on_ice(model, drive)
    return row | {"left": 100 * stepper.unsolved / stepper.steps, "seconds": seconds}


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("paths", nargs="+", metavar="DESIGN|RUN|FOLDER")
    parser.add_argument("--rate", type=int, default=1000, help="steps in a second, a multiple of 50 [1000]")
    parser.add_argument("--twice", action="store_true", help="at twice the rate, too")
    parser.add_argument("--drake", action="store_true", help="by Drake, too (requirements-drake.txt)")
    parser.add_argument("--csv", metavar="FILE", help="write the table there, too")
    options = parser.parse_args()
    rows = []
    for name, design in designs(options.paths):
        rows.append(measure(name, design, options.rate, options.twice, options.drake))
        if len(rows) == 1:
            print(" ".join(f"{key:>8}" if key != "design" else f"{key:<14}" for key in rows[0]))
        print(
            " ".join(f"{cell:8.2f}" if key != "design" else f"{cell:<14}" for key, cell in rows[-1].items()), flush=True
        )
    if options.csv and rows:
        with open(options.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
