"""What OpenSim makes of models when it scales them: masses, places, sizes and lengths.

  python osim_scaled.py <folder of the models> <output.json> <model.osim>...

Needs OpenSim's Python package; README.md says which version made the committed file. Factors of a
body differ between its axes, except in models where a coupler sets a shift, which OpenSim refuses
to scale so. Vectors and lengths are in metres, in the body's frame; `places` are origins of bodies
in ground with all coordinates at the middle of their range, at most 0.5 wide [rad or m].
"""

import json
import math
import sys

import opensim

MASS = 70.0  # [kg], of every subject


def numbers(vector):
    return [vector.get(i) for i in range(vector.size())]


def members(component_set):
    return [component_set.get(i) for i in range(component_set.getSize())]


def sets_a_shift(model):
    for constraint in members(model.getConstraintSet()):
        coupler = opensim.CoordinateCouplerConstraint.safeDownCast(constraint)
        if coupler is None:
            continue
        name = coupler.getDependentCoordinateName()
        if model.getCoordinateSet().get(name).getMotionType() == opensim.Coordinate.Translational:
            return True
    return False


def factors_of(model):
    uniform = sets_a_shift(model)
    return {
        body.getName(): [1.0 + 0.15 * math.sin(1 + 3 * i + (0 if uniform else axis))
                         for axis in range(3)]
        for i, body in enumerate(members(model.getBodySet()))
    }


def scale_set(factors):
    result = opensim.ScaleSet()
    for body, f in factors.items():
        scale = opensim.Scale()
        scale.setSegmentName(body)
        scale.setScaleFactors(opensim.Vec3(*f))
        scale.setApply(True)
        result.cloneAndAppend(scale)
    return result


def property_of(component, name):
    return float(component.getPropertyByName(name).toString()) if component.hasProperty(name) else None


def body_numbers(body):
    inertia = body.getInertia()
    moments, products = inertia.getMoments(), inertia.getProducts()
    return {"mass": body.getMass(), "mass_center": numbers(body.getMassCenter()),
            "inertia": numbers(moments) + numbers(products)}


def wrap_objects(body):
    result = {}
    for wrap in members(body.getWrapObjectSet()):
        entry = {"class": wrap.getConcreteClassName(), "translation": numbers(wrap.get_translation())}
        for size in ("radius", "length", "inner_radius", "outer_radius"):
            if wrap.hasProperty(size):
                entry[size] = property_of(wrap, size)
        ellipsoid = opensim.WrapEllipsoid.safeDownCast(wrap)
        if ellipsoid is not None:
            entry["dimensions"] = numbers(ellipsoid.get_dimensions())
        result[wrap.getName()] = entry
    return result


def path_numbers(force, state):
    path = opensim.GeometryPath.safeDownCast(force.getComponent("path")) if force.hasComponent(
        "path") else None
    if path is None:
        return None
    entry = {"wraps": path.getWrapSet().getSize(), "points": []}
    for point in members(path.getPathPointSet()):
        entry["points"].append(numbers(point.getLocation(state)))
    for length in ("optimal_fiber_length", "tendon_slack_length", "resting_length", "slack_length"):
        if force.hasProperty(length):
            entry[length] = property_of(force, length)
    return entry


def path_of(coordinate):
    return "/".join(coordinate.getAbsolutePathString().split("/")[-2:])


def pose(model, state):
    values = {}
    coordinates = members(model.getCoordinateSet())
    for c in coordinates:
        low, high = max(c.getRangeMin(), -0.5), min(c.getRangeMax(), 0.5)
        values[path_of(c)] = 0.5 * (low + high) if not c.isConstrained(state) else None
        c.setLocked(state, False)
        c.setClamped(state, False)
    for c in coordinates:
        if values[path_of(c)] is not None:
            c.setValue(state, values[path_of(c)], False)
    model.assemble(state)
    model.realizePosition(state)
    return {path_of(c): c.getValue(state) for c in coordinates}


def scaled_numbers(path, preserve):
    model = opensim.Model(path)
    model.set_assembly_accuracy(1e-12)
    state = model.initSystem()
    factors = factors_of(model)
    if not model.scale(state, scale_set(factors), preserve, MASS):
        raise SystemExit(f"OpenSim did not scale {path}")
    state = model.initSystem()
    result = {"factors": factors, "mass": MASS, "preserve_mass_distribution": preserve,
              "bodies": {}, "wrap_objects": {}, "paths": {}, "markers": {}}
    for body in members(model.getBodySet()):
        result["bodies"][body.getName()] = body_numbers(body)
        wraps = wrap_objects(body)
        if wraps:
            result["wrap_objects"][body.getName()] = wraps
    for force in members(model.getForceSet()):
        entry = path_numbers(force, state)
        if entry is not None:
            result["paths"][force.getName()] = entry
    for marker in members(model.getMarkerSet()):
        result["markers"][marker.getName()] = numbers(marker.get_location())
    result["coordinates"] = pose(model, state)
    result["places"] = {
        body.getName(): numbers(body.getPositionInGround(state))
        for body in members(model.getBodySet())
    }
    return result


def main():
    opensim.Logger.setLevelString("error")
    folder, output, models = sys.argv[1], sys.argv[2], sys.argv[3:]
    result = {model: scaled_numbers(f"{folder}/{model}", i % 2 == 1)
              for i, model in enumerate(models)}
    with open(output, "w", encoding="utf-8") as file:
        json.dump({"made_with": opensim.GetVersion(), "models": result}, file)
        file.write("\n")


main()
