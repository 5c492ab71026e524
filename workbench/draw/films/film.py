"""Choose the frames of a film, and write it: MP4, animated GIF or animated WebP files.

A film appears whole or not at all, with one exception. Ctrl-C finishes the frame that is being
drawn, and then the file, which holds the finished part. A second Ctrl-C ends at once, without a
file. Frames are drawn while the file is written, and none is kept in memory. The same frames give
the same bytes; MP4 too, with the same ffmpeg.
"""

from __future__ import annotations

import contextlib
import math
import signal
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import FrameType

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from workbench.draw.camera import Camera
from workbench.draw.marks.layout import TEXT_SIZE
from workbench.draw.scene import INK, PAPER, Scene, SceneBody
from workbench.errors import InputError, MissingPartError, UsageError, one_of
from workbench.files.output_file import staged
from workbench.model.arrays import Floats

__all__ = [
    "FILMS",
    "MAX_FRAMES",
    "Encoder",
    "every_pose",
    "film_frames",
    "frame_times",
    "has_encoder",
    "scene_at",
    "stamp_text",
    "write_film",
]

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


MAX_FRAMES = 36_000
"""Largest number of frames of a film: twenty minutes at 30 frames/s. More is a mistake in a unit."""
_ROUNDING_MARGIN = 1e-9
"""Share of a frame by which the last frame may be late."""


def frame_times(start: float, end: float, *, fps: float, speed: float = 1.0) -> Floats:
    """Return the time of the motion at each frame of a film.

    Parameters
    ----------
    start, end
        Time span [s] of the motion. The last frame is not after the end.
    fps
        Frames per second of the film.
    speed
        Seconds of the motion in a second of the film; 0.1 is ten times slow motion.

    Returns
    -------
    Floats
        (F,) times [s].

    Raises
    ------
    UsageError
        If rate or speed are out of range, or there would be more than `MAX_FRAMES`.
    """
    if not (math.isfinite(fps) and 0.1 <= fps <= 240.0):
        raise UsageError(f"film: 0.1 to 240 frames a second are possible, got {fps:g}")
    if not (math.isfinite(speed) and speed > 0.0):
        raise UsageError(
            f"film: a speed above 0 is needed (0.1 is ten times slow motion), got {speed:g}"
        )
    count = math.floor((end - start) * fps / speed + _ROUNDING_MARGIN) + 1
    if not 1 <= count <= MAX_FRAMES:
        raise UsageError(
            f"film: {end - start:g} s at {fps:g} frames/s and speed {speed:g} would be {count} frames; "
            f"1 to {MAX_FRAMES} are possible"
        )
    return start + np.arange(count, dtype=np.float64) * (speed / fps)


def scene_at(scene: Scene, frame: int, *, trail: int = 0, every: int = 1) -> Scene:
    """Return a scene with every body in one of its poses.

    Bodies with a single pose stay as they are. Ghosts of the scene move along.

    Parameters
    ----------
    scene
        Bodies in all their poses.
    frame
        Index of the pose.
    trail, every
        Number of ghosts of earlier poses, and the frames from one to the next.
    """
    moving = [shown for shown in scene.bodies if len(shown.placed) > 1]
    earlier = [frame - k * every for k in range(trail, 0, -1) if frame - k * every >= 0]
    trails = tuple(replace(shown, pose=pose) for pose in earlier for shown in moving)
    bodies = tuple(_in_pose(shown, frame) for shown in scene.bodies)
    ghosts = tuple(_in_pose(shown, frame) for shown in scene.ghosts)
    return replace(scene, bodies=bodies, ghosts=trails + ghosts)


def _in_pose(shown: SceneBody, frame: int) -> SceneBody:
    return replace(shown, pose=frame) if len(shown.placed) > 1 else shown


def every_pose(scene: Scene, *, most: int = 60) -> Scene:
    """Return a scene that holds every body in all its poses, for the camera of a film.

    Parameters
    ----------
    scene
        Bodies in all their poses.
    most
        Approximate largest number of poses; more are thinned out evenly.
    """
    bodies = []
    for shown in (*scene.bodies, *scene.ghosts):
        count = len(shown.placed)
        frames = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))
        bodies += [replace(shown, pose=int(k)) for k in frames] if count > 1 else [shown]
    return replace(scene, bodies=tuple(bodies), ghosts=())


_QUIET = "-y -hide_banner -loglevel error"
_INPUT = "-f rawvideo -pix_fmt rgb24"
_OUTPUT = (
    "-an -c:v libx264 -preset medium -crf 18 -pix_fmt yuv420p -threads 1 -fflags +bitexact "
    "-flags:v +bitexact -map_metadata -1 -movflags +faststart -f mp4"
)
"""H.264, which every browser and player shows. One thread and no stamp of the encoder's run: the
same frames give the same bytes."""


class Encoder:
    """An ffmpeg process that takes raw RGB frames; `close` finishes the file.

    The process has a session of its own, so that Ctrl-C in a terminal reaches this program only,
    which then closes the film.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: float) -> None:
        width, height = size
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        given = [*_INPUT.split(), "-s", f"{width}x{height}", "-r", f"{fps:.10g}", "-i", "-"]
        self._process = subprocess.Popen(
            [_ffmpeg(), *_QUIET.split(), *given, *_OUTPUT.split(), str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            start_new_session=True,
        )

    def write(self, frame: bytes) -> None:
        """Encode one frame.

        Raises
        ------
        InputError
            If ffmpeg has stopped, with its message.
        """
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(frame)
        except BrokenPipeError:
            raise InputError(f"MP4: {self._last_error()}") from None

    def close(self) -> None:
        """Finish the file.

        Raises
        ------
        InputError
            If ffmpeg fails, with its message.
        """
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        code = self._process.wait()
        message = self._last_error()
        self._errors.close()
        if code:
            raise InputError(f"MP4: {message}")

    def _last_error(self) -> str:
        self._errors.seek(0)
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        last = next((line for line in reversed(lines) if line.strip()), "no reason given")
        return f"ffmpeg stopped: {last}"


def has_encoder() -> bool:
    """Return whether MP4 films can be made here."""
    try:
        _ffmpeg()
    except MissingPartError:
        return False
    return True


def _ffmpeg() -> str:
    """Return the path of the ffmpeg program."""
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise MissingPartError(
            "MP4 films need imageio-ffmpeg: pip install 'bubbleman-workbench[film]' (.gif and .webp need nothing more)"
        ) from None
