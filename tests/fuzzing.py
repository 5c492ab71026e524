"""Damaged files for every reader: whole seeds, mutations of them by number, and a child process
that reads them.

A mutation is made from the reader's name and a number alone, so each can be made again:

    python -m tests.fuzzing READER FIRST COUNT

reads that many files, with the memory of the process and the time of each file bounded, and prints
what came out that is not one of the workbench's own errors.
"""

from __future__ import annotations

import io
import json
import random
import re
import shutil
import signal
import struct
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from tests import crash_pit
from tests.c3d_files import c3d_file
from tests.conftest import ONE_ARM, ROOT
from tests.one_arm_cab import ENVIRONMENT, PARTS, POSTURES, STUDY, boxes, write_cab
from workbench import WorkbenchError, load_body, read_ansur
from workbench.files.basis import load_basis
from workbench.files.kinds import check_file
from workbench.files.meshes.reading import read_mesh
from workbench.files.motions.reading import read_motion

__all__ = ["READERS", "Finding", "mutated", "search"]

MEMORY = 2 * 2**30
"""Bytes that the child process may take on top of what it has when everything is imported."""
LONGEST = 20.0
"""Seconds that one file may take."""
EXTREMES = (
    "-1",
    "0",
    "1e308",
    "-1e308",
    "nan",
    "inf",
    "1e-320",
    "4294967295",
    "2147483648",
    "9" * 25,
    "9" * 5000,
    "",
    "x",
    "0x10",
    "1_0",
    "\u00b2",
    "-0",
    "3.5",
)
WORDS = re.compile(rb"[A-Za-z_][\w.]*")
NUMBERS = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


class TooLongError(BaseException):
    """A file took longer than `LONGEST`; no reader may catch this."""


@dataclass(frozen=True)
class Reader:
    """A reader under attack: how its files end, whole files to start from, the call, and how they
    are opened up."""

    ending: str
    seeds: tuple[bytes, ...]
    read: Callable[[Path], object]
    unpack: Callable[[bytes, Callable[[bytes], bytes]], bytes] | None = None
    """Mutates what is packed inside a file, given the file and a mutation of bytes."""
    nightly: int = 4000
    """Mutations in a nightly run."""
    sample: int = 12
    """Mutations in the default tests."""
    place: str = "mesh"
    """File to write within the folder of a mutation, without its ending."""
    prepare: Callable[[Path], object] = field(default=lambda folder: None)
    """Writes what else must lie in the folder."""


@dataclass(frozen=True)
class Finding:
    """What a reader should not have done with a mutation: the last lines of a traceback, or how
    long it took."""

    reader: str
    number: int
    what: str


def mutated(data: bytes, chance: random.Random) -> bytes:
    """Damage some bytes once to four times: flipped, cut, doubled, dropped; words and numbers
    replaced."""
    changes: list[Callable[[bytes, random.Random], bytes]] = [
        _flipped,
        _cut,
        _doubled,
        _dropped,
        _new_number,
        _new_number,
        _new_word,
        _swapped_lines,
        _extreme_bytes,
    ]
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        if data:
            data = chance.choice(changes)(data, chance)
    return data


def _flipped(data: bytes, chance: random.Random) -> bytes:
    broken = bytearray(data)
    for _ in range(chance.choice((1, 1, 4, 16))):
        broken[chance.randrange(len(broken))] = chance.randrange(256)
    return bytes(broken)


def _cut(data: bytes, chance: random.Random) -> bytes:
    return data[: chance.randrange(len(data))]


def _doubled(data: bytes, chance: random.Random) -> bytes:
    start = chance.randrange(len(data))
    piece = data[start : start + chance.choice((1, 4, 64, 1000))]
    return data[:start] + piece * chance.choice((2, 3, 50)) + data[start + len(piece) :]


def _dropped(data: bytes, chance: random.Random) -> bytes:
    start = chance.randrange(len(data))
    return data[:start] + data[start + chance.choice((1, 2, 16, 200)) :]


def _replaced(
    data: bytes, pattern: re.Pattern[bytes], chance: random.Random, given: bytes
) -> bytes:
    found = list(pattern.finditer(data[:200_000]))
    if not found:
        return data
    match = chance.choice(found)
    return data[: match.start()] + given + data[match.end() :]


def _new_number(data: bytes, chance: random.Random) -> bytes:
    return _replaced(data, NUMBERS, chance, chance.choice(EXTREMES).encode())


