"""Write films: MP4, animated GIF or animated WebP files.

A film appears whole or not at all, with one exception. Ctrl-C finishes the frame that is being
drawn, and then the file, which holds the finished part. A second Ctrl-C ends at once, without a
file. Frames are drawn while the file is written, and none is kept in memory. The same frames give
the same bytes; MP4 too, with the same ffmpeg.
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
"""Endings of films."""
_TICK = {".gif": 10, ".webp": 1}
"""Unit [ms] in which a file counts time."""
_MIN_RATE = 0.1
_MAX_RATE = {".gif": 50.0, ".webp": 240.0, ".mp4": 240.0}
"""Frames per second. Most programs slow down faster GIFs to 10."""

Progress = Callable[[int, int], None]
"""Called with the number of frames that are done, and of all."""
Painter = Callable[[Scene, Camera], Image.Image]
"""Draws a scene."""


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
    """Draw the frames of a moving scene: frame k shows every body in its pose k.

    Parameters
    ----------
    scene, camera
        Bodies in F poses each, and the camera.
    times
        (F,) times [s], which are written into the frames.
    painter
        Draws each frame.
    stamp
        Text after the time, such as the rate of the film.
    trail, every
        Ghosts of earlier frames, see `scene_at`.
    """
    for frame, time in enumerate(times.tolist()):
        image = painter(scene_at(scene, frame, trail=trail, every=every), camera)
        yield stamp_text(image, f"{time:.3f} s{f'   {stamp}' if stamp else ''}")


def stamp_text(image: Image.Image, text: str) -> Image.Image:
    """Write a line of text into the upper left corner of a picture, and return it."""
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
    """Write pictures of one size into a film.

    Parameters
    ----------
    path
        The file; its ending decides the format.
    frames, count
        The pictures and their number.
    fps
        Frames per second.
    progress
        Called after each frame.

    Returns
    -------
    int
        Number of frames written.

    Raises
    ------
    UsageError
        If the ending is another, the format cannot hold the rate, or there is no frame.
    MissingPartError
        If the encoder of MP4 is not installed.
    InputError
        If the file cannot be written.
    KeyboardInterrupt
        After Ctrl-C, once the finished frames are in the file.
    """
    ending = path.suffix.lower()
    _check_format(path, ending, fps)
    reel = _Reel(frames, count, progress)
    with staged(path) as partial:
        with _finish_frame_on_interrupt(reel):
            if ending == ".mp4":
                _write_mp4(partial, reel, fps)
            else:
                _write_animation(partial, ending, reel, fps)
        if not reel.done:
            raise reel.stopped or UsageError(f"{path}: a film needs at least one frame")
    if reel.stopped is not None:
        raise KeyboardInterrupt(
            f"{path}: stopped after {reel.done} of {count} frames, which it holds"
        ) from None
    return reel.done


def _check_format(path: Path, ending: str, fps: float) -> None:
    if ending not in FILMS:
        raise UsageError(f"{path}: a film is a .mp4, .gif or .webp file; {one_of(ending, FILMS)}")
    if not _MIN_RATE <= fps <= _MAX_RATE[ending]:
        raise UsageError(
            f"{path}: a {ending} film shows {_MIN_RATE:g} to {_MAX_RATE[ending]:g} frames a second, "
            f"got {fps:g}"
        )


class _Reel:
    """The frames as they are written: counted, reported, and ended early by Ctrl-C."""

    def __init__(
        self, frames: Iterable[Image.Image], count: int, progress: Progress | None
    ) -> None:
        self.frames = frames
        self.count = count
        self.progress = progress
        self.done = 0
        self.stopped: KeyboardInterrupt | None = None
        self.stop_requested = False

    def __iter__(self) -> Iterator[Image.Image]:
        try:
            for image in self.frames:
                yield image.convert("RGB")
                self.done += 1
                if self.progress is not None:
                    self.progress(self.done, self.count)
                if self.stop_requested:
                    self.stopped = KeyboardInterrupt()
                    return
        except KeyboardInterrupt as stop:
            self.stopped = stop


@contextmanager
def _finish_frame_on_interrupt(reel: _Reel) -> Iterator[None]:
    """Let the first Ctrl-C end the reel after its frame.

    An encoder that is interrupted would leave a broken file. Only the main thread receives Ctrl-C;
    in others nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def request_stop(number: int, frame: FrameType | None) -> None:
        if reel.stop_requested:
            raise KeyboardInterrupt
        reel.stop_requested = True

    before = signal.signal(signal.SIGINT, request_stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before if before is not None else signal.default_int_handler)


def _write_mp4(path: Path, reel: _Reel, fps: float) -> None:
    frames = iter(reel)
    first = next(frames, None)
    if first is None:
        return
    # the format needs even sizes
    size = (first.width + first.width % 2, first.height + first.height % 2)
    encoder = Encoder(path, size, fps)
    try:
        encoder.write(_padded(first, size))
        for image in frames:
            encoder.write(_padded(image, size))
    except KeyboardInterrupt as stop:  # the frames before are complete
        reel.stopped = stop
    finally:
        encoder.close()
    reel.done = max(reel.done, 1)


def _padded(image: Image.Image, size: tuple[int, int]) -> bytes:
    """Return RGB bytes, with a row or column of paper added to an odd size."""
    page = image
    if image.size != size:
        page = Image.new("RGB", size, PAPER)
        page.paste(image, (0, 0))
    return bytes(page.tobytes())


def _write_animation(path: Path, ending: str, reel: _Reel, fps: float) -> None:
    """Write a GIF or WebP with Pillow.

    A frame is shown from its own time to the next one's, both rounded to ticks of the file.
    """
    tick = _TICK[ending]
    edges = np.round(np.arange(reel.count + 1) * (1000.0 / fps / tick)).astype(np.int64) * tick
    durations = np.diff(edges).tolist()
    frames = iter(reel)
    first = next(frames, None)
    if first is None:
        return
    if ending == ".gif":
        rest = (image.quantize(256, dither=Image.Dither.NONE) for image in frames)
        first = first.quantize(256, dither=Image.Dither.NONE)  # each frame its own 256 colours
        first.save(
            path,
            "GIF",
            save_all=True,
            append_images=rest,
            duration=durations,
            loop=0,
            optimize=False,
        )
    else:
        first.save(
            path,
            "WEBP",
            save_all=True,
            append_images=frames,
            duration=durations,
            loop=0,
            quality=85,
            method=4,
        )
