"""Where OpenSim's ScaleTool puts the markers of the published run's static trial.

  python rajagopal_run_static.py <shared data> <output.json>

Needs OpenSim's Python package; README.md says which version made the committed file. Rajagopal2016
is scaled by the trial's own setup. The distance is from the scaled model's marker to the measured
one in the pose found [m]: it is by how much the marker was moved on its body.
"""

import json
import os
import shutil
import sys
import tempfile

import opensim

data = os.path.abspath(sys.argv[1])
output = os.path.abspath(sys.argv[2])
source = os.path.join(data, "opensim-models", "Rajagopal_run")
with tempfile.TemporaryDirectory() as folder:
    shutil.copytree(os.path.join(source, "Scale"), os.path.join(folder, "Scale"))
    shutil.copytree(os.path.join(source, "ExpData"), os.path.join(folder, "ExpData"))
    shutil.copy(os.path.join(source, "Rajagopal2016.osim"), os.path.join(folder, "model.osim"))
    os.system(f"chmod -R u+w {folder}")
    os.chdir(os.path.join(folder, "Scale"))
    tool = opensim.ScaleTool("scale_setup_run.xml")
    tool.getGenericModelMaker().setModelFileName("../model.osim")
    tool.getModelScaler().setOutputModelFileName(os.path.join(folder, "scaled.osim"))
    tool.getMarkerPlacer().setOutputModelFileName(os.path.join(folder, "placed.osim"))
    if not tool.run():
        sys.exit("OpenSim could not scale the model")
    model = opensim.Model(os.path.join(folder, "placed.osim"))
    scaled = opensim.Model(os.path.join(folder, "scaled.osim"))
    before = scaled.getMarkerSet()
    markers = {}
    for marker in model.getMarkerSet():
        p, q = marker.get_location(), before.get(marker.getName()).get_location()
        markers[marker.getName()] = {
            "body": marker.getParentFrameName().split("/")[-1],
            "p_BM": [round(p[i], 7) for i in range(3)],
            "distance": round(sum((p[i] - q[i]) ** 2 for i in range(3)) ** 0.5, 7),
        }
with open(output, "w") as file:
    json.dump(markers, file, indent=1)
    file.write("\n")