def _new_word(data: bytes, chance: random.Random) -> bytes:
    found = WORDS.findall(data[:200_000])
    return _replaced(data, WORDS, chance, chance.choice(found)) if found else data


def _swapped_lines(data: bytes, chance: random.Random) -> bytes:
    lines = data.split(b"\n")
    k = chance.randrange(len(lines))
    n = chance.randrange(len(lines))
    lines[k], lines[n] = lines[n], lines[k]
    return b"\n".join(lines)


def _extreme_bytes(data: bytes, chance: random.Random) -> bytes:
    value = chance.choice(
        (
            b"\xff" * 4,
            b"\xff\xff\xff\x7f",
            b"\0" * 4,
            b"\0\0\0\x80",
            struct.pack("<f", np.nan),
            struct.pack("<f", 1e38),
            b"\xff\xff",
            b"\0\x80",
        )
    )
    at = chance.randrange(max(1, len(data) - len(value)))
    at -= at % len(value) if chance.random() < 0.7 else 0
    return data[:at] + value + data[at + len(value) :]


def mutation(reader: str, number: int) -> bytes:
    """The file of this number."""
    chance = random.Random(f"{reader} {number}")
    how = READERS[reader]
    data = chance.choice(how.seeds)
    if how.unpack is not None and chance.random() < 0.8:
        return how.unpack(data, lambda inside: mutated(inside, chance))
    return mutated(data, chance)


def search(reader: str, first: int, count: int) -> dict[str, Any]:
    """Read mutations first to first + count: how many were read and refused, the longest time, and
    the findings."""
    how = READERS[reader]
    findings: list[Finding] = []
    read = refused = 0
    longest = 0.0
    with tempfile.TemporaryDirectory() as name, warnings.catch_warnings():
        warnings.simplefilter("error")
        folder = Path(name)
        how.prepare(folder)
        path = folder / f"{how.place}{how.ending}"
        path.parent.mkdir(parents=True, exist_ok=True)
        for number in range(first, first + count):
            path.write_bytes(mutation(reader, number))
            start = time.perf_counter()
            signal.setitimer(signal.ITIMER_REAL, LONGEST)
            try:
                how.read(path)
                read += 1
            except WorkbenchError as error:
                refused += 1
                if any("\n" in line for line in getattr(error, "problems", ())) or not str(error):
                    findings.append(Finding(reader, number, f"a problem of several lines: {error}"))
            except TooLongError:
                findings.append(Finding(reader, number, f"longer than {LONGEST:g} s"))
            except Exception:  # noqa: BLE001 - this is what the search is for
                findings.append(
                    Finding(reader, number, "".join(traceback.format_exc().splitlines(True)[-6:]))
                )
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0)
            longest = max(longest, time.perf_counter() - start)
    return {
        "read": read,
        "refused": refused,
        "longest": longest,
        "findings": [vars(one) for one in findings],
    }


def _interrupt(_: int, __: FrameType | None) -> None:
    raise TooLongError


def _bound_memory() -> None:
    import resource

    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _in_glb(data: bytes, change: Callable[[bytes], bytes]) -> bytes:
    length = int.from_bytes(data[12:16], "little")
    text = change(data[20 : 20 + length])
    rest = data[20 + length :]
    text += b" " * (-len(text) % 4)
    return (
        data[:8]
        + struct.pack("<III", 20 + len(text) + len(rest), len(text), 0x4E4F534A)
        + text
        + rest
    )


def _in_zip(data: bytes, change: Callable[[bytes], bytes]) -> bytes:
    packed = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(data)) as old,
        zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as new,
    ):
        names = old.namelist()
        for k, name in enumerate(names):
            inside = old.read(name)
            new.writestr(name, change(inside) if k == len(names) - 1 else inside)
    return packed.getvalue()


