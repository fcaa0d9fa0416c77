# SPDX-License-Identifier: Apache-2.0
"""Sources of the firmware by the paths that somebody names."""
import os
from pathlib import Path


def of_paths(paths, known, root, parser):
    """Those of `known` that are one of the paths or lie in one, in order; a path without any ends with usage."""
    found = set()
    for text in paths:
        path = Path(text) if Path(text).exists() else root / text
        name = os.path.relpath(path.resolve(), root)
        of_it = [source for source in known if source == name or source.startswith(name + "/")]
        if not of_it:
            parser.error(f"{text}: no source of firmware/ that is compiled for the host is there")
        found.update(of_it)
    return sorted(found)
