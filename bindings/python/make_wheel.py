#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes a wheel of the package nlo, which contains libnlo-model and the program of a build: pip install nlo-*.whl.

usage: make_wheel.py BUILD_DIR [-o DIR]

The wheel is for this system and every Python from 3.9 on. If it must run on other processors, build with -DNLO_NATIVE=OFF.
"""
import argparse
import base64
import hashlib
import pathlib
import platform
import re
import subprocess
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUNDLED = re.compile(r"lib(fmt|muparser)\.so\.\d+")  # libraries that the program needs beside those of C and C++


def needed_libraries(program):
    """Returns the paths of the libraries in BUNDLED to which the program is linked."""
    lines = subprocess.run(["ldd", str(program)], check=True, capture_output=True, text=True).stdout.splitlines()
    return [pathlib.Path(words[2]) for words in map(str.split, lines) if len(words) > 2 and BUNDLED.fullmatch(words[0])]


def contents(build):
    """Yields (path in the wheel, file, True if it is a program)."""
    for file in sorted((HERE / "nlo").iterdir()):
        if file.suffix == ".py" or file.name == "py.typed":
            yield f"nlo/{file.name}", file, False
    program = build / "trainer/nlo"
    library = (build / "bindings/c/libnlo-model.so").resolve()
    abi = re.search(r"\.so\.(\d+)", library.name)[1]
    yield f"nlo/lib/libnlo-model.so.{abi}", library, False
    for file in needed_libraries(program):
        yield f"nlo/lib/{file.name}", file.resolve(), False
    yield "nlo/bin/nlo", program, True


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("build", type=pathlib.Path, metavar="BUILD_DIR")
    arguments.add_argument("-o", "--output", type=pathlib.Path, metavar="DIR", default=pathlib.Path("."))
    given = arguments.parse_args()
    version = re.search(r"^project\(nlo VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]
    tag = f"py3-none-linux_{platform.machine()}"
    info = f"nlo-{version}.dist-info"
    texts = {
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: nlo\nVersion: {version}\nSummary: Learned state observers for "
                            "control loops\nLicense: MIT\nRequires-Python: >=3.9\nRequires-Dist: numpy>=1.21\n"
                            "Description-Content-Type: text/markdown\n\n" + (HERE / "README.md").read_text(),
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: nlo\nRoot-Is-Purelib: false\nTag: {tag}\n",
        f"{info}/entry_points.txt": "[console_scripts]\nnlo = nlo.program:command_line\n",
        f"{info}/LICENSE": (ROOT / "LICENSE").read_text(),
    }
    given.output.mkdir(parents=True, exist_ok=True)
    path = given.output / f"nlo-{version}-{tag}.whl"
    record = []
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        def add(name, data, mode):
            entry = zipfile.ZipInfo(name)  # its date is 1980, so that the same build gives the same bytes
            entry.external_attr, entry.compress_type = (0o100000 | mode) << 16, zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(data)}")

        for name, file, program in contents(given.build):
            add(name, file.read_bytes(), 0o755 if program else 0o644)
        for name, text in texts.items():
            add(name, text.encode(), 0o644)
        add(f"{info}/RECORD", "\n".join([*record, f"{info}/RECORD,,\n"]).encode(), 0o644)
    if "NLO_NATIVE:BOOL=ON" in (given.build / "CMakeCache.txt").read_text():
        print("note: for this machine's processor; a build with -DNLO_NATIVE=OFF is for any", file=sys.stderr)
    print(path)


if __name__ == "__main__":
    main()
