"""Where OpenSim's ScaleTool puts the markers of the published run's static trial, and at what cost.

  python rajagopal_run_static.py <shared data> <output.json>

Needs OpenSim's Python package; README.md says which version made the committed file. Rajagopal2016
is scaled by the trial's own setup. The cost is Σ w |Δp|² / Σ w + Σ w Δq², as OpenSim prints it.
"""

import json
import os
import re
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
    log = os.path.join(folder, "log")
    opensim.Logger.addFileSink(log)
    tool = opensim.ScaleTool("scale_setup_run.xml")
    tool.getGenericModelMaker().setModelFileName("../model.osim")
    tool.getMarkerPlacer().setOutputModelFileName(os.path.join(folder, "placed.osim"))
    if not tool.run():
        sys.exit("OpenSim could not scale the model")
    with open(log) as lines:
        cost = re.search(r"total squared error = (\S+),", lines.read()).group(1)
    model = opensim.Model(os.path.join(folder, "placed.osim"))
    markers = {}
    for marker in model.getMarkerSet():
        p = marker.get_location()
        markers[marker.getName()] = {
            "body": marker.getParentFrameName().split("/")[-1],
            "p_BM": [round(p[i], 7) for i in range(3)],
        }
with open(output, "w") as file:
    json.dump({"total_squared_error": float(cost), "markers": markers}, file, indent=1)
    file.write("\n")
