#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Skips tests whose programs and files are the same bytes as when they last passed. `rm -r build` forgets all results.

usage: tests/unchanged.py ctest BUILD [ARGUMENT...]    runs ctest in BUILD, without the unchanged tests
       tests/unchanged.py once BUILD NAME PROGRAM... -- COMMAND...
                                                       runs COMMAND, unless it passed with the same programs

A test depends on the files in its command, on the programs of the build that its program names, on the compilers and
emulators, and on the other files of the tree. The sources of codegen and of the trainer and *_test.cpp are not among
these files, because they are in the programs; only scripts compile others. Tests with the label `tree` read all
sources, so they always run.
"""
import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOOLS = ("g++", "gcc", "clang++", "clang", "cmake", "arm-none-eabi-g++", "aarch64-linux-gnu-g++", "riscv64-linux-gnu-g++", "avr-gcc", "simavr",
         "qemu-system-arm", "qemu-system-riscv64", "qemu-aarch64", "qemu-riscv64", "valgrind", "gnuplot", "frama-c", "cppcheck",
         "gappa", "llvm-mca-14", "llvm-mca-19")
IN_PROGRAMS = re.compile(r"(codegen|trainer)/.*\.(cpp|h)$|tests/.*(_test\.cpp|CMakeLists\.txt)$")
NOT_READ = re.compile(r"(build|out|runs|\.git)$")


def left_out(name):
    return IN_PROGRAMS.match(name) or name.endswith((".svg", ".pyc"))


def digest(*parts):
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


class Files:
    """Digests of the contents of files. Reads each file once."""
    def __init__(self):
        self.digests = {}

    def __call__(self, path):
        path = str(path)
        if path not in self.digests:
            self.digests[path] = hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()
        return self.digests[path]


def surroundings(of):
    """Digest of the files that any test may read or start."""
    parts = []
    for folder in (ROOT, ROOT.parent / "shared/data"):
        for top in sorted(folder.iterdir()) if folder.is_dir() else ():
            for file in [top, *sorted(top.rglob("*"))] if not NOT_READ.match(top.name) else ():
                name = file.relative_to(folder).as_posix()
                if file.is_file() and not (folder == ROOT and left_out(name)):
                    parts += [name, of(file)]
    for tool in TOOLS:
        place = shutil.which(tool)
        if place:
            real = pathlib.Path(place).resolve()
            parts += [tool, str(real), str(real.stat().st_size)]
    return digest(*parts)


def run_ctest(build, arguments):
    of = Files()
    around = surroundings(of)
    tests = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1", *arguments],
                                      check=True, capture_output=True, text=True).stdout)["tests"]
    programs = [p for p in (build / "trainer/nlo", build / "trainer/nlo-prove", build / "trainer/nlo-reproduce",
                            build / "bench/compare") if p.exists()]
    named = {}  # program of a test: digests of the programs of the build that it names, because it may start them

    def key(test):
        labels = next((p["value"] for p in test["properties"] if p["name"] == "LABELS"), [])
        if "tree" in labels or "command" not in test:
            return None
        parts = [around, *test["command"], json.dumps(test["properties"], sort_keys=True)]
        for word in test["command"]:
            if word.startswith("/") and pathlib.Path(word).is_file() and pathlib.Path(word).is_relative_to(ROOT):
                parts.append(of(word))
                if word not in named:
                    content = pathlib.Path(word).read_bytes()
                    named[word] = [of(p) for p in programs if str(p).encode() in content]
                parts += named[word]
            elif pathlib.Path(word) == build:
                parts += [of(p) for p in programs]
        return digest(*parts)

    stamp = build / "passed.json"
    passed = json.loads(stamp.read_text()) if stamp.exists() else {}
    chosen = [i for i, test in enumerate(tests, 1)
              if (now := key(test)) is None or passed.get(test["name"]) != now]
    print(f"{len(tests)} suites and scripts: {len(tests) - len(chosen)} are unchanged since they passed", flush=True)
    if not chosen:
        return 0
    results = build / "Testing/results.xml"
    results.unlink(missing_ok=True)
    code = subprocess.run(["ctest", "--test-dir", build, "--output-on-failure", "--output-junit", results,
                           "-I", ",".join(map(str, [0, 0, 0, *chosen])), *arguments]).returncode
    if results.exists():
        by_name = {test["name"]: test for test in tests}
        for case in xml.etree.ElementTree.parse(results).iter("testcase"):
            passed.pop(case.get("name"), None)
            # An earlier test may have made the input of this one, so the key is computed now.
            if case.get("status") == "run" and (now := key(by_name[case.get("name")])) is not None:
                passed[case.get("name")] = now
        stamp.write_text(json.dumps(passed, indent=0, sort_keys=True))
    return code


def run_once(build, name, programs, command):
    of = Files()
    now = digest(surroundings(of), *command, *map(of, programs))
    stamp = build / f"{name}.passed"
    if stamp.exists() and stamp.read_text() == now:
        print("   its programs are unchanged since it passed")
        return 0
    stamp.unlink(missing_ok=True)
    code = subprocess.run(command).returncode
    if code == 0:
        stamp.write_text(now)
    return code


def main():
    if len(sys.argv) >= 3 and sys.argv[1] == "ctest":
        return run_ctest(pathlib.Path(sys.argv[2]).resolve(), sys.argv[3:])
    if "--" in sys.argv and sys.argv[1] == "once":
        end = sys.argv.index("--")
        return run_once(pathlib.Path(sys.argv[2]).resolve(), sys.argv[3], sys.argv[4:end], sys.argv[end + 1:])
    sys.exit(__doc__)


if __name__ == "__main__":
    sys.exit(main())
