"""Simulates a saved design in Drake, from MuJoCo's model of what `sgc export` writes of it.

    pip install -r requirements-drake.txt
    python in_drake.py DESIGN|RUN|FOLDER... [--rate HZ] [--scheme SCHEME] [--csv FILE]
    python in_drake.py --slide

A third opinion on gaits that slide, which shares no code with sgc, MuJoCo's contacts or coulomb.py. Contacts are
points that give way (springs with a damper of Hunt and Crossley), and friction is smoothed below a speed of stiction.
Of Drake's discrete schemes `lagged` takes the normal force that friction goes by from the step before: it does not
lift what slides. `sap` and `similar` solve convex problems, as MuJoCo does, and lift a block that slides at 1 m/s by
a centimetre (--slide shows it). `tamsi` slides well, but knows no implicit servos. Servos are Drake's implicit ones,
with a limit to their torque.

Boxes touch the ground by their corners, a cylinder by its lowest point only, which goes to and fro when it lies level
or stands. Shapes of a pair touch in one point. What falls may bounce a little, so that a gait that falls may fall to
another side than with Coulomb's law.
"""

import argparse
import csv
import time

import mujoco
import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    AddContactMaterial,
    Box,
    CollisionFilterDeclaration,
    Cylinder,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, DiscreteContactApproximation
from pydrake.multibody.tree import FixedOffsetFrame, PdControllerGains, RevoluteJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import in_mujoco
from program import designs, score, value

# Of points: stiffness in N/m (a robot of 2 N sinks by some micrometres), dissipation in s/m, speed in m/s below which
# friction is smoothed. Ten times as stiff needs 2000 steps in a second: at 1000 some gaits part from the law and from
# those of 2000.
STIFFNESS, DISSIPATION, STICTION = 1e5, 10.0, 1e-4


def frame(place, quaternion):
    """A frame in another."""
    return RigidTransform(Quaternion(quaternion / np.linalg.norm(quaternion)), place)


class World:
    """Drake's plant of a model of MuJoCo's."""

    def __init__(self, model, scheme="lagged", friction=None):
        if model.npair:
            raise ValueError("pairs with a friction of their own are not known to Drake")
        self.model, self.data = model, mujoco.MjData(model)
        builder = DiagramBuilder()
        plant, scene = AddMultibodyPlantSceneGraph(builder, model.opt.timestep)
        plant.set_discrete_contact_approximation(getattr(DiscreteContactApproximation, f"k{scheme.capitalize()}"))
        plant.mutable_gravity_field().set_gravity_vector(model.opt.gravity)
        plant.set_stiction_tolerance(STICTION)
        self.plant, self.bodies = plant, [plant.world_body()]
        for number in range(1, model.nbody):
            self.body(number)
        soles, boxes, ground = [], [], []
        for geom in range(model.ngeom):
            place = frame(model.geom_pos[geom], model.geom_quat[geom])
            size, mu = model.geom_size[geom], model.geom_friction[geom, 0] if friction is None else friction
            kind = mujoco.mjtGeom(model.geom_type[geom])
            if kind == mujoco.mjtGeom.mjGEOM_BOX:
                boxes.append(self.shape(geom, place, Box(*(2 * size)), mu))
                for signs in np.ndindex(2, 2, 2):
                    corner = RigidTransform(size * (1 - 2 * np.array(signs)))
                    soles.append(self.shape(geom, place @ corner, Sphere(0.0), mu, signs))
            elif kind == mujoco.mjtGeom.mjGEOM_PLANE:
                ground.append(self.shape(geom, place, HalfSpace(), mu))
            elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
                self.shape(geom, place, Sphere(size[0]), mu)
            elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
                self.shape(geom, place, Cylinder(size[0], 2 * size[1]), mu)
            else:
                raise ValueError(f"{kind} is not known here")
        # Corners touch the ground only, and boxes what is not the ground.
        filters = scene.collision_filter_manager()
        moving = [shape for body in self.bodies[1:] for shape in plant.GetCollisionGeometriesForBody(body)]
        for some, others in ((boxes, ground), (soles, moving)):
            filters.Apply(CollisionFilterDeclaration().ExcludeBetween(GeometrySet(some), GeometrySet(others)))
        for i in range(model.nu):
            limit = model.actuator_forcerange[i, 1] if model.actuator_forcelimited[i] else np.inf
            actuator = plant.AddJointActuator(f"servo{i}", self.hinge(i), limit)
            actuator.set_controller_gains(
                PdControllerGains(p=model.actuator_gainprm[i, 0], d=-model.actuator_biasprm[i, 2])
            )
        plant.Finalize()
        diagram = builder.Build()
        context = diagram.CreateDefaultContext()
        self.own = plant.GetMyMutableContextFromRoot(context)
        plant.SetFreeBodyPose(self.own, self.bodies[1], frame(model.qpos0[:3], model.qpos0[3:7]))
        self.simulator, self.steps = Simulator(diagram, context), 0

    def body(self, number):
        """Adds a body and the hinge that it hangs on."""
        model, plant = self.model, self.plant
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, model.body_iquat[number])
        own = (turn.reshape(3, 3) * model.body_inertia[number] / model.body_mass[number]) @ turn.reshape(3, 3).T
        unit = UnitInertia(*own.diagonal(), own[0, 1], own[0, 2], own[1, 2])
        centre = model.body_ipos[number]
        inertia = SpatialInertia(model.body_mass[number], centre, unit.ShiftFromCenterOfMass(centre))
        self.bodies.append(plant.AddRigidBody(f"body{number}", inertia))
        for joint in range(model.body_jntadr[number], model.body_jntadr[number] + model.body_jntnum[number]):
            if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
                continue
            pin = RigidTransform(model.jnt_pos[joint])
            rest = frame(model.body_pos[number], model.body_quat[number]) @ pin
            sides = [
                plant.AddFrame(FixedOffsetFrame(f"{side}{joint}", body.body_frame(), place))
                for side, body, place in (
                    ("in", self.bodies[model.body_parentid[number]], rest),
                    ("out", self.bodies[-1], pin),
                )
            ]
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.inf, np.inf)
            plant.AddJoint(RevoluteJoint(f"joint{joint}", *sides, model.jnt_axis[joint], low, high, 0.0))

    def hinge(self, servo):
        """The joint of a servo."""
        return self.plant.GetJointByName(f"joint{self.model.actuator_trnid[servo, 0]}")

    def shape(self, geom, place, shape, mu, *more):
        """Adds a shape that collides."""
        properties = ProximityProperties()
        AddContactMaterial(DISSIPATION, STIFFNESS, CoulombFriction(mu, mu), properties)
        body = self.bodies[self.model.geom_bodyid[geom]]
        return self.plant.RegisterCollisionGeometry(body, place, shape, f"geom{geom}{more}", properties)

    def step(self, targets):
        """Moves on by one step."""
        if self.model.nu:
            port = self.plant.get_desired_state_input_port(self.bodies[1].model_instance())
            port.FixValue(self.own, np.concatenate([targets, np.zeros(self.model.nu)]))
        self.steps += 1
        self.simulator.AdvanceTo(self.steps * self.model.opt.timestep)

    def show(self):
        """Tells MuJoCo where the bodies are."""
        pose, qpos = self.plant.EvalBodyPoseInWorld(self.own, self.bodies[1]), self.data.qpos
        qpos[:3], qpos[3:7] = pose.translation(), pose.rotation().ToQuaternion().wxyz()
        for joint in range(1, self.model.njnt):
            qpos[self.model.jnt_qposadr[joint]] = self.plant.GetJointByName(f"joint{joint}").get_angle(self.own)
        mujoco.mj_kinematics(self.model, self.data)


