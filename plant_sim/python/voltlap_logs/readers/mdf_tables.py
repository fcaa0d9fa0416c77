# SPDX-License-Identifier: Apache-2.0
"""The signals of an MDF file (2 to 4) by asammdf, a table for each channel group: physical values, value texts as their
numbers, invalid samples as nothing."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..errors import LogError, need
from ..source import Source
from ..table import Channel, Table, Tables
from .mf4 import opened

NUMERIC = "biuf"


def group_name(mdf: Any, number: int) -> str:
    group = mdf.groups[number].channel_group
    return str(getattr(group, "acq_name", "") or "").strip() or f"group {number}"


def members(mdf: Any, number: int) -> Iterator[tuple[int, Any]]:
    """Channels beside the time: no structures, whose parts are channels of their own."""
    master = mdf.masters_db.get(number)
    group = mdf.groups[number]
    dependencies = getattr(group, "channel_dependencies", None) or [None] * len(group.channels)
    for index, channel in enumerate(group.channels):
        if index != master and not (dependencies[index] and isinstance(dependencies[index][0], tuple)):
            yield index, channel


def values(mdf: Any, number: int, index: int) -> Any:
    np = need("numpy")
    raw = mdf.get(group=number, index=index, raw=True, ignore_invalidation_bits=True)
    samples, invalid = raw.physical(ignore_value2text_conversions=True).samples, raw.invalidation_bits
    if samples.dtype.kind in NUMERIC and samples.ndim == 1:
        if invalid is not None and len(invalid) and invalid.any():
            return np.where(invalid, np.nan, samples.astype(np.float64))
        return samples
    if samples.dtype.names or samples.ndim > 1 and samples.dtype != np.uint8:
        flat = np.ascontiguousarray(samples)
        return flat.view(np.uint8).reshape(len(samples), -1)
    return samples


def columns(mdf: Any, number: int, path: object) -> list[Any]:
    try:
        return [mdf.get_master(number), *(values(mdf, number, index) for index, _ in members(mdf, number))]
    except MemoryError:
        raise
    except Exception as error:  # asammdf raises whatever its parser ran into
        told = " ".join(str(error).split()) or type(error).__name__
        raise LogError(f"{path}: the values of {group_name(mdf, number)} cannot be read ({told}): the file is damaged "
                       "or was cut; copy it again") from error


def read(source: Source) -> tuple[Tables, Any]:
    """The tables and the opened file, which the caller closes."""
    mdf = opened(source.file())
    start = mdf.header.start_time
    tables = []
    for number, group in enumerate(mdf.groups):
        channels = [Channel("time_s")]
        channels += [Channel(channel.name, str(getattr(channel, "unit", "") or "") or unit_of(channel),
                             str(channel.comment or "")) for _, channel in members(mdf, number)]
        rows = int(group.channel_group.cycles_nr)
        tables.append(Table(group_name(mdf, number), rows, channels,
                            lambda number=number: columns(mdf, number, source.path)))  # type: ignore[misc]
    return Tables(f"MDF {mdf.version}", start.isoformat() if start else "", tables), mdf


def unit_of(channel: Any) -> str:
    return str(getattr(getattr(channel, "conversion", None), "unit", "") or "")
