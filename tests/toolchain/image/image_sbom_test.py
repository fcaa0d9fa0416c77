# SPDX-License-Identifier: Apache-2.0
"""What an image says it is made of: SPDX 2.3, with the hashes of the files that lie beside it."""
import hashlib
import json
import re

from image_tools import ROOT, tool


def document(image):
    return json.loads(image.with_suffix(".spdx.json").read_text())


def test_it_has_what_the_specification_demands(image_of):
    """SPDX 2.3, clauses 6, 7, 8 and 11: mandatory fields, forms of identifiers, relations between what is there."""
    bom = document(image_of("bms_node"))
    assert bom["spdxVersion"] == "SPDX-2.3" and bom["dataLicense"] == "CC0-1.0"
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", bom["creationInfo"]["created"])
    assert bom["documentNamespace"].startswith("https://") and "#" not in bom["documentNamespace"]
    ids = [part["SPDXID"] for part in [*bom["packages"], *bom["files"]]]
    assert len(ids) == len(set(ids))
    assert all(re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", name) for name in ids)
    for part in bom["packages"]:
        assert part["downloadLocation"] and part["licenseDeclared"] and part["versionInfo"]
    known = {*ids, "SPDXRef-DOCUMENT"}
    assert all({row["spdxElementId"], row["relatedSpdxElement"]} <= known for row in bom["relationships"])


def test_its_hashes_are_those_of_the_files(image_of):
    image = image_of("bms_node")
    files = {row["fileName"]: row["checksums"] for row in document(image)["files"]}
    assert set(files) == {"./bms_node.elf", "./bms_node.bin", "./bms_node.hex"}
    for name, sums in files.items():
        data = (image.parent / name).read_bytes()
        assert {row["algorithm"]: row["checksumValue"] for row in sums} == {
            "SHA1": hashlib.sha1(data).hexdigest(), "SHA256": hashlib.sha256(data).hexdigest()}


def test_it_names_compiler_libraries_and_licences(image_of):
    bom = document(image_of("both_nodes"))
    packages = {part["name"]: part for part in bom["packages"]}
    assert {"both_nodes", "compiler", "libgcc", "libvoltlap_fw_bms", "libvoltlap_fw_master"} <= packages.keys()
    assert packages["libgcc"]["licenseDeclared"] == "GPL-3.0-or-later WITH GCC-exception-3.1"
    assert packages["libvoltlap_fw_bms"]["licenseDeclared"] == "Apache-2.0"
    assert re.fullmatch(r"\d+\.\d+\.\d+", packages["compiler"]["versionInfo"])
    assert "-mcpu=cortex-m4" in packages["both_nodes"]["comment"]
    kinds = {row["relationshipType"] for row in bom["relationships"]}
    assert {"DESCRIBES", "BUILD_TOOL_OF", "STATIC_LINK", "CONTAINS"} <= kinds


def test_the_same_image_gives_the_same_file(image_of):
    image, texts = image_of("master_node"), []
    for _ in range(2):
        done = tool("image_sbom.py", "--version", "0.1.0", "--compiler", "arm-none-eabi-g++", "--flags=-O3",
                    "--root", ROOT, "--build", image.parents[1], image)
        assert done.returncode == 0, done.stderr
        texts.append(image.with_suffix(".spdx.json").read_text())
    assert texts[0] == texts[1]


def test_a_missing_image_is_said(tmp_path):
    (tmp_path / "x.map").write_text("")
    done = tool("image_sbom.py", "--version", "1", "--compiler", "arm-none-eabi-g++", "--root", ROOT,
                tmp_path / "x.elf")
    assert done.returncode != 0 and "x.elf" in done.stderr and "expected" in done.stderr
