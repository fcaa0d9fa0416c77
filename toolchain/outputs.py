# SPDX-License-Identifier: Apache-2.0
"""Types of flags that name files to be written: what cannot be written is told before the work, not after it."""
import argparse
import json
import os
from pathlib import Path


def output_file(text):
    """A file that can be made, or written over."""
    path = Path(text)
    if not text or path.is_dir():
        raise argparse.ArgumentTypeError(f"{text or 'an empty name'}: cannot write: found a folder, expected a file")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"{text}: cannot write: found no folder {path.parent}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise argparse.ArgumentTypeError(f"{text}: cannot write: found no right to")
    return path


def write_json(path, value):
    """All of it or nothing."""
    beside = path.with_name(path.name + ".part")
    beside.write_text(json.dumps(value, indent=1) + "\n")
    beside.replace(path)


def output_folder(text):
    """A folder that is there and may be written to."""
    path = Path(text)
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f"{text or 'an empty name'}: found no such folder. Make it first")
    if not os.access(path, os.W_OK):
        raise argparse.ArgumentTypeError(f"{text}: cannot write: found no right to")
    return path


def marked_document(begin, end):
    """A document with two marks, between which a table is put."""
    def read(text):
        path = Path(text)
        if not path.is_file():
            raise argparse.ArgumentTypeError(f"{text or 'an empty name'}: found no such file; expected a document "
                                             f"with the marks {begin} and {end}")
        output_file(text)
        head, mark, rest = path.read_text(errors="replace").partition(begin)
        if not mark or end not in rest:
            raise argparse.ArgumentTypeError(f"{text}: found no {begin} and {end}; expected both around the table. "
                                             "Write them there")
        return path
    return read