def _meshes() -> dict[str, Reader]:
    import trimesh

    from tests.test_meshes import CORNERS, DOOR, dae, gltf, points_gltf, threemf

    box = trimesh.creation.box(extents=(2, 4, 6))
    scene = trimesh.Scene({"seat": box})
    ring = (
        "".join(f"v {np.cos(k)} {np.sin(k)} 0\n" for k in range(7))
        + "f 1 2 3 4 5 6 7\nf -1 -2 -3 -4\n"
    )
    node = '<node name="a"><scale>1 1 -1</scale><instance_node url="#door"/></node>'
    placed = dae(node).replace("<library_visual_scenes>", DOOR + "<library_visual_scenes>")
    nodes = [
        {
            "name": "seat",
            "mesh": 0,
            "rotation": [0, 0, 0, 1],
            "children": [1],
            "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}},
        },
        {"mesh": 0, "matrix": list(np.eye(4).ravel())},
    ]
    sparse = {
        "count": 1,
        "indices": {"bufferView": 1, "componentType": 5123},
        "values": {"bufferView": 2},
    }
    views = (np.array([1], dtype="<u2").tobytes(), np.array([7, 0, 0], dtype="<f4").tobytes())
    copies = points_gltf(
        CORNERS,
        5126,
        nodes=nodes,
        accessor={"sparse": sparse},
        views=views,
        scenes=[{"nodes": [0]}],
    )
    model = (
        '<object id="1" name="seat"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
        '<vertex x="0" y="1" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'
        '</object><object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 5"/>'
        '</components></object><build><item objectid="2"/></build>'
    )
    quads = box.export(file_type="ply")
    off = b"OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 2 1\n3 0 1 2\n5 0 1 2 3 4\n"
    return {
        "obj": Reader(".obj", (boxes(PARTS).encode(), ring.encode()), read_mesh),
        "stl": Reader(".stl", (box.export(file_type="stl_ascii").encode(),), read_mesh),
        "stl_binary": Reader(".stl", (box.export(file_type="stl"),), read_mesh),
        "ply": Reader(".ply", (_text_ply(),), read_mesh),
        "ply_binary": Reader(".ply", (quads,), read_mesh),
        "off": Reader(".off", (off, box.export(file_type="off").encode()), read_mesh),
        "gltf": Reader(
            ".gltf", (gltf().encode(), copies.encode()), read_mesh, nightly=8000, sample=30
        ),
        "glb": Reader(".glb", (scene.export(file_type="glb"),), read_mesh, _in_glb),
        "dae": Reader(
            ".dae",
            (
                dae(
                    node.replace("instance_node", "instance_geometry").replace("door", "tri")
                ).encode(),
                placed.encode(),
            ),
            read_mesh,
            nightly=6000,
        ),
        "3mf": Reader(
            ".3mf",
            (scene.export(file_type="3mf"), threemf(model)),
            read_mesh,
            _in_zip,
            nightly=6000,
        ),
    }


def _text_ply() -> bytes:
    head = b"ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    head += b"element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    return head + b"0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n3 1 4 2\n4 0 1 2 3\n"


def _motions() -> dict[str, Reader]:
    from tests.test_laban import SCORE
    from tests.test_motions import TWO

    angles = b"# body: one_arm\n# reference: BASE\ntime [s], x [mm], y [mm], z [mm], roll [deg], ELBOW.flexion [deg]\n"
    angles += b"0, 1, 2, 3, 4, 5\n0.1, 1, 2, 3, 4, 50\n0.2, 1, 2, 3, 4, 7\n"
    turns = (
        b"time [ms], x [m], qw, qx, qy, qz, SHOULDER.qw, SHOULDER.qx, SHOULDER.qy, SHOULDER.qz\n"
    )
    turns += b"0, 0.1, 1, 0, 0, 0, 1, 0, 0, 0\n10, 0.2, 1, 0, 0, 0, 0, 1, 0, 0\n"
    single = b"time [s], H.x [mm], H.y [mm], H.z [mm], H.roll [deg], H.pitch [deg], H.yaw [deg]\n"
    single += b"0, 100, 0, 1600, 0, 0, 90\n0.5, 101, 0, 1600, 0, 0, 80\n"
    trc = b"PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
    trc += b"60\t60\t2\t2\tmm\nFrame#\tTime\tLHEE\t\t\tRASI\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    trc += b"1\t0\t0\t1\t2\t3\t900\t5\n2\t0.1\t0\t1\t\t3\t900\t5\n"
    mot = b"a\nnRows=2\nnColumns=4\ninDegrees=yes\nendheader\ntime pelvis_tx hip_flexion_r knee_angle_r\n"
    mot += b"0 0.1 10 -20\n0.1 0.1 11 -22\n"
    sto = b"simm\ndatarows 2\ndatacolumns 3\nrange 0 1\nendheader\ntime arm_flex_r elbow_flex_r\n0 1 2\n0.5 3 4\n"
    points = tuple(c3d_file(processor=p, real=r) for p in (84, 85, 86) for r in (False, True))
    kinds = {
        "csv_angles": (".csv", (angles, turns)),
        "csv_segments": (".csv", (single,)),
        "bvh": (".bvh", (TWO.encode(),)),
        "trc": (".trc", (trc,)),
        "mot": (".mot", (mot,)),
        "sto": (".sto", (sto,)),
        "laban": (".laban", (SCORE.encode(),)),
        "c3d": (".c3d", points),
    }
    return {
        name: Reader(ending, seeds, _read_motion, sample=20)
        for name, (ending, seeds) in kinds.items()
    }


