#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that comments of C++ sources are at most 120 columns wide, and that none breaks a declaration in two.

usage: tests/properties/comments.py

clang-format does not wrap comments, and breaks a declaration whose trailing comment is too long for its line. Prints
each as FILE:LINE: WHAT. Generated files are left out, and so are raw strings (text that is generated) and addresses.
The exit code is 1 if there is one, or if the made-up faults of check_the_scan() are not found.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PARTS = ("runtime", "codegen", "trainer", "bindings", "tests", "bench", "examples")
WIDEST = 120

RAW_STRING = re.compile(r'R"(\w*)\((.*?)\)\1"', re.S)
STRING = re.compile(r'"(?:[^"\\\n]|\\.)*"')
# The last line of a declaration with a comment; how the line before ends when the declaration began there.
TRAILING = re.compile(r"^\s*[^/\s].*;\s+///?< ")
UNFINISHED = re.compile(r"[\w>=]\s*$")


def objections(text):
    """Yields (line number, what is wrong)."""
    bare = RAW_STRING.sub(lambda raw: "\n" * raw[0].count("\n"), text)
    before = ""
    for number, line in enumerate(bare.splitlines(), 1):
        code = STRING.sub('""', line)
        if "//" in code and len(line) > WIDEST and "://" not in line:
            yield number, f"a comment of {len(line)} columns, {WIDEST} at most"
        if TRAILING.match(code) and UNFINISHED.search(before) and not before.lstrip().startswith(("#", "template")):
            yield number, "a comment breaks its declaration in two: write it above"
        before = code.split("//")[0]


def check_the_scan():
    """Returns a made-up fault that the scan misses, or a valid text that it reports; None if there is none."""
    wide = "x" * WIDEST
    for bad in (f"// {wide}\n", f"int a;  ///< {wide}\n", "double a =\n    0.0;  ///< why\n",
                "std::string\n    a;  ///< why\n", "std::vector<int>\n    a;  ///< why\n"):
        if not list(objections(bad)):
            return f"not seen: {bad}"
    for good in (f"// https://{wide}\n", f'R"(\n// {wide}\n)";\n', "int a;  ///< why\n", "  int a,\n      b;  ///< why\n",
                 f'print("// {wide}");\n'):
        if found := list(objections(good)):
            return f"nothing is wrong with {good}: {found}"
    return ""


def main():
    if missed := check_the_scan():
        print(f"the scan has a fault: {missed}")
        return 1
    files = [file for part in PARTS for file in sorted((ROOT / part).rglob("*"))
             if file.suffix in (".h", ".cpp", ".inc") and "golden" not in file.parts]
    faults = [f"{file.relative_to(ROOT)}:{number}: {what}" for file in files for number, what in objections(file.read_text())]
    print("\n".join(faults) or f"{len(files)} sources")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
