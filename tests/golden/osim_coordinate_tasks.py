"""What OpenSim's InverseKinematicsTool makes of coordinate tasks.

  python osim_coordinate_tasks.py <folder of Gait2354_Simbody> <output.json>

Needs OpenSim's Python package; README.md says which version made the committed file. Every case is
eight frames of the folder's walk, solved to an accuracy of 1e-12: the setup's own tasks; tasks that
pull against the markers, with a value of the model, one of the task and one of a file; the same
with every marker's weight times ten; the same with markers that are missing in some frames. Angles
in degrees, lengths in metres, values of tasks in radians, as OpenSim takes them.
"""

import json
import math
import os
import sys
import tempfile

import opensim

FIRST, COUNT = 30, 8  # rows of the recording; a coordinate file needs six

PULLS = [  # name, weight, value_type, value
    ["knee_angle_r", 0.02, "manual_value", -0.6],
    ["pelvis_list", 0.5, "default_value", 0.0],
    ["hip_flexion_l", 0.01, "from_file", 0.0],
    ["pelvis_ty", 0.3, "manual_value", 1.1],
    ["subtalar_angle_r", 0.005, "default_value", 0.0],
]
HIDDEN = {"R.Shank.Front": [1, 2], "Sternum": [2, 3, 4], "R.Heel": [4, 5]}  # frames of the case


def tasks_of(setup):
    """The setup's tasks as [kind, name, weight, value_type, value]."""
    tool = opensim.InverseKinematicsTool(setup, False)
    found = []
    task_set = tool.get_IKTaskSet()
    for i in range(task_set.getSize()):
        task = task_set.get(i)
        if not task.getApply():
            continue
        coordinate = opensim.IKCoordinateTask.safeDownCast(task)
        found.append(["marker", task.getName(), task.getWeight(), "", 0.0] if coordinate is None else
                     ["coordinate", task.getName(), task.getWeight(), "default_value", 0.0])
    return found


def task_document(tasks):
    text = ""
    for kind, name, weight, value_type, value in tasks:
        element = "IKMarkerTask" if kind == "marker" else "IKCoordinateTask"
        text += f'<{element} name="{name}"><apply>true</apply><weight>{weight!r}</weight>'
        if kind == "coordinate":
            text += f"<value_type>{value_type}</value_type><value>{value!r}</value>"
        text += f"</{element}>\n"
    return f"<IKTaskSet><objects>\n{text}</objects></IKTaskSet>\n"


def write_markers(source, path, hidden):
    """COUNT rows of a TRC file, some markers blank; returns the times."""
    with open(source, encoding="utf-8") as file:
        lines = [line.rstrip("\n\r") for line in file]
    names = [name for name in lines[3].split("\t")[2:] if name]
    header = lines[2].split("\t")
    header[2] = str(COUNT)
    rows, times = [], []
    data = [line for line in lines[5:] if line.strip()]
    for i, line in enumerate(data[FIRST:FIRST + COUNT]):
        cells = line.split("\t")[:2 + 3 * len(names)]
        times.append(float(cells[1]))
        for name, frames in hidden.items():
            if i in frames:
                at = 2 + 3 * names.index(name)
                cells[at:at + 3] = ["", "", ""]
        rows.append("\t".join(cells))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines[:2] + ["\t".join(header)] + lines[3:5] + [""] + rows) + "\n")
    return times


def write_coordinates(path, times):
    """Values of hip_flexion_l, which the test computes likewise; OpenSim takes them for degrees."""
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"Coordinates\nversion=1\nnRows={COUNT}\nnColumns=2\ninDegrees=yes\nendheader\n")
        file.write("time\thip_flexion_l\n")
        for i, time in enumerate(times):
            file.write(f"{time!r}\t{math.degrees(0.2 + 0.1 * i)!r}\n")


def solve(folder, tasks, hidden, name):
    times = write_markers(os.path.join(folder, "subject01_walk1.trc"), "case.trc", hidden)
    write_coordinates("case_coordinates.sto", times)
    uses_file = any(task[3] == "from_file" for task in tasks)
    with open("case.xml", "w", encoding="utf-8") as file:
        file.write(f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="40000"><InverseKinematicsTool name="case">
<results_directory>.</results_directory>
<model_file>{os.path.join(folder, "subject01_simbody.osim")}</model_file>
<constraint_weight>Inf</constraint_weight><accuracy>1e-12</accuracy>
{task_document(tasks)}<marker_file>case.trc</marker_file>
<coordinate_file>{"case_coordinates.sto" if uses_file else ""}</coordinate_file>
<time_range>{times[0]!r} {times[-1]!r}</time_range>
<report_errors>false</report_errors>
<output_motion_file>case.mot</output_motion_file></InverseKinematicsTool></OpenSimDocument>
""")
    if not opensim.InverseKinematicsTool("case.xml").run():
        raise SystemExit(f"OpenSim did not solve case '{name}'")
    table = opensim.TimeSeriesTable("case.mot")
    coordinates = {
        label: [float(value) for value in table.getDependentColumn(label).to_numpy()]
        for label in table.getColumnLabels()
    }
    return {"name": name, "tasks": tasks, "hidden": hidden, "coordinates": coordinates}


def main():
    opensim.Logger.setLevelString("error")
    folder, output = (os.path.abspath(path) for path in sys.argv[1:])
    own = tasks_of(os.path.join(folder, "subject01_Setup_IK.xml"))
    markers = [task for task in own if task[0] == "marker"]
    pulls = [["coordinate"] + pull for pull in PULLS]
    heavy = [[kind, name, 10.0 * weight, a, b] for kind, name, weight, a, b in markers]
    with tempfile.TemporaryDirectory() as scratch:
        os.chdir(scratch)
        cases = [
            solve(folder, own, {}, "own tasks"),
            solve(folder, markers + pulls, {}, "pulls"),
            solve(folder, heavy + pulls, {}, "pulls, markers times ten"),
            solve(folder, markers + pulls, HIDDEN, "pulls, markers missing"),
        ]
        os.chdir("/")
    result = {"made_with": opensim.GetVersion(), "first": FIRST, "frames": COUNT, "cases": cases}
    with open(output, "w", encoding="utf-8") as file:
        json.dump(result, file)
        file.write("\n")


main()