_body: list[Any] = []


def _read_motion(path: Path) -> object:
    if not _body:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "one_arm.yaml").write_text(ONE_ARM)
            _body.append(load_body(Path(folder) / "one_arm.yaml"))
    return list(read_motion(path, _body[0]))


def _write_pit(folder: Path) -> None:
    crash_pit.pit(folder)


def _copy_simulations(folder: Path) -> None:
    for kind in ("motions", "simulations"):
        shutil.copytree(ROOT / "studies" / kind, folder / "studies" / kind)


def _yaml() -> dict[str, Reader]:
    people = _population()
    growth = (ROOT / "bodies/populations/cdc_growth.yaml").read_bytes()
    worn = [(ROOT / f"bodies/encumbrance/{name}.yaml").read_bytes() for name in ("helmet", "boots")]
    body = ONE_ARM.replace("length: mm", "length: mm\npostures: arms.yaml", 1).encode()
    cab: dict[str, Any] = {"read": check_file, "prepare": write_cab}
    return {
        "body": Reader(".yaml", (body,), place="bodies/one_arm", **cab),
        "postures": Reader(".yaml", (POSTURES.encode(),), place="bodies/arms", nightly=3000, **cab),
        "environment": Reader(
            ".yaml", (ENVIRONMENT.encode(),), place="environments/cab/environment", **cab
        ),
        "study": Reader(".yaml", (STUDY.encode(),), place="studies/cab_study", nightly=3000, **cab),
        "population": Reader(".yaml", (people,), check_file, place="people"),
        "growth": Reader(".yaml", (growth,), check_file, place="growth", nightly=200, sample=1),
        "encumbrance": Reader(".yaml", tuple(worn), check_file, place="worn"),
        "simulation": Reader(
            ".yaml",
            (crash_pit.SIMULATION.encode(),),
            check_file,
            nightly=2000,
            sample=4,
            place="studies/simulations/pit_crash",
            prepare=_write_pit,
        ),
        "accommodation": Reader(
            ".yaml",
            ((ROOT / "studies/trainer_accommodation.yaml").read_bytes(),),
            check_file,
            place="studies/trainer",
            nightly=300,
            sample=1,
        ),
        "crash": Reader(
            ".yaml",
            ((ROOT / "studies/trainer_crash.yaml").read_bytes(),),
            check_file,
            place="studies/crash",
            nightly=300,
            sample=1,
            prepare=_copy_simulations,
        ),
    }


def _population() -> bytes:
    """A population of two measures: a file of the whole survey takes a hundred times as long to
    read."""
    rows = "stature: [1400, 1750, 2000]\n    mass: [40, 80, 140]"
    matrix = "stature: [1]\n    mass: [0.5, 1]"
    sexes = "".join(
        f"{sex}:\n  count: 100\n  quantiles:\n    {rows}\n  correlation:\n    {matrix}\n"
        for sex in ("male", "female")
    )
    return f"population: few\nlength: mm\npercentiles: [0, 50, 100]\n{sexes}".encode()


def _tables() -> dict[str, Reader]:
    rows = ["subjectid,Gender,stature,sittingheight,weightkg,Weight"]
    rows += [
        f"{k},{'Male' if k % 2 else 'Female'},{1700 + k},{900 + k},{700 + k},1" for k in range(12)
    ]
    arrays = (ROOT / "bodies/human_basis.npz").read_bytes()
    return {
        "ansur": Reader(".csv", ("\r\n".join(rows).encode(),), _read_ansur),
        "basis": Reader(".npz", (arrays,), load_basis, _in_zip, nightly=100, sample=1),
    }


def _read_ansur(path: Path) -> object:
    return read_ansur(path, measures=("stature", "sitting_height", "mass"), weights="Weight")


def _step() -> dict[str, Reader]:
    return {
        "step": Reader(
            ".step",
            (
                b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\n"
                b"ENDSEC;\nEND-ISO-10303-21;\n",
            ),
            read_mesh,
            nightly=40,
            sample=1,
        )
    }


READERS: dict[str, Reader] = _meshes() | _motions() | _yaml() | _tables() | _step()


if __name__ == "__main__":
    signal.signal(signal.SIGALRM, _interrupt)
    _bound_memory()
    sys.stdout.write(json.dumps(search(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))) + "\n")
