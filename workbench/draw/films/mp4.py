"""MP4 by ffmpeg in a process of its own, which comes with the package imageio-ffmpeg."""

from __future__ import annotations

import contextlib
import subprocess
import tempfile
from pathlib import Path

from workbench.errors import InputError, MissingPartError

__all__ = ["Encoder"]


class Encoder:
    """Takes raw RGB frames and writes H.264, which every browser and player shows; `close` finishes
    the file.

    In a session of its own: Ctrl-C in a terminal reaches this program only, which then closes the
    film.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: float) -> None:
        width, height = size
        given = [
            "-f",
            "rawvideo",
            "-pix_fmt",
            "rgb24",
            "-s",
            f"{width}x{height}",
            "-r",
            f"{fps:.10g}",
            "-i",
            "-",
        ]
        # one thread and no stamp of the encoder's run: the same frames give the same bytes
        wanted = [
            "-an",
            "-c:v",
            "libx264",
            "-preset",
            "medium",
            "-crf",
            "18",
            "-pix_fmt",
            "yuv420p",
            "-threads",
            "1",
            "-fflags",
            "+bitexact",
            "-flags:v",
            "+bitexact",
            "-map_metadata",
            "-1",
            "-movflags",
            "+faststart",
            "-f",
            "mp4",
        ]
        self.said = tempfile.TemporaryFile()  # noqa: SIM115
        command = [
            _ffmpeg(),
            "-y",
            "-hide_banner",
            "-loglevel",
            "error",
            *given,
            *wanted,
            str(path),
        ]
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self.said,
            start_new_session=True,
        )

    def write(self, frame: bytes) -> None:
        """One frame. InputError with ffmpeg's words where it has given up."""
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(frame)
        except BrokenPipeError:
            raise InputError(f"MP4: {self._words()}") from None

    def close(self) -> None:
        """Finish the file. InputError with ffmpeg's words where that fails."""
        assert self.process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        code = self.process.wait()
        words = self._words()
        self.said.close()
        if code:
            raise InputError(f"MP4: {words}")

    def _words(self) -> str:
        self.said.seek(0)
        lines = self.said.read().decode("utf-8", "replace").split("\n")
        return "ffmpeg stopped: " + (
            next((line for line in reversed(lines) if line.strip()), "") or "no reason given"
        )


def _ffmpeg() -> str:
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise MissingPartError(
            "MP4 films need imageio-ffmpeg: pip install 'bubbleman-workbench[film]' (.gif and .webp need nothing more)"
        ) from None
