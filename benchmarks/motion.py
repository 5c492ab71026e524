"""What a motion costs: continuous contact, angles from markers, head injury criterion, reading,
beside baselines.

    python -m benchmarks.motion [C3D_FILE]

One table: CPU seconds of this process (all threads together), each line beside a baseline timed in
the same run.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import workbench as wb
from benchmarks.workload import cockpit, seated_poses
from workbench.files.motions.markers import read_c3d
from workbench.files.motions.number_rows import FrameRange
from workbench.files.motions.tables import angle_table_text, read_angle_table
from workbench.model.arrays import Floats
from workbench.model.joint_angles import poses_at
from workbench.motion.recorded.markers import bridged, poses_from_markers
from workbench.motion.signals import hic

FRAMES = 2752
RATE = 120.0
SAMPLES = 100_000


def cpu(work: Callable[[], object], *, rounds: int = 3) -> float:
    """The least CPU time [s] of some rounds after a first one that compiles and warms."""
    work()
    best = np.inf
    for _ in range(rounds):
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return float(best)


def row(what: str, seconds: float, figure: str, baseline: str, against: float) -> str:
    """A line of the table."""
    return f"| {what} | {seconds:.3f} | {figure} | {baseline} | {against / seconds:.1f} |"


def motion_of(body: wb.Body) -> wb.Poses:
    """FRAMES frames at RATE through some seated poses."""
    some = replace(seated_poses(body, 47), time=0.5 * np.arange(47.0))
    return poses_at(some, np.arange(FRAMES) / RATE)


def every_window(time_: Floats, level: Floats, window: float) -> float:
    """HIC by all pairs of samples, in plain loops over starts."""
    step = time_[1] - time_[0]
    total = np.concatenate([[0.0], np.cumsum(0.5 * (level[1:] + level[:-1])) * step])
    most = int(window / step + 1e-9)
    best = 0.0
    for first in range(len(total) - 1):
        last = min(first + most, len(total) - 1)
        width = step * np.arange(1, last - first + 1)
        best = max(
            best, float(np.max((total[first + 1 : last + 1] - total[first]) ** 2.5 / width**1.5))
        )
    return best


def table(c3d: Path | None) -> list[str]:
    """The lines of the table."""
    body = wb.load_body("bubbleman")
    environment = cockpit("50k")
    motion = motion_of(body)
    contact = cpu(lambda: wb.episodes(body, motion, environment))
    frames = cpu(
        lambda: [
            wb.clearance(wb.place(body, motion.rows(slice(k, k + 256))), environment)
            for k in range(0, FRAMES, 256)
        ],
        rounds=1,
    )
    lines = ["| what | CPU s | figure | baseline | times as long |", "|---|---|---|---|---|"]
    lines.append(
        row(
            f"continuous contact: {FRAMES} frames, {len(body.sphere_names)} spheres, 50k triangles",
            contact,
            f"{1000 * contact / FRAMES:.2f} ms a frame",
            "clearance at the frames alone",
            frames,
        )
    )
    at = np.arange(SAMPLES) / 20_000.0
    level = np.abs(np.random.default_rng(1).normal(0, 300, SAMPLES))
    for window in (0.015, 0.036):
        found = cpu(lambda w=window: hic(at, level, window=w))
        slow = cpu(lambda w=window: every_window(at, level / 9.80665, w), rounds=1)
        name = f"HIC{1000 * window:.0f} of {SAMPLES} samples at 20 kHz"
        lines.append(row(name, found, f"{1000 * found:.0f} ms", "a loop over starts", slow))
    if c3d is not None:
        markers = bridged(read_c3d(c3d, keep=FrameRange(every=2)), longest=0.2)
        solved = cpu(lambda: poses_from_markers(body, markers), rounds=1)
        opened = cpu(lambda: read_c3d(c3d), rounds=1)
        many = len(markers.time)
        lines.append(
            row(
                f"joint angles from {many} frames of {len(markers.names)} markers",
                solved,
                f"{many / solved:.0f} frames/s",
                "opening the C3D file",
                opened,
            )
        )
    lines.append(_reading(body, motion))
    return lines


def _reading(body: wb.Body, motion: wb.Poses) -> str:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "m.csv"
        path.write_text("".join(angle_table_text(body, motion)))
        read = cpu(lambda: read_angle_table(path, body), rounds=1)
        plain = cpu(lambda: np.loadtxt(path, delimiter=",", skiprows=4), rounds=1)
    return row(
        f"reading a table of {FRAMES} frames as poses",
        read,
        f"{FRAMES / read:.0f} frames/s",
        "numpy.loadtxt of its numbers",
        plain,
    )


if __name__ == "__main__":
    print("\n".join(table(Path(sys.argv[1]) if len(sys.argv) > 1 else None)))
