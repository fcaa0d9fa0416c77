# SPDX-License-Identifier: Apache-2.0
"""A recording on disk, unpacked on the way when gzip or zstd is around it."""
from __future__ import annotations

import io
import os
import shutil
import sys
import tempfile
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

from .errors import LogError, need

CHUNK = 1 << 20
GZIP, ZSTD = b"\x1f\x8b", b"\x28\xb5\x2f\xfd"
WRAPPERS = (".gz", ".gzip", ".zst", ".zstd")


class Unpacked(io.RawIOBase):
    """What is inside a gzip or zstd file, up to where it breaks off; `broken` then says where."""

    def __init__(self, path: Path, magic: bytes) -> None:
        self.broken: str | None = None
        self._file = path.open("rb")
        self._magic, self._kind = magic, "gzip" if magic == GZIP else "zstd"
        self._input, self._output = b"", memoryview(b"")
        self._object: Any = self._fresh()

    def _fresh(self) -> Any:
        return zlib.decompressobj(31) if self._magic == GZIP else need("zstandard").ZstdDecompressor().decompressobj()

    def readable(self) -> bool:
        return True

    def tell_packed(self) -> int:
        return self._file.tell()

    def _next(self) -> bytes:
        if self._object.eof:  # another one may follow
            self._input = self._object.unused_data or self._file.read(CHUNK)
            if not self._input.startswith(self._magic):
                return b""
            self._object = self._fresh()
        else:
            self._input = self._file.read(CHUNK)
            if not self._input:
                self.broken = f"its {self._kind} packing ends at byte {self._file.tell()} before its end mark"
        return bytes(self._object.decompress(self._input)) if self._input else b""

    def readinto(self, buffer: Any) -> int:
        while not self._output and not self.broken:
            try:
                self._output = memoryview(self._next())
            except Exception as error:  # zlib.error, or what zstandard calls the same
                self.broken = f"its {self._kind} packing is damaged before byte {self._file.tell()} ({error})"
            if not self._output and not self._input:
                break
        count = min(len(buffer), len(self._output))
        buffer[:count] = self._output[:count]
        self._output = self._output[count:]
        return count

    def close(self) -> None:
        self._file.close()
        super().close()


class Source:
    """One recording. Use as a context: what was unpacked beside it goes away with it."""

    def __init__(self, path: Path) -> None:
        if not path.exists():
            raise LogError(f"{path}: there is no such file")
        if path.is_dir():
            raise LogError(f"{path}: is a folder; name one of the recordings in it")
        self.path, self.size = path, path.stat().st_size
        with path.open("rb") as file:
            start = file.read(4)
        self._magic = next((magic for magic in (GZIP, ZSTD) if start.startswith(magic)), None)
        self._temporary: Path | None = None
        self._unpacked: Unpacked | None = None
        self._raw: BinaryIO | None = None
        self._cut: str | None = None
        self.last_line_ends = True

    def __enter__(self) -> Source:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, at: TracebackType | None) -> None:
        for opened in (self._unpacked, self._raw):
            if opened:
                opened.close()
        if self._temporary:
            shutil.rmtree(self._temporary, ignore_errors=True)

    @property
    def suffix(self) -> str:
        """Of the recording itself, without the packing."""
        path = Path(self.path.stem) if self._magic and self.path.suffix.lower() in WRAPPERS else self.path
        return path.suffix.lower()

    @property
    def broken(self) -> str | None:
        """Where the packing breaks off, once that place was reached."""
        return self._unpacked.broken if self._unpacked and self._unpacked.broken else self._cut

    def head(self, size: int = 8192) -> bytes:
        if not self._magic:
            with self.path.open("rb") as file:
                return file.read(size)
        with Unpacked(self.path, self._magic) as unpacked:
            return io.BufferedReader(unpacked).read(size)

    def stream(self) -> BinaryIO:
        if self._temporary:
            self._raw = self.file().open("rb")
            return self._raw
        if self._magic:
            self._unpacked = Unpacked(self.path, self._magic)
            return io.BufferedReader(self._unpacked, CHUNK)
        self._raw = self.path.open("rb", CHUNK)
        return self._raw

    def file(self) -> Path:
        """A plain file, for libraries that need to jump about in it."""
        if not self._magic:
            return self.path
        if not self._temporary:
            self._temporary = Path(tempfile.mkdtemp(prefix="voltlap-log-"))
            with (self._temporary / f"recording{self.suffix}").open("wb") as out, \
                    Unpacked(self.path, self._magic) as unpacked:
                shutil.copyfileobj(io.BufferedReader(unpacked), out, CHUNK)
                self._cut = unpacked.broken
        return self._temporary / f"recording{self.suffix}"

    def lines(self) -> Iterator[tuple[int, str]]:
        """Numbered lines without their ends."""
        for number, raw in enumerate(self.stream(), 1):
            self.last_line_ends = raw.endswith(b"\n")
            text = raw.decode("utf-8", "replace").rstrip("\r\n")
            yield number, text.lstrip("\ufeff") if number == 1 else text

    def part_read(self) -> float | None:
        """How much of the file has been taken, 0 to 1."""
        if not self.size:
            return None
        if self._unpacked and not self._unpacked.closed:
            return self._unpacked.tell_packed() / self.size
        return self._raw.tell() / self.size if self._raw and not self._raw.closed else None


class Progress:
    """A line on a terminal's stderr that is written over once a second; nothing elsewhere."""

    def __init__(self, what: str) -> None:
        self._what, self._last, self._shown = what, time.monotonic() + 1.0, False
        self._wanted = sys.stderr is not None and sys.stderr.isatty()

    def tell(self, text: str) -> None:
        if self._wanted and time.monotonic() - self._last >= 1.0:
            self._last, self._shown = time.monotonic(), True
            sys.stderr.write(f"\r\x1b[K{self._what}: {text}")
            sys.stderr.flush()

    def done(self) -> None:
        if self._shown:
            sys.stderr.write("\r\x1b[K")


class Replacing:
    """A file beside `path` that takes its place when all went well, and is gone otherwise."""

    def __init__(self, path: Path) -> None:
        if path.is_dir():
            raise LogError(f"{path}: is a folder; name a file to write")
        if not path.parent.is_dir():
            raise LogError(f"{path}: there is no folder {path.parent}; make it first")
        self._path = path
        self.beside = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")

    def __enter__(self) -> Path:
        return self.beside

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, at: TracebackType | None) -> None:
        if kind is None:
            os.replace(self.beside, self._path)
        else:
            self.beside.unlink(missing_ok=True)
