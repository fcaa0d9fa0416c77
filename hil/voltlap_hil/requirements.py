# SPDX-License-Identifier: Apache-2.0
"""The firmware's requirements: their text, and the time in which a reaction must be seen."""
from __future__ import annotations

import os
import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from .errors import InputError, did_you_mean

try:
    import tomllib
except ModuleNotFoundError:  # Python before 3.11
    import tomli as tomllib  # type: ignore[no-redef,import-not-found,unused-ignore]

ID = re.compile(r"(?:BMS|MST|DIA)-\d{3}")


@dataclass(frozen=True)
class Requirement:
    id: str
    text: str
    bound: str
    within_ms: float | None


@lru_cache
def requirements() -> dict[str, Requirement]:
    """$VOLTLAP_REQUIREMENTS, else firmware/requirements.toml of the project that this package stands in."""
    named = os.environ.get("VOLTLAP_REQUIREMENTS")
    path = Path(named) if named else Path(__file__).resolve().parents[2] / "firmware" / "requirements.toml"
    try:
        rows = tomllib.loads(path.read_text(encoding="utf-8"))["requirement"]
        return {row["id"]: Requirement(row["id"], row["text"], row["bound"], row.get("within_ms")) for row in rows}
    except OSError as error:
        reason = error.strerror
    except KeyError as error:
        reason = f"{error} is missing"
    except (ValueError, TypeError, AttributeError) as error:  # no UTF-8, no TOML, or tables of another shape
        reason = str(error)
    raise InputError(f"{path}: {reason}. Set VOLTLAP_REQUIREMENTS to the file of the requirements.")


def requirement(wanted: str) -> Requirement:
    known = requirements()
    if wanted not in known:
        raise InputError(f"found {wanted!r}, expected the id of a requirement.{did_you_mean(wanted, known)}")
    return known[wanted]


def bound_ms(wanted: str) -> float:
    found = requirement(wanted).within_ms
    if found is None:
        raise InputError(f"{wanted} states no time (within_ms); give a time such as '100 ms'")
    return found
