"""Compares how ezc3d reads C3D files that sinew wrote with how sinew reads them, and, where ezc3d
can read the recording that sinew wrote again, with how it reads that: points, what is missing,
residuals, cameras, samples, events and parameters.  Usage: ezc3d_test.py SINEW FOLDER [FILE...]"""

import csv
import math
import os
import re
import signal
import subprocess
import sys
import traceback

import ezc3d
import numpy as np

SECONDS = 60  # ezc3d reads one of the published recordings for ever

# What write_c3d brings up to date, because how numbers are stored is its own choice.
OURS = {
    "POINT": {"USED", "SCALE", "RATE", "DATA_START", "FRAMES", "LONG_FRAMES", "UNITS"},
    "ANALOG": {"USED", "SCALE", "OFFSET", "OFFSETS", "GEN_SCALE", "RATE", "FORMAT", "UNITS"},
    "TRIAL": {"ACTUAL_START_FIELD", "ACTUAL_END_FIELD"},
    "EVENT": {"TIMES"},
}


class Different(Exception):
    pass


def expect(holds, what):
    if not holds:
        raise Different(what)


def expect_near(ours, theirs, tolerance, what):
    """tolerance: an array or a number; NaN must stand where NaN stands."""
    ours, theirs = np.asarray(ours, float), np.asarray(theirs, float)
    expect(ours.shape == theirs.shape, f"{what}: {ours.shape} instead of {theirs.shape}")
    expect(np.array_equal(np.isnan(ours), np.isnan(theirs)), f"{what}: other values are missing")
    wrong = np.abs(ours - theirs) > tolerance
    if wrong.any():
        at = tuple(int(i[0]) for i in np.nonzero(wrong))
        raise Different(f"{what} at {at}: {ours[at]!r} instead of {theirs[at]!r}")


def convert(sinew, source, target, *options):
    result = subprocess.run(
        [sinew, "convert", str(source), "--out", str(target), *options],
        capture_output=True, text=True)
    expect(result.returncode == 0, f"sinew convert {options}: {result.stderr}")
    return result.stderr


def texts(parameters, group, name):
    """NAME, NAME2, NAME3, ... together."""
    found, i = [], 1
    while name + (str(i) if i > 1 else "") in parameters.get(group, {}):
        found += parameters[group][name + (str(i) if i > 1 else "")]["value"]
        i += 1
    return [text.split("\0")[0].strip() for text in found]


def unique(labels, count):
    """As sinew names them: a second A is A_2, blank ones are unnamed_1, ..."""
    result, copies, blank = [], {}, 0
    for label in (labels + [""] * count)[:count]:
        if not label:
            blank += 1
            result.append(f"unnamed_{blank}")
            continue
        copies[label] = copies.get(label, 0) + 1
        result.append(label if copies[label] == 1 else f"{label}_{copies[label]}")
    return result


def read_csv(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    values = [[float(cell) if cell else math.nan for cell in row] for row in rows[1:]]
    return rows[0][1:], np.array(values).reshape(len(values), -1)[:, 1:]


METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "mete": 1.0}


def compare_with_sinew(sinew, ours, written, folder):
    """`ours`: what ezc3d found in the file `written`; beside what sinew says of it."""
    labels = texts(ours["parameters"], "POINT", "LABELS")
    metres = METRES[texts(ours["parameters"], "POINT", "UNITS")[0]]
    points = ours["data"]["points"]
    if points.shape[1] > 0:
        convert(sinew, written, folder / "markers.csv", "--up", "keep")
        names, values = read_csv(folder / "markers.csv")
        names = [name[:-2] for name in names[::3]]
        expect(labels[: len(names)] == names, "markers have other names")
        if points.shape[2] > 65535:
            # ezc3d then goes on to the end of the file, whose last block is padded.
            extra = points.shape[2] - len(values)
            expect(0 <= extra * 16 * points.shape[1] < 512, f"{extra} frames too many")
            points = points[:, :, : len(values)]
        theirs = points[:3, : len(names), :].transpose(2, 1, 0).reshape(values.shape) * metres
        # sinew multiplies in double precision what the file has in single; two roundings.
        expect_near(values, theirs, 4e-16 * np.abs(theirs), "markers of sinew")
    samples = ours["data"]["analogs"][0]
    if samples.shape[0] > 0:
        convert(sinew, written, folder / "analog.csv", "--what", "analog")
        names, values = read_csv(folder / "analog.csv")
        expect(texts(ours["parameters"], "ANALOG", "LABELS")[: len(names)] == names,
               "channels have other names")
        expect_near(values, samples.T, 1e-6 * np.abs(samples.T) + 1e-12, "samples of sinew")


