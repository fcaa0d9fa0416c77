# SPDX-License-Identifier: Apache-2.0
"""Decoded signals as MF4 by asammdf: one channel group a frame, with units, comments and value texts. Where a frame did
not carry a signal its sample is NaN and marked invalid."""
from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..candump import NS
from ..errors import need
from ..signal_folder import Column, Group, Signals
from ..source import Progress

if TYPE_CHECKING:
    from ..signal_folder import Doubles

COMPRESSED = 2  # deflate after transposition


def conversion(column: Column, values: Doubles) -> dict[str, Any] | None:
    """Value texts, when every value has one: a number among texts would no longer be a number."""
    np = need("numpy")
    if not column.choices or not np.isin(values[~np.isnan(values)], list(column.choices)).all():
        return None
    table: dict[str, Any] = {"default_addr": b""}
    for k, (value, text) in enumerate(sorted(column.choices.items())):
        table[f"val_{k}"], table[f"text_{k}"] = value, text.encode()
    return table


def comment(column: Column, texts_apart: bool) -> str:
    if not texts_apart:
        return column.comment
    texts = ", ".join(f"{value:g} {text}" for value, text in sorted(column.choices.items()))
    return f"{column.comment} ({texts})".strip()


def signal(column: Column, order: Any, times: Doubles) -> Any:
    np = need("numpy")
    values = np.asarray(column.values())[order]
    absent = np.isnan(values)
    texts = conversion(column, values)
    return need("asammdf").Signal(
        values, times, name=column.unique, unit=column.unit, conversion=texts,
        comment=comment(column, bool(column.choices) and texts is None),
        invalidation_bits=absent if absent.any() else None)


def append(mdf: Any, group: Group, shift_s: float) -> None:
    np = need("numpy")
    times = np.asarray(group.times()) + shift_s
    order = slice(None) if np.all(np.diff(times) >= 0) else np.argsort(times, kind="stable")
    columns = [signal(column, order, times[order]) for column in group.columns]
    if not columns:  # a frame without signals is still a time at which it came
        columns = [need("asammdf").Signal(np.ones(len(times)), times[order], name=f"{group.name}.received")]
    mdf.append(columns, acq_name=group.unique, comment=f"{group.unique}, identifier 0x{group.id & 0x1FFFFFFF:X}",
               common_timebase=True)


def write(path: Path, signals: Signals) -> None:
    asammdf = need("asammdf")
    progress = Progress(str(path.name))
    with asammdf.MDF(version="4.11") as mdf:
        origin_ns = max(round(signals.origin_s * NS), 0)  # MF4 has no start before 1970
        mdf.header.start_time = datetime.fromtimestamp(origin_ns // NS, timezone.utc)
        mdf.header.abs_time = origin_ns
        mdf.header.comment = f"Decoded from {signals.source}"
        for number, group in enumerate(signals.groups, 1):
            append(mdf, group, min(signals.origin_s, 0.0))
            progress.tell(f"{number} of {len(signals.groups)} groups")
        progress.tell("compressing")
        with path.open("wb+") as out:  # given a name, asammdf may write to another one
            mdf.save(out, compression=COMPRESSED)
    progress.done()
