"""What OpenSim's ScaleTool makes of a setup: places of the markers, masses and inertias.

  python osim_placed.py <folder of a setup> <setup.xml> <scaled model> <output.json>

Needs OpenSim's Python package; README.md says which version made the committed file. The folder is
copied, as the tool writes beside its setup. Places in metres, in the body's frame.
"""

import json
import os
import shutil
import sys
import tempfile

import opensim


def numbers(vector):
    return [vector.get(i) for i in range(vector.size())]


def main():
    opensim.Logger.setLevelString("error")
    folder, setup, scaled, output = sys.argv[1:]
    output = os.path.abspath(output)
    with tempfile.TemporaryDirectory() as copy:
        shutil.copytree(folder, copy, dirs_exist_ok=True, copy_function=shutil.copyfile)
        os.chmod(copy, 0o755)
        os.chdir(copy)
        if not opensim.ScaleTool(setup).run():
            raise SystemExit(f"OpenSim did not scale by {setup}")
        model = opensim.Model(scaled)
        model.initSystem()
        os.chdir("/")
    result = {"made_with": opensim.GetVersion(), "markers": {}, "bodies": {}}
    markers, bodies = model.getMarkerSet(), model.getBodySet()
    for i in range(markers.getSize()):
        result["markers"][markers.get(i).getName()] = numbers(markers.get(i).get_location())
    for i in range(bodies.getSize()):
        body = bodies.get(i)
        inertia = body.getInertia()
        result["bodies"][body.getName()] = {
            "mass": body.getMass(),
            "inertia": numbers(inertia.getMoments()) + numbers(inertia.getProducts())
        }
    with open(output, "w", encoding="utf-8") as file:
        json.dump(result, file)
        file.write("\n")


main()
