"""Body poses of .osim models as OpenSim itself computes them.

  python osim_poses.py <data folder> <output.json> <model.osim>...

Needs OpenSim's Python package; README.md says which version made the committed file. For every
model: two poses at random coordinate values, dependent coordinates set by their couplers, written
as 12 numbers a body, the rotation matrix by rows and then the position [m].
"""

import json
import random
import sys

import opensim

# Coordinates take values from their range, at most this wide [rad or m].
WIDEST = 1.0


def couplers(model):
    result = []
    constraints = model.getConstraintSet()
    for i in range(constraints.getSize()):
        coupler = opensim.CoordinateCouplerConstraint.safeDownCast(constraints.get(i))
        if coupler is None or not coupler.get_isEnforced():
            continue
        names = coupler.getIndependentCoordinateNames()
        scale = opensim.PropertyHelper.getValueDouble(coupler.getPropertyByName("scale_factor"))
        result.append((coupler.getDependentCoordinateName(), names.get(0), coupler.getFunction(),
                       scale))
    return result


def random_values(model, generator):
    coordinates = model.getCoordinateSet()
    by_path, path_of = {}, {}
    for i in range(coordinates.getSize()):
        c = coordinates.get(i)
        low, high = max(c.getRangeMin(), -WIDEST), min(c.getRangeMax(), WIDEST)
        path = c.getJoint().getName() + "/" + c.getName()
        by_path[path] = generator.uniform(low, high) if low < high else c.getDefaultValue()
        path_of.setdefault(c.getName(), path)
    for _ in range(coordinates.getSize()):  # chains of couplers settle
        for dependent, independent, function, scale in couplers(model):
            x = opensim.Vector(1, by_path[path_of[independent]])
            by_path[path_of[dependent]] = scale * function.calcValue(x)
    return by_path


def body_poses(model, state):
    model.realizePosition(state)
    result = {}
    bodies = model.getBodySet()
    for i in range(bodies.getSize()):
        body = bodies.get(i)
        X = body.getTransformInGround(state)
        R = X.R().asMat33()
        result[body.getName()] = ([R.get(j, k) for j in range(3) for k in range(3)] +
                                  [X.p().get(j) for j in range(3)])
    return result


def poses_of(path, generator):
    model = opensim.Model(path)
    state = model.initSystem()
    poses = []
    for _ in range(2):
        values = random_values(model, generator)
        coordinates = model.getCoordinateSet()
        for i in range(coordinates.getSize()):
            c = coordinates.get(i)
            c.setLocked(state, False)
            c.setClamped(state, False)
            c.setValue(state, values[c.getJoint().getName() + "/" + c.getName()], False)
        poses.append({"coordinates": values, "bodies": body_poses(model, state)})
    return poses


def main():
    folder, output = sys.argv[1], sys.argv[2]
    opensim.Logger.setLevelString("error")
    result = {"opensim": opensim.GetVersion(), "models": {}}
    for name in sys.argv[3:]:
        result["models"][name] = poses_of(folder + "/" + name, random.Random(name))
    with open(output, "w") as file:
        json.dump(result, file, indent=None, separators=(",", ":"))
        file.write("\n")


main()
