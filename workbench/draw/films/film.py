"""Films: pictures one after the other into an MP4, an animated GIF or an animated WebP file.

A film appears whole or not at all, with one exception: a stop by Ctrl-C keeps the finished part,
which plays: the frame that is being drawn is finished, then the file; a second Ctrl-C ends at once,
without one. Frames are drawn while the file is written; none is kept. The same frames give the same
bytes; MP4 too, with the same ffmpeg.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from workbench.draw.camera import Camera
from workbench.draw.colours import INK, PAPER
from workbench.draw.films.motion import scene_at
from workbench.draw.films.mp4 import Encoder
from workbench.draw.marks.layout import TEXT_SIZE
from workbench.draw.scene import Scene
from workbench.errors import UsageError, one_of
from workbench.files.output_file import staged
from workbench.model.arrays import Floats

__all__ = ["FILMS", "film_frames", "stamp_text", "write_film"]

FILMS = (".mp4", ".gif", ".webp")
_TICK = {".gif": 10, ".webp": 1}  # [ms] in which the file counts time
_FASTEST = {
    ".gif": 50.0,
    ".webp": 240.0,
    ".mp4": 240.0,
}  # frames/s; most programs slow down faster GIFs to 10

Progress = Callable[[int, int], None]
Painter = Callable[[Scene, Camera], Image.Image]


def film_frames(
    scene: Scene,
    camera: Camera,
    times: Floats,
    painter: Painter,
    *,
    stamp: str = "",
    trail: int = 0,
    every: int = 1,
) -> Iterator[Image.Image]:
    """The pictures of a moving scene: frame k shows every body in its pose k, with the time
    times[k] [s] burnt in.

    stamp: said after the time, such as the film's rate; trail, every: ghosts of earlier frames, see
    scene_at.
    """
    for frame, time in enumerate(times.tolist()):
        image = painter(scene_at(scene, frame, trail=trail, every=every), camera)
        yield stamp_text(image, f"{time:.3f} s{f'   {stamp}' if stamp else ''}")


def stamp_text(image: Image.Image, text: str) -> Image.Image:
    """The picture with a line of text in its upper left corner."""
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(TEXT_SIZE)
    draw.text((12, 10), text, fill=INK, font=font, anchor="la", stroke_width=2, stroke_fill=PAPER)
    return image


def write_film(
    path: Path,
    frames: Iterable[Image.Image],
    count: int,
    *,
    fps: float,
    progress: Progress | None = None,
) -> int:
    """Write `count` pictures of one size; the ending decides how: .mp4, .gif or .webp. Returns the
    number written.

    progress(done, count) is called after each. UsageError for another ending or a rate the file
    cannot hold; MissingPartError where MP4 lacks its encoder; InputError where the file cannot be
    written. KeyboardInterrupt is raised again once the finished frames are in the file; with none
    finished there is no file.
    """
    kind = path.suffix.lower()
    if kind not in FILMS:
        raise UsageError(f"{path}: a film is a .mp4, .gif or .webp file; {one_of(kind, FILMS)}")
    if not 0.1 <= fps <= _FASTEST[kind]:
        raise UsageError(
            f"{path}: a {kind} film shows 0.1 to {_FASTEST[kind]:g} frames a second, got {fps:g}"
        )
    reel = _Reel(frames, count, progress)
    with staged(path) as partial:
        with _stops_after_a_frame(reel):
            if kind == ".mp4":
                _write_mp4(partial, reel, fps)
            else:
                _write_animation(partial, kind, reel, fps)
        if not reel.done:
            raise reel.stopped or UsageError(f"{path}: a film needs at least one frame")
    if reel.stopped is not None:
        raise KeyboardInterrupt(
            f"{path}: stopped after {reel.done} of {count} frames, which it holds"
        ) from None
    return reel.done


class _Reel:
    """The frames as they are written: counted, told, and ended early by Ctrl-C."""

    def __init__(
        self, frames: Iterable[Image.Image], count: int, progress: Progress | None
    ) -> None:
        self.frames = frames
        self.count = count
        self.progress = progress
        self.done = 0
        self.stopped: KeyboardInterrupt | None = None
        self.asked = False

    def __iter__(self) -> Iterator[Image.Image]:
        try:
            for image in self.frames:
                yield image.convert("RGB")
                self.done += 1
                if self.progress is not None:
                    self.progress(self.done, self.count)
                if self.asked:
                    self.stopped = KeyboardInterrupt()
                    return
        except KeyboardInterrupt as stop:
            self.stopped = stop


@contextmanager
def _stops_after_a_frame(reel: _Reel) -> Iterator[None]:
    """Ctrl-C only asks the reel to end after its frame: an encoder that is interrupted leaves no
    file that plays.

    Only the main thread hears of Ctrl-C; in others nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def ask(number: int, frame: FrameType | None) -> None:
        if reel.asked:
            raise KeyboardInterrupt
        reel.asked = True

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before if before is not None else signal.default_int_handler)


def _write_mp4(path: Path, reel: _Reel, fps: float) -> None:
    frames = iter(reel)
    first = next(frames, None)
    if first is None:
        return
    size = (
        first.width + first.width % 2,
        first.height + first.height % 2,
    )  # the format wants even sizes
    encoder = Encoder(path, size, fps)
    try:
        encoder.write(_padded(first, size))
        for image in frames:
            encoder.write(_padded(image, size))
    except KeyboardInterrupt as stop:  # between frames or in the pipe: what came before is whole
        reel.stopped = stop
    finally:
        encoder.close()
    reel.done = max(reel.done, 1)


def _padded(image: Image.Image, size: tuple[int, int]) -> bytes:
    """RGB bytes, with a row or column of paper where the size is odd."""
    page = image
    if image.size != size:
        page = Image.new("RGB", size, PAPER)
        page.paste(image, (0, 0))
    return bytes(page.tobytes())


def _write_animation(path: Path, kind: str, reel: _Reel, fps: float) -> None:
    """GIF or WebP by Pillow. A frame is shown from its own time to the next one's, each in whole
    ticks of the file."""
    tick = _TICK[kind]
    edges = np.round(np.arange(reel.count + 1) * (1000.0 / fps / tick)).astype(np.int64) * tick
    shown = [int(step) for step in np.diff(edges)]
    frames = iter(reel)
    first = next(frames, None)
    if first is None:
        return
    if kind == ".gif":
        rest = (image.quantize(256, dither=Image.Dither.NONE) for image in frames)
        first = first.quantize(256, dither=Image.Dither.NONE)  # each frame its own 256 colours
        first.save(
            path, "GIF", save_all=True, append_images=rest, duration=shown, loop=0, optimize=False
        )
    else:
        first.save(
            path,
            "WEBP",
            save_all=True,
            append_images=frames,
            duration=shown,
            loop=0,
            quality=85,
            method=4,
        )
