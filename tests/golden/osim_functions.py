"""Values and derivatives of functions as OpenSim itself computes them.

  python osim_functions.py <output.json>

Needs OpenSim's Python package; README.md says which version made the committed file. Each function
is evaluated within its points, at them, and beyond both ends.
"""

import json
import random
import sys

import opensim


def points(generator, count):
    x = [-2.0 + 4.0 * (i + generator.uniform(0.2, 0.8)) / count for i in range(count)]
    return x, [generator.uniform(-1.0, 1.0) for _ in range(count)]


def sampled(function, x, orders, at_points=True):
    """Rows of value and derivatives; piecewise functions are not asked at their kinks."""
    at = [x[0] - 1.5, x[0] - 1e-3, x[-1] + 1e-3, x[-1] + 0.7]
    for left, right in zip(x, x[1:]):
        at += [left + share * (right - left) for share in (0.1, 0.5, 0.8)]
    rows = []
    for each in at + (x if at_points else []):
        arguments = opensim.Vector(1, each)
        row = [each, function.calcValue(arguments)]
        for order in range(1, orders + 1):
            components = opensim.StdVectorInt([0] * order)
            row.append(function.calcDerivative(components, arguments))
        rows.append(row)
    return rows


def xy_function(kind, x, y):
    function = getattr(opensim, kind)()
    for each_x, each_y in zip(x, y):
        function.addPoint(each_x, each_y)
    return function


def main():
    generator = random.Random(7)
    cases = []
    for count in (2, 3, 4, 5, 12):
        x, y = points(generator, count)
        cases.append({"kind": "SimmSpline", "x": x, "y": y,
                      "rows": sampled(xy_function("SimmSpline", x, y), x, 2)})
    for kind in ("PiecewiseLinearFunction", "PiecewiseConstantFunction"):
        x, y = points(generator, 6)
        orders = 1 if kind == "PiecewiseLinearFunction" else 0
        cases.append({"kind": kind, "x": x, "y": y,
                      "rows": sampled(xy_function(kind, x, y), x, orders, False)})
    for degree in (1, 3, 5, 7):
        x, y = points(generator, 12)
        spline = opensim.GCVSpline()
        spline.setDegree(degree)
        for each_x, each_y in zip(x, y):
            spline.addPoint(each_x, each_y)
        cases.append({"kind": "GCVSpline", "half_order": (degree + 1) // 2, "x": x, "y": y,
                      "rows": sampled(spline, x, min(3, degree - 1))})
    step = opensim.StepFunction(-0.5, 1.25, 2.0, -1.0)
    cases.append({"kind": "StepFunction", "values": [-0.5, 1.25, 2.0, -1.0],
                  "rows": sampled(step, [-0.5, 1.25], 2)})
    sine = opensim.Sine(0.7, 2.5, 0.3)
    cases.append({"kind": "Sine", "values": [0.7, 2.5, 0.3],
                  "rows": sampled(sine, [-1.0, 0.2, 1.0], 2)})
    result = {"opensim": opensim.GetVersion(), "functions": cases}
    with open(sys.argv[1], "w") as file:
        json.dump(result, file, separators=(",", ":"))
        file.write("\n")


main()