def compare_points(original, ours, taken):
    """`taken`: sinew took what is flagged as missing, and said so."""
    a, b = original["data"]["points"][:3], ours["data"]["points"][:3]
    expect(a.shape == b.shape, f"points: {b.shape} instead of {a.shape}")
    names = unique(texts(original["parameters"], "POINT", "LABELS"), a.shape[1])
    places = [texts(ours["parameters"], "POINT", "LABELS").index(name) for name in names]
    b = b[:, places, :]
    missing_a, missing_b = np.isnan(a).any(axis=0), np.isnan(b).any(axis=0)
    # What sinew says is not measured though it is not flagged: at 0, 0, 0, at -1e9.
    odd = (np.nan_to_num(a) == 0.0).all(axis=0) | (np.abs(np.nan_to_num(a)) >= 1e7).any(axis=0)
    quality_a = original["data"]["meta_points"]["residuals"][0]
    expect(not (missing_b & ~missing_a & ~odd).any(), "points are missing that were measured")
    expect(taken or not (missing_a & ~missing_b).any(), "points are there that were not measured")
    both = ~missing_a & ~missing_b
    # The file's integer times its scale is rounded once more.
    expect_near(b[:, both], a[:, both], 1.3e-7 * np.abs(a[:, both]), "points")
    quality_b = ours["data"]["meta_points"]["residuals"][0][places]
    cameras_a = original["data"]["meta_points"]["camera_masks"]
    cameras_b = ours["data"]["meta_points"]["camera_masks"][:, places]
    if np.isfinite(quality_a).all() and not taken:
        markers = both & ~np.isin(names, computed_labels(original))[:, None]
        expect_near(quality_b[markers], quality_a[markers], 1e-4 * np.abs(quality_a[markers]) + 1e-6,
                    "residuals")
        expect(np.array_equal(cameras_a[:, markers], cameras_b[:, markers]), "other cameras")
    return int(both.sum())


def computed_labels(file):
    """Of trajectories that are no markers; sinew keeps no residuals for them."""
    parameters = file["parameters"]
    kinds = ["ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS"]
    kinds += texts(parameters, "POINT", "TYPE_GROUPS")[::2]
    return [label for kind in kinds if "MARKER" not in kind
            for label in texts(parameters, "POINT", kind)]


def compare_samples(original, ours):
    a, b = original["data"]["analogs"][0], ours["data"]["analogs"][0]
    if 0 in a.shape:
        return 0
    expect(a.shape == b.shape, f"samples: {b.shape} instead of {a.shape}")
    # A sample and its offset cancel in single precision.
    largest = np.abs(a).max(axis=1, keepdims=True)
    expect_near(b, a, 2.5e-7 * np.abs(a) + 1e-6 * largest, "samples")
    return a.size


def compare_events(original, ours):
    def events(file):
        group = file["parameters"].get("EVENT", {})
        used = int(group["USED"]["value"][0]) if "USED" in group and len(group["USED"]["value"]) else 0
        # Minutes and seconds by turns, in one dimension or in two.
        times = np.asarray(group["TIMES"]["value"]) if used else np.zeros((2, 0))
        times = times if times.ndim == 2 else times.reshape(-1, 2).T
        seconds = (60.0 * times[0] + times[1])[:used]
        return seconds, *[texts(file["parameters"], "EVENT", name)[:used]
                          for name in ("LABELS", "CONTEXTS", "SUBJECTS")]
    a, b = events(original), events(ours)
    expect_near(b[0], a[0], 1e-6 * np.abs(a[0]) + 1e-6, "times of events")
    expect(a[1:] == b[1:], f"events {b[1:]} instead of {a[1:]}")
    return len(a[0])


def find_parameter(file, group, name):
    """A group that was not declared has no name to ezc3d, and is GROUP_7, say, when written."""
    for other, parameters in file["parameters"].items():
        if name in parameters and (other == group or (not group and other.startswith("GROUP_"))):
            return parameters[name]["value"]
    return None


