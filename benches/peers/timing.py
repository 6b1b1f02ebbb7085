"""How fast MuJoCo and Bullet step the bodies that sgc's own solver steps.

    python timing.py DESIGN|RUN|FOLDER... [--step 1/240] [--times N]

Prints milliseconds for an evaluation (the whole motion of a design, stepping only) and evaluations
per second, the fastest of N rounds in which all take turns. MuJoCo steps in a loop of its own (mujoco.rollout), one thread: as
`sgc export` writes the model (elliptic cone, stiff contacts), also at 1/1000 s, where it is stable more often
(nan: it was not), and with its default contacts and pyramids, which are faster and slide otherwise. Bullet has its parts joined by hinge constraints
(limp: the Python interface gives these no motors) and by its Featherstone tree with position
motors; the loop over the steps is Python's, but only the steps are counted. sgc's own solver and
rapier at its default effort are measured by `cargo bench --bench solver`. On an idle machine, please.
"""

import argparse
import re
import subprocess
import tempfile
import time
import xml.etree.ElementTree as xml
from fractions import Fraction
from pathlib import Path

import mujoco
import mujoco.rollout
import numpy as np

import in_mujoco
from program import designs


def in_mujoco_loop(model, drive):
    """Seconds that MuJoCo needs for a whole motion; none if it is unstable at that step."""
    data = mujoco.MjData(model)
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    state = np.empty(size)
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    room = np.empty((1, len(drive), size)), np.empty((1, len(drive), model.nsensordata))
    start = time.perf_counter()
    mujoco.rollout.rollout(model, data, state[None], drive[None], state=room[0], sensordata=room[1])
    spent = time.perf_counter() - start
    unstable = any(data.warning[w].number for w in (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQACC))
    return float("nan") if unstable else spent


def text(values):
    """Numbers as URDF has them."""
    return " ".join(f"{v:.9g}" for v in np.asarray(values).reshape(-1))


def euler(quaternion):
    """Roll, pitch and yaw of a rotation."""
    m = np.empty(9)
    mujoco.mju_quat2Mat(m, quaternion)
    m = m.reshape(3, 3)
    return [np.arctan2(m[2, 1], m[2, 2]), -np.arcsin(np.clip(m[2, 0], -1, 1)), np.arctan2(m[1, 0], m[0, 0])]


def urdf(model):
    """The bodies of a model of MuJoCo as URDF: links have their frames at their hinges."""
    robot = xml.Element("robot", name="design")
    frame = lambda parent, place, turn=(0, 0, 0): xml.SubElement(parent, "origin", xyz=text(place), rpy=text(turn))
    hinge = {model.jnt_bodyid[j]: j for j in range(model.njnt)}
    at = lambda body: model.jnt_pos[hinge[body]] if body != 1 else np.zeros(3)
    for body in range(1, model.nbody):
        link = xml.SubElement(robot, "link", name=f"body{body}")
        inertial = xml.SubElement(link, "inertial")
        frame(inertial, model.body_ipos[body] - at(body), euler(model.body_iquat[body]))
        xml.SubElement(inertial, "mass", value=text(model.body_mass[body]))
        ixx, iyy, izz = (text(v) for v in model.body_inertia[body])
        xml.SubElement(inertial, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
        for geom in np.flatnonzero(model.geom_bodyid == body):
            collision = xml.SubElement(link, "collision")
            frame(collision, model.geom_pos[geom] - at(body), euler(model.geom_quat[geom]))
            shape, size = xml.SubElement(collision, "geometry"), model.geom_size[geom]
            kind = model.geom_type[geom]
            if kind == mujoco.mjtGeom.mjGEOM_BOX:
                xml.SubElement(shape, "box", size=text(2 * size))
            elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
                xml.SubElement(shape, "sphere", radius=text(size[0]))
            else:
                xml.SubElement(shape, "cylinder", radius=text(size[0]), length=text(2 * size[1]))
        if body == 1:
            continue
        parent = model.body_parentid[body]
        joint = xml.SubElement(robot, "joint", name=f"hinge{body - 2}", type="revolute")
        xml.SubElement(joint, "parent", link=f"body{parent}")
        xml.SubElement(joint, "child", link=f"body{body}")
        frame(joint, model.body_pos[body] + at(body) - at(parent))
        xml.SubElement(joint, "axis", xyz=text(model.jnt_axis[hinge[body]]))
        low, high = model.jnt_range[hinge[body]]
        xml.SubElement(joint, "limit", lower=text(low), upper=text(high), effort="1", velocity="100")
    # Bullet reads no long lines.
    xml.indent(robot)
    return xml.tostring(robot, encoding="unicode")


def in_bullet(model, drive, maximal):
    """Seconds that Bullet needs for a whole motion."""
    import pybullet

    world = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0, 0, -9.81)
        pybullet.setTimeStep(model.opt.timestep)
        pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "design.urdf"
            file.write_text(urdf(model))
            body = pybullet.loadURDF(
                str(file),
                list(model.body_pos[1]),
                useMaximalCoordinates=maximal,
                flags=pybullet.URDF_USE_SELF_COLLISION | pybullet.URDF_USE_INERTIA_FROM_FILE,
            )
        joints = list(range(pybullet.getNumJoints(body)))
        for any_body in range(pybullet.getNumBodies()):
            for link in range(-1, pybullet.getNumJoints(any_body)):
                # Bullet multiplies the coefficients of what touches.
                pybullet.changeDynamics(any_body, link, lateralFriction=0.8**0.5)
        spent = 0.0
        for targets in drive:
            if joints:
                forces = list(model.actuator_forcerange[:, 1])
                pybullet.setJointMotorControlArray(
                    body, joints, pybullet.POSITION_CONTROL, list(targets), forces=forces
                )
            start = time.perf_counter()
            pybullet.stepSimulation()
            spent += time.perf_counter() - start
        return spent
    finally:
        pybullet.disconnect(world)


