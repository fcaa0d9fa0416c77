# SPDX-License-Identifier: Apache-2.0
"""A name stands for one class: two of one name in one program are one to the linker, which crashes far from here."""
import collections
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
UNNAMED = re.compile(r"namespace \{.*?\n\}  // namespace\n", re.DOTALL)
CLASS = re.compile(r"^(?:struct|class) (\w+)(?: final)?(?: : [^{;]*)?\s*\{", re.MULTILINE)


def classes(text):
    """Names of the classes of a file that other files can see."""
    return set(CLASS.findall(UNNAMED.sub("", text)))


def test_no_name_stands_for_two_classes():
    files = collections.defaultdict(set)
    for path in sorted(ROOT.glob("plant_sim/**/*.[hc]pp")):
        for name in classes(path.read_text()):
            files[name].add(str(path.relative_to(ROOT)))
    assert len(files) > 200
    twice = {name: sorted(where) for name, where in files.items() if len(where) > 1}
    assert not twice, twice


def test_what_counts_as_a_class():
    text = ("struct A {\n};\nclass B final : public A {\n};\nstruct C;\n"
            "namespace {\n\nstruct D {\n};\n\n}  // namespace\n")
    assert classes(text) == {"A", "B"}
