# SPDX-License-Identifier: Apache-2.0
"""Decoded signals as MCAP: one channel a frame, topic `/bus/frame`, protobuf messages whose fields are all doubles, in
the order of their times. Foxglove, Lichtblick and PlotJuggler open it. A signal that a frame did not carry is NaN.
Units and value texts stand in the channel's metadata."""
from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..candump import NS
from ..errors import need
from ..merge import by_time
from ..signal_folder import Group, Signals
from ..source import Progress

if TYPE_CHECKING:
    import numpy as np

BLOCK = 1 << 16
CHUNK_BYTES = 4 << 20
DOUBLE, WIRE_64 = 1, 1  # protobuf: type of a field, kind on the wire
PACKAGE = "voltlap"


def identifiers(names: Iterable[str]) -> list[str]:
    """Names that protobuf takes, each once."""
    taken, lower = list[str](), set[str]()
    for name in names:
        name = re.sub(r"\W", "_", name, flags=re.ASCII) or "_"
        name = f"_{name}" if name[0].isdigit() else name
        unique, number = name, 2
        while unique.lower() in lower:
            unique, number = f"{name}_{number}", number + 1
        taken.append(unique)
        lower.add(unique.lower())
    return taken


def field_numbers(count: int) -> list[int]:
    """19000 to 19999 are protobuf's own."""
    return [k + 1 if k + 1 < 19000 else k + 1001 for k in range(count)]


def schema(message: str, fields: list[str]) -> bytes:
    descriptors = need("google.protobuf.descriptor_pb2")
    file = descriptors.FileDescriptorProto(name=f"{message}.proto", package=PACKAGE, syntax="proto3")
    described = file.message_type.add(name=message)
    for name, number in zip(fields, field_numbers(len(fields)), strict=True):
        described.field.add(name=name, number=number, type=DOUBLE, label=1, json_name=name)
    return descriptors.FileDescriptorSet(file=[file]).SerializeToString()  # type: ignore[no-any-return]


def tag(number: int) -> bytes:
    """number << 3 | kind, as a varint."""
    value, out = number << 3 | WIRE_64, bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*out, value))


def messages(group: Group) -> np.ndarray[Any, Any]:
    """Each row encoded: all have one layout, tag and double by turns."""
    np = need("numpy")
    tags = [tag(number) for number in field_numbers(len(group.columns))]
    layout = [item for k, bytes_ in enumerate(tags) for item in ((f"t{k}", f"V{len(bytes_)}"), (f"v{k}", "<f8"))]
    rows = np.zeros(group.rows, dtype=np.dtype(layout))
    for k, (bytes_, column) in enumerate(zip(tags, group.columns, strict=True)):
        rows[f"t{k}"] = np.void(bytes_)
        rows[f"v{k}"] = column.values()
    return rows  # type: ignore[no-any-return]


def register(writer: Any, signals: Signals) -> list[int]:
    """The number of each group's channel."""
    channels = []
    named = identifiers(group.name for group in signals.groups)
    for group, message in zip(signals.groups, named, strict=True):
        fields = identifiers(column.name for column in group.columns)
        number = writer.register_schema(f"{PACKAGE}.{message}", "protobuf", schema(message, fields))
        about = {"bus": group.bus, "identifier": f"0x{group.id & 0x1FFFFFFF:X}"}
        for name, column in zip(fields, group.columns, strict=True):
            about |= {f"{name}.unit": column.unit} if column.unit else {}
            about |= {f"{name}.comment": column.comment} if column.comment else {}
            about |= {f"{name}.choices": json.dumps(column.choices)} if column.choices else {}
        topic = "/".join(("", *([group.bus] if group.bus else []), group.name))
        channels.append(writer.register_channel(topic, "protobuf", number, about))
    return channels


def write(path: Path, signals: Signals) -> None:
    mcap = need("mcap.writer")
    np = need("numpy")
    need("zstandard")
    times, owner, row = by_time(signals)
    origin_ns = round(signals.origin_s * NS)
    shift_ns = max(-(origin_ns + round(float(times[0]) * NS)), 0)  # MCAP has no time before 1970
    encoded = [messages(group) for group in signals.groups]
    views = [memoryview(rows.view(np.uint8)) if rows.dtype.itemsize else memoryview(b"") for rows in encoded]
    sizes = [rows.dtype.itemsize for rows in encoded]
    progress = Progress(str(path.name))
    with path.open("wb") as file:
        writer = mcap.Writer(file, chunk_size=CHUNK_BYTES)
        writer.start(profile="", library="voltlap")
        channels = register(writer, signals)
        writer.add_metadata("voltlap", {"source": signals.source, "origin_s": repr(signals.origin_s),
                                        "shifted_ns": str(shift_ns)})
        for begin in range(0, len(times), BLOCK):
            part = slice(begin, begin + BLOCK)
            stamps = (np.rint(times[part] * 1e9).astype(np.int64) + (origin_ns + shift_ns)).tolist()
            for time_ns, k, at in zip(stamps, owner[part].tolist(), row[part].tolist(), strict=True):
                size = sizes[k]
                writer.add_message(channels[k], time_ns, views[k][at * size:(at + 1) * size], time_ns, at)
            progress.tell(f"{100 * begin / len(times):.0f} %")
        writer.finish()
    progress.done()