def own(design, repository):
    """Seconds that sgc's own solver needs, by lanes: the saved drive and fifteen like it."""
    bench = ["cargo", "bench", "-q", "--bench", "solver", "--", "1", str(Path(design).resolve())]
    said = subprocess.run(bench, cwd=repository, capture_output=True, text=True, check=True).stdout
    line = next(line for line in said.splitlines() if "widest" in line)
    rapier = float(line.split()[2])
    lanes = {f"sgc, lanes: {n}": float(ms) / 1000 for n, ms in re.findall(r"(\d+): *([\d.]+)", line)}
    return {"rapier": rapier / 1000, **lanes}


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("paths", nargs="+", metavar="DESIGN|RUN|FOLDER")
    parser.add_argument("--step", type=Fraction, default=Fraction(1, 240), help="in s [1/240]")
    parser.add_argument("--times", type=int, default=3, help="how often [3]")
    parser.add_argument("--no-bullet", action="store_true", help="MuJoCo only")
    options = parser.parse_args()
    repository = Path(__file__).resolve().parents[2]
    ratios = {}
    print(f"{'design':<14} {'hinges':>6}  {'method':<26} {'ms':>9} {'per s':>8}")
    for name, design in designs(options.paths):
        model, drive = in_mujoco.load(design, float(options.step))
        fast, _ = in_mujoco.load(design, float(options.step), (0.02, 1))
        fast.opt.cone, fast.opt.impratio = mujoco.mjtCone.mjCONE_PYRAMIDAL, 1
        often, long_drive = in_mujoco.load(design, 0.001)
        methods = {
            "MuJoCo, elliptic, stiff": lambda: in_mujoco_loop(model, drive),
            "the same at 1/1000 s": lambda: in_mujoco_loop(often, long_drive),
            "MuJoCo, its defaults": lambda: in_mujoco_loop(fast, drive),
        }
        if not options.no_bullet:
            methods["Bullet, constraints, limp"] = lambda: in_bullet(model, drive, True)
            methods["Bullet, Featherstone"] = lambda: in_bullet(model, drive, False)
        spent = {}
        for _ in range(options.times):
            here = {method: run() for method, run in methods.items()} | own(design, repository)
            spent = {method: min(time, spent.get(method, time)) for method, time in here.items()}
        for method, time in spent.items():
            print(f"{name:<14} {model.nu:>6}  {method:<26} {1000 * time:>9.1f} {1 / time:>8.2f}", flush=True)
            for ours in ("sgc, lanes: 1", "sgc, lanes: 16"):
                ratios.setdefault((method, ours), []).append(time / spent[ours])
    print("\ntimes as fast (geometric mean)")
    for (method, ours), values in ratios.items():
        values = [value for value in values if np.isfinite(value)]
        if values and not method.startswith("sgc"):
            print(f"{method:<26} {ours:<15} {np.exp(np.mean(np.log(values))):>8.1f}   on {len(values)}")


if __name__ == "__main__":
    main()
