"""Writes a C3D file of as many bytes as asked, reads one by ezc3d, or prints a table of what that
takes beside what it takes sinew to turn the file into a TRC file.
Usage: c3d_large.py write FILE BYTES | read FILE | compare SINEW FILE TRC"""

import os
import struct
import sys
import time

POINTS, CHANNELS, RATIO, RATE = 100, 20, 10, 200.0
FRAME = 4 * (4 * POINTS + CHANNELS * RATIO)


def record(name, group, body):
    body += b"\0"  # no description
    return struct.pack("<bb", len(name), group) + name.encode() + struct.pack("<H", len(body) + 2) + body


def numbers(name, group, kind, values):
    size = {"h": 2, "f": 4}[kind]
    shape = bytes([size, 0]) if len(values) == 1 else bytes([size, 1, len(values)])
    return record(name, group, shape + struct.pack(f"<{len(values)}{kind}", *values))


def texts(name, group, values, width):
    shape = bytes([255, 2, width, len(values)])
    return record(name, group, shape + "".join(v.ljust(width) for v in values).encode())


def word(number):
    """As a signed one."""
    return number - 65536 if number > 32767 else number


def header_and_parameters(frames):
    records = record("POINT", -1, b"") + record("ANALOG", -2, b"") + record("TRIAL", -3, b"")
    records += record("FORCE_PLATFORM", -4, b"") + numbers("USED", 4, "h", [0])
    records += numbers("USED", 1, "h", [POINTS]) + numbers("SCALE", 1, "f", [-0.1])
    records += numbers("RATE", 1, "f", [RATE]) + numbers("DATA_START", 1, "h", [0])
    records += numbers("FRAMES", 1, "h", [word(min(frames, 65535))]) + texts("UNITS", 1, ["mm"], 2)
    records += texts("LABELS", 1, [f"marker{i}" for i in range(POINTS)], 10)
    records += numbers("USED", 2, "h", [CHANNELS]) + numbers("RATE", 2, "f", [RATE * RATIO])
    records += numbers("GEN_SCALE", 2, "f", [1.0]) + numbers("SCALE", 2, "f", [1.0] * CHANNELS)
    records += numbers("OFFSET", 2, "h", [0] * CHANNELS) + texts("UNITS", 2, ["V"] * CHANNELS, 1)
    records += texts("LABELS", 2, [f"channel{i}" for i in range(CHANNELS)], 10)
    records += numbers("ACTUAL_START_FIELD", 3, "h", [1, 0])
    records += numbers("ACTUAL_END_FIELD", 3, "h", [word(frames & 0xFFFF), frames >> 16])
    blocks = (4 + len(records) + 2 + 511) // 512
    head = bytes([2, 0x50]) + struct.pack("<HHHHH", POINTS, CHANNELS * RATIO, 1, min(frames, 65535), 0)
    head += struct.pack("<fHHf", -0.1, 2 + blocks, RATIO, RATE)
    section = bytes([1, 0x50, blocks, 84]) + records.replace(
        numbers("DATA_START", 1, "h", [0]), numbers("DATA_START", 1, "h", [2 + blocks]))
    return head.ljust(512, b"\0") + section.ljust(512 * blocks, b"\0")


def write(path, size):
    import numpy as np
    frames = max(1, size // FRAME)
    random = np.random.default_rng(1)
    rest = random.uniform(-900.0, 1800.0, (POINTS, 3))
    with open(path, "wb") as out:
        out.write(header_and_parameters(frames))
        block = 2000
        for first in range(0, frames, block):
            count = min(block, frames - first)
            seconds = (first + np.arange(count))[:, None, None] / RATE
            points = np.empty((count, POINTS, 4), "<f4")
            phase = np.arange(POINTS)[None, :, None] * 0.3
            points[:, :, :3] = rest + 300.0 * np.sin(2.0 * seconds + phase) + random.normal(
                0.0, 0.05, (count, POINTS, 3))
            points[:, :, 3] = 3.0
            # A marker is hidden for 40 frames now and then.
            hidden = ((first + np.arange(count))[:, None] // 40 + np.arange(POINTS)) % 50 == 0
            points[hidden] = (0.0, 0.0, 0.0, -1.0)
            samples = random.normal(0.0, 1.0, (count, RATIO * CHANNELS)).astype("<f4")
            out.write(np.concatenate([points.reshape(count, -1), samples], axis=1).tobytes())
        out.write(bytes(-out.tell() % 512))


def read(path):
    import ezc3d
    print(ezc3d.c3d(path)["data"]["points"].shape)


def measure(arguments):
    """Seconds of the clock and of the processor, and the most memory [MB] that a command takes."""
    start = time.monotonic()
    child = os.fork()
    if child == 0:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.execv(arguments[0], arguments)
    _, status, usage = os.wait4(child, 0)
    if status != 0:
        sys.exit(f"c3d_large.py: {' '.join(arguments)} failed with status {status}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def compare(sinew, path, trc):
    with open(path, "rb") as file:  # both then find it in memory
        while file.read(1 << 24):
            pass
    size = os.path.getsize(path)
    ours = measure([sinew, "convert", path, "--up", "keep", "--out", trc])
    theirs = measure([sys.executable, __file__, "read", path])
    print(f"| {size / 1e6:.0f} MB, {(size - 512) // FRAME} frames, {POINTS} points, "
          f"{CHANNELS} channels x {RATIO} | clock [s] | processor [s] | most memory [MB] |")
    print("|---|---:|---:|---:|")
    for name, row in (("`sinew convert` to TRC", ours), ("ezc3d reads it", theirs)):
        print(f"| {name} | {row[0]:.1f} | {row[1]:.1f} | {row[2]:.0f} |")
    print("| ratio | " + " | ".join(f"{b / a:.1f}" for a, b in zip(ours, theirs)) + " |")


if __name__ == "__main__":
    command = {"write": lambda path, size: write(path, int(size)), "read": read, "compare": compare}
    command[sys.argv[1]](*sys.argv[2:])
