#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What an image is made of, as SPDX 2.3 in JSON (https://spdx.github.io/spdx-spec/v2.3/): the image and its files with
their hashes, the firmware's libraries, libgcc, the compiler, each with version and licence.

usage: image_sbom.py --version V --compiler C++ --flags=FLAGS --root DIR IMAGE.elf

Reads IMAGE.map beside the image and writes IMAGE.spdx.json. Equal images give equal files: the time is that of the
commit, or SOURCE_DATE_EPOCH. Exit code: 0, 1 a file is missing, 2 usage.
"""
import argparse
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys

MEMBER = re.compile(r"^(\S+\.a)\(([^)]+)\)$", re.MULTILINE)
LICENCE, GCC_LICENCE = "Apache-2.0", "GPL-3.0-or-later WITH GCC-exception-3.1"
NAMESPACE = "https://spdx.org/spdxdocs/voltlap"


def output_of(*command, cwd=None):
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd)
    return done.stdout.strip() if done.returncode == 0 else ""


def digest(path, algorithm):
    return hashlib.new(algorithm, path.read_bytes()).hexdigest()


def checksums(path):
    return [{"algorithm": name.upper(), "checksumValue": digest(path, name)} for name in ("sha1", "sha256")]


def created(root):
    epoch = os.environ.get("SOURCE_DATE_EPOCH") or output_of("git", "log", "-1", "--format=%ct", cwd=root) or "0"
    return datetime.datetime.fromtimestamp(int(epoch), datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def revision(root):
    commit = output_of("git", "rev-parse", "HEAD", cwd=root)
    if not commit:
        return "NOASSERTION"
    changed = output_of("git", "status", "--porcelain", "--untracked-files=no", cwd=root)
    return commit + ("-changed" if changed else "")


def package(name, version, licence, purpose="LIBRARY", **more):
    return {"SPDXID": "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name), "name": name, "versionInfo": version,
            "downloadLocation": "NOASSERTION", "filesAnalyzed": False, "licenseConcluded": licence,
            "licenseDeclared": licence, "copyrightText": "NOASSERTION", "primaryPackagePurpose": purpose, **more}


def libraries(map_file):
    """{library: members}, from the linker's map."""
    found = {}
    for library, member in MEMBER.findall(map_file.read_text()):
        found.setdefault(pathlib.Path(library), set()).add(member)
    return found


def library_packages(image, given, compiler_version):
    packages = []
    for path, members in sorted(libraries(image.with_suffix(".map")).items()):
        own = path.name.startswith("libvoltlap_")
        at = path if path.is_absolute() else given.build / path
        more = {"comment": "objects in the image: " + ", ".join(sorted(members))}
        if at.is_file():
            more["checksums"] = checksums(at)
        packages.append(package(path.stem, given.version if own else compiler_version,
                                LICENCE if own else GCC_LICENCE, **more))
    return packages


def files_of(image):
    found = []
    for suffix in (".elf", ".bin", ".hex"):
        path = image.with_suffix(suffix)
        if not path.is_file():
            raise SystemExit(f"image_sbom.py: found no {path}; expected the image, linked and converted")
        found.append({"SPDXID": "SPDXRef-File" + suffix.replace(".", "-"), "fileName": "./" + path.name,
                      "checksums": checksums(path), "licenseConcluded": LICENCE, "copyrightText": "NOASSERTION",
                      "fileTypes": ["BINARY"] if suffix != ".hex" else ["TEXT"]})
    return found


def relation(from_id, kind, to_id):
    return {"spdxElementId": from_id, "relationshipType": kind, "relatedSpdxElement": to_id}


def document(given):
    image, files = given.image, files_of(given.image)
    compiler_version = output_of(given.compiler, "-dumpfullversion") or "NOASSERTION"
    first_line = output_of(given.compiler, "--version").splitlines()[:1]
    main = package(image.stem, given.version, LICENCE, "FIRMWARE",
                   comment=f"sources: {revision(given.root)}; flags: {given.flags}",
                   checksums=checksums(image.with_suffix(".bin")))
    compiler = package("compiler", compiler_version, GCC_LICENCE, "APPLICATION", comment="".join(first_line))
    parts = library_packages(image, given, compiler_version)
    relations = [relation("SPDXRef-DOCUMENT", "DESCRIBES", main["SPDXID"]),
                 relation(compiler["SPDXID"], "BUILD_TOOL_OF", main["SPDXID"])]
    relations += [relation(main["SPDXID"], "STATIC_LINK", part["SPDXID"]) for part in parts]
    relations += [relation(main["SPDXID"], "CONTAINS", file["SPDXID"]) for file in files]
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": image.stem,
            "documentNamespace": f"{NAMESPACE}/{image.stem}-{digest(image, 'sha256')}",
            "creationInfo": {"created": created(given.root), "creators": ["Tool: voltlap-image_sbom.py"]},
            "packages": [main, *parts, compiler], "files": files, "relationships": relations}


def main():
    parser = argparse.ArgumentParser(prog="image_sbom.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", required=True, help="of the project")
    parser.add_argument("--compiler", required=True, help="that made the image")
    parser.add_argument("--flags", default="", help="that it was given")
    parser.add_argument("--root", type=pathlib.Path, required=True, help="of the sources")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(), help="where the map's paths begin")
    parser.add_argument("image", type=pathlib.Path, metavar="IMAGE.elf")
    given = parser.parse_args()
    text = json.dumps(document(given), indent=1, ensure_ascii=False) + "\n"
    given.image.with_suffix(".spdx.json").write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