def compare_parameters(original, ours, says):
    """Every parameter that the recording has and that sinew does not bring up to date. Of one that
    is given twice sinew takes the first value, and says so, ezc3d the last."""
    twice = re.search(r"is given twice with different values[^(\n]*(?:\(and (\d+) more)?", says)
    pardoned = 1 + int(twice[1] or 0) if twice else 0
    count = 0
    for group, parameters in original["parameters"].items():
        for name, parameter in parameters.items():
            base = name.rstrip("0123456789")
            if name.startswith("__") or base in OURS.get(group, ()) or base in ("LABELS", "DESCRIPTIONS"):
                continue
            value = parameter["value"]
            if len(value) == 0:  # ezc3d makes up empty ones
                continue
            other = find_parameter(ours, group, name)
            expect(other is not None, f"{group}:{name} is lost")
            if isinstance(value, list):
                same = [str(x).strip() for x in value] == [str(x).strip() for x in other]
            else:
                same = np.array_equal(value, other, equal_nan=True)
            pardoned -= not same
            expect(same or pardoned >= 0, f"{group}:{name} is {other} instead of {value}")
            count += 1
    return count


def read_within(path):
    """What ezc3d makes of a file, or nothing if it cannot read it."""
    child = os.fork()
    if child == 0:  # it may crash or hang
        signal.alarm(SECONDS)
        try:
            ezc3d.c3d(str(path))
        except BaseException:
            os._exit(1)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    return ezc3d.c3d(str(path)) if status == 0 else None


def is_comparable(original, ours):
    """ezc3d finds the frames and channels of the recording, too."""
    if original is None or original["data"]["points"].shape[2] == 0:
        return False
    shapes = [(file["data"]["points"].shape[1:], file["data"]["analogs"].shape[1])
              for file in (original, ours)]
    return shapes[0] == shapes[1]


def compare(sinew, recording, folder, integers):
    written = folder / "ours.c3d"
    says = convert(sinew, recording, written, *(["--integers"] if integers else []))
    ours = read_within(written)
    expect(ours is not None, "ezc3d cannot read it")
    compare_with_sinew(sinew, ours, written, folder)
    if integers or recording.suffix.lower() != ".c3d":
        return "as sinew does"
    original = read_within(recording)
    if not is_comparable(original, ours):
        return "as sinew does; ezc3d cannot read the recording itself"
    first = original["header"]["points"]["first_frame"], ours["header"]["points"]["first_frame"]
    expect(first[0] == first[1], f"the first frame is {first[1]} instead of {first[0]}")
    points = compare_points(original, ours, "they were taken" in says)
    samples = compare_samples(original, ours)
    return (f"as sinew does, and as the recording: {points} points, {samples} samples, "
            f"{compare_events(original, ours)} events, {compare_parameters(original, ours, says)} parameters")


def write_trc(path, markers, frames, first_frame):
    with open(path, "w") as out:
        out.write(f"PathFileType\t4\t(X/Y/Z)\t{path.name}\n"
                  "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
                  "OrigDataStartFrame\tOrigNumFrames\n"
                  f"100\t100\t{frames}\t{markers}\tmm\t100\t{first_frame}\t{frames}\nFrame#\tTime")
        out.write("".join(f"\tmarker_{i}\t\t" for i in range(markers)) + "\n\t")
        out.write("".join(f"\tX{i}\tY{i}\tZ{i}" for i in range(1, markers + 1)) + "\n\n")
        for frame in range(frames):
            out.write(f"{first_frame + frame}\t{frame / 100}")
            for i in range(markers):
                missing = (frame + 3 * i) % 11 == 5
                out.write("\t\t\t" if missing else f"\t{i + 1}\t{frame % 977 + 0.25}\t-{i + 0.5}")
            out.write("\t\n")


def main():
    from pathlib import Path
    sinew, folder = sys.argv[1], Path(sys.argv[2])
    # More labels than a parameter holds; more frames than a word counts.
    write_trc(folder / "300 markers.trc", 300, 20, 7)
    write_trc(folder / "70000 frames.trc", 1, 70000, 1)
    files = [folder / "300 markers.trc", folder / "70000 frames.trc"]
    files += [Path(file) for file in sys.argv[3:]]
    failed = 0
    for recording in files:
        for integers in (False, True):
            name = f"{recording.parent.name}/{recording.name}{', integers' if integers else ''}"
            try:
                print(f"{name}: {compare(sinew, recording, folder, integers)}", flush=True)
            except Different as difference:
                failed += 1
                print(f"{name}: FAILS: {difference}", flush=True)
            except Exception:
                failed += 1
                print(f"{name}: FAILS: {traceback.format_exc()}", flush=True)
    print(f"ezc3d_test: {2 * len(files)} files, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
