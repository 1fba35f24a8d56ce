"""Body poses and path lengths of a model that Sinew wrote, as OpenSim itself computes them.

  python osim_written.py <written.osim> <output.json>

Needs OpenSim's Python package; README.md says which version made the committed file. Two poses, all
coordinates at random values but those that couplers set; body poses as 12 numbers, the rotation
matrix by rows and then the position [m]; path lengths [m].
"""

import json
import random
import sys

import opensim

# Coordinates take values from their range, at most this wide [rad or m].
WIDEST = 1.0


def set_random(model, state, generator):
    coordinates = model.getCoordinateSet()
    values = {}
    for i in range(coordinates.getSize()):
        c = coordinates.get(i)
        low, high = max(c.getRangeMin(), -WIDEST), min(c.getRangeMax(), WIDEST)
        values[c.getName()] = generator.uniform(low, high)
        c.setClamped(state, False)
        c.setValue(state, values[c.getName()], False)
    values.update(set_coupled(model, state, values))
    model.realizePosition(state)
    return values


def set_coupled(model, state, values):
    """Coordinates that a coupler sets, without moving those that drive it."""
    result = {}
    constraints = model.getConstraintSet()
    for i in range(constraints.getSize()):
        coupler = opensim.CoordinateCouplerConstraint.safeDownCast(constraints.get(i))
        if coupler is None:
            continue
        names = coupler.getIndependentCoordinateNames()
        x = opensim.Vector(names.getSize(), 0.0)
        for j in range(names.getSize()):
            x.set(j, values[names.get(j)])
        name = coupler.getDependentCoordinateName()
        result[name] = coupler.getFunction().calcValue(x)  # Sinew writes no other scale than 1
        model.getCoordinateSet().get(name).setValue(state, result[name], False)
    return result


def body_poses(model, state):
    result = {}
    bodies = model.getBodySet()
    for i in range(bodies.getSize()):
        X = bodies.get(i).getTransformInGround(state)
        R = X.R().asMat33()
        result[bodies.get(i).getName()] = ([R.get(j, k) for j in range(3) for k in range(3)] +
                                           [X.p().get(j) for j in range(3)])
    return result


def path_lengths(model, state):
    result = {}
    forces = model.getForceSet()
    for i in range(forces.getSize()):
        for kind in (opensim.PathActuator, opensim.PathSpring, opensim.Ligament):
            element = kind.safeDownCast(forces.get(i))
            if element is not None:
                path = opensim.GeometryPath.safeDownCast(element.updPath())
                result[element.getName()] = path.getLength(state)
    return result


def main():
    opensim.Logger.setLevelString("error")
    model = opensim.Model(sys.argv[1])
    state = model.initSystem()
    generator = random.Random(1)
    poses = []
    for _ in range(2):
        values = set_random(model, state, generator)
        poses.append({"coordinates": values, "bodies": body_poses(model, state),
                      "lengths": path_lengths(model, state)})
    with open(sys.argv[2], "w") as file:
        json.dump({"opensim": opensim.GetVersion(), "poses": poses}, file, separators=(",", ":"))
        file.write("\n")


main()
