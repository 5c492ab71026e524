"""Large batches on an NVIDIA card: the same compiled functions as on the processor, a thread a
pose.

Nothing here is imported from numba-cuda before a device is asked for.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.contact.kernels.field import Field
from workbench.contact.kernels.groups import Crowd
from workbench.contact.kernels.inside import Shells
from workbench.errors import MissingPartError, UsageError, one_of
from workbench.geometry.polygon import Faces
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.poses import Placed

if TYPE_CHECKING:
    from types import ModuleType

__all__ = [
    "Index",
    "Walk",
    "clearance_on_device",
    "collides_on_device",
    "on_cpu",
    "posed_collides_on_device",
]

Index = tuple[Crowd, Faces, Shells, Field]
Walk = tuple[Any, Any]
"""Chain and Skin."""
MEMORY = 2 << 30
"""Bytes of the device's memory for poses at a time; larger batches go in pieces."""
BLOCKS = 1024
"""Most blocks of threads at once: enough to fill any card, and working space for no more."""


def on_cpu(device: str) -> bool:
    """True for "cpu"; UsageError for a device there is no such thing as."""
    if device not in ("cpu", "cuda"):
        raise UsageError(f"device={device!r}: {one_of(device, ('cpu', 'cuda'))}")
    return device == "cpu"


def collides_on_device(placed: Placed, index: Index, allowed: Floats) -> Bools:
    """(P,) True where a sphere is deeper in a group of parts than allowed (N, G) [m]; as
    `grouped_collides`.

    MissingPartError where numba-cuda or a device is missing; so do all functions here.
    """
    gpu = _kernels()
    scene = gpu.to_device(index)
    limits = gpu.to_device(np.ascontiguousarray(allowed))
    hit = np.zeros(len(placed), dtype=np.bool_)
    for begin, end in _pieces(
        len(placed), placed.centres[:1].nbytes + placed.world_from_segment[:1].nbytes
    ):
        moved = gpu.to_device((placed.centres[begin:end], placed.world_from_segment[begin:end]))
        hit[begin:end] = _collided(gpu, (moved, scene, limits), allowed.size)
    return hit


def posed_collides_on_device(
    poses: tuple[Floats, Floats, int], walk: Walk, index: Index, allowed: Floats
) -> Bools:
    """As `collides_on_device`, forward kinematics on the device too: 0.8 kB a pose move there
    instead of 10 to 40 kB.

    poses: rotations (P, J, 4), the reference segment's transforms (P, 3, 4) and its number.
    """
    gpu = _kernels()
    rotations, root, reference = poses
    scene = gpu.to_device(index)
    limits = gpu.to_device(np.ascontiguousarray(allowed))
    steps = gpu.to_device(walk)
    segments = len(index[0].shown)
    spheres = len(index[0].radius)
    hit = np.zeros(len(rotations), dtype=np.bool_)
    for begin, end in _pieces(
        len(rotations), 8 * (12 * segments + 3 * spheres + 4 * rotations.shape[1])
    ):
        world = np.full((end - begin, segments, 3, 4), np.nan)
        world[:, reference] = root[begin:end]
        turned, frames = gpu.to_device((rotations[begin:end], world))
        centres = gpu.to_device(np.empty((end - begin, spheres, 3)))
        gpu.place_kernel[_blocks(gpu, end - begin), gpu.THREADS]((turned, centres, frames), steps)
        hit[begin:end] = _collided(gpu, ((centres, frames), scene, limits), allowed.size)
    return hit


def clearance_on_device(placed: Placed, index: Index) -> tuple[Floats, Ints, Ints]:
    """Signed distance [m], sphere and polygon (P, N, G) of every segment to every group; as
    `grouped_clearance`."""
    gpu = _kernels()
    scene = gpu.to_device(index)
    crowd = index[0]
    shape = (len(placed), len(placed.window), len(index[3].root))
    out = np.full(shape, np.inf), np.full(shape, -1), np.full(shape, -1)
    each = (
        placed.centres[:1].nbytes + placed.world_from_segment[:1].nbytes + 24 * shape[1] * shape[2]
    )
    for begin, end in _pieces(len(placed), each):
        moved = gpu.to_device((placed.centres[begin:end], placed.world_from_segment[begin:end]))
        answer = gpu.to_device(tuple(values[begin:end] for values in out))
        blocks = _blocks(gpu, end - begin)
        threads = blocks * gpu.THREADS
        space = gpu.to_device(
            (np.empty((len(crowd.middle), threads)), np.empty((len(crowd.member), threads)))
        )
        gpu.clearance_kernel[blocks, gpu.THREADS](moved, scene, answer, space)
        for values, found in zip(out, answer, strict=True):
            values[begin:end] = gpu.to_host(found)
    return out


def _collided(gpu: ModuleType, scene: tuple[Any, Any, Any], pairs: int) -> Bools:
    """Run the kernel on poses that lie on the device: (placed, index, allowed)."""
    placed, index, allowed = scene
    count = placed[0].shape[0]
    blocks = _blocks(gpu, count)
    room = (max(pairs, 1), blocks * gpu.THREADS)
    space = gpu.to_device((np.empty(room), np.empty(room, dtype=np.int64)))
    hit = gpu.to_device(np.zeros(count, dtype=np.bool_))
    gpu.collide_kernel[blocks, gpu.THREADS](placed, index, (allowed, hit), space)
    found: Bools = gpu.to_host(hit)
    return found


def _blocks(gpu: ModuleType, poses: int) -> int:
    return max(1, min(BLOCKS, -(-poses // int(gpu.THREADS))))


def _pieces(count: int, each: int) -> list[tuple[int, int]]:
    """(begin, end) of pieces of a batch of which every item takes `each` bytes."""
    size = max(1, MEMORY // max(each, 1))
    return [(begin, min(begin + size, count)) for begin in range(0, count, size)]


def _kernels() -> ModuleType:
    """The kernels for the device; MissingPartError says what to install."""
    if find_spec("numba_cuda") is None:
        raise MissingPartError(
            "device='cuda' needs the package numba-cuda, which is not installed: "
            "pip install 'bubbleman-workbench[gpu]', or leave device='cpu'"
        )
    from workbench.contact.kernels import gpu

    if not gpu.device_count():
        raise MissingPartError(
            "device='cuda' needs an NVIDIA card and its driver; numba-cuda is installed and finds none: "
            "leave device='cpu', or see `python -m numba -s`"
        )
    return gpu
