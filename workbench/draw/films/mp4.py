"""Encode MP4 films with ffmpeg, which comes with the package imageio-ffmpeg."""

from __future__ import annotations

import contextlib
import subprocess
import tempfile
from pathlib import Path

from workbench.errors import InputError, MissingPartError

__all__ = ["Encoder", "has_encoder"]

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