def simulate(model, drive, scheme="lagged"):
    """The poses of all elements at times from zero: [row, element, 7]. None if Drake gives up."""
    world = World(model, scheme)
    every = round(1 / in_mujoco.ROWS / model.opt.timestep)
    world.show()
    rows = [in_mujoco.poses(model, world.data)]
    for now, targets in enumerate(drive, 1):
        try:
            world.step(targets)
        except RuntimeError:
            return None
        if now % every == 0:
            world.show()
            rows.append(in_mujoco.poses(model, world.data))
    return np.array(rows)


def slide():
    """Prints how far and how high a body of three cubes goes that starts at 1 m/s, friction 0.8."""
    cubes = "".join(f'<geom type="box" size=".0125 .0125 .0125" pos="{x} 0 0"/>' for x in (-0.05, 0, 0.05))
    print(f"Coulomb: {100 / (2 * 0.8 * 9.81):.2f} cm, always in contact")
    for scheme in ("lagged", "tamsi", "similar", "sap"):
        for rate in (1000, 2000):
            model = mujoco.MjModel.from_xml_string(
                f"""<mujoco><option timestep="{1 / rate}"/><default><geom density="1000" friction=".8 0 0"/></default>
                <worldbody><geom type="plane" size="0 0 1"/><body pos="0 0 .0125"><freejoint/>{cubes}</body></worldbody>
                </mujoco>"""
            )
            world = World(model, scheme)
            for _ in range(rate // 5):
                world.step(())
            world.show()
            start, top = world.data.qpos[:3].copy(), 0.0
            world.plant.SetFreeBodySpatialVelocity(
                world.own, world.bodies[1], SpatialVelocity(np.zeros(3), np.array([1.0, 0, 0]))
            )
            for _ in range(rate // 2):
                world.step(())
                world.show()
                top = max(top, world.data.qpos[2] - start[2])
            print(
                f"{scheme:<8} at {rate} Hz: {100 * (world.data.qpos[0] - start[0]):.2f} cm, rises {1000 * top:.3f} mm"
            )


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("paths", nargs="*", metavar="DESIGN|RUN|FOLDER")
    parser.add_argument("--rate", type=int, default=1000, help="steps in a second, a multiple of 50 [1000]")
    parser.add_argument("--scheme", choices=("lagged", "similar", "sap"), default="lagged", help="of contacts [lagged]")
    parser.add_argument("--csv", metavar="FILE", help="write the table there, too")
    parser.add_argument("--slide", action="store_true", help="how a block slides by each scheme, and no designs")
    options = parser.parse_args()
    if options.slide:
        slide()
    rows = []
    for name, design in designs(options.paths):
        began = time.process_time()
        motion = simulate(*in_mujoco.load(design, 1 / options.rate), options.scheme)
        seconds = time.process_time() - began
        own = float("nan") if motion is None else score(design, in_mujoco.motion(motion))
        rows.append({"design": name, "sgc": value(design, "--step", repr(1 / 1920)), "drake": own, "seconds": seconds})
        print(f"{name:<14} sgc at 1/1920 s {rows[-1]['sgc']:8.2f}   Drake {own:8.2f}   {seconds:.1f} s", flush=True)
    if options.csv and rows:
        with open(options.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
