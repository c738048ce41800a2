#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""MISRA C:2012 on exported C99 pairs, by cppcheck's addon: each finding has a reason in misra_deviations.txt,
and each row there has a finding. Control: an `if` without braces.
  misra.py EXPORT_MODEL [EXAMPLE:SCALAR...]   without pairs: all that C99 supports
  misra.py EXPORT_MODEL --own PAIR:SCALAR     only one pair, which need not have every deviation
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

TABLE = pathlib.Path(__file__).with_name("misra_deviations.txt")


def rows():
    lines = [line for line in TABLE.read_text().splitlines() if line and not line.startswith("#")]
    return [(rule, re.compile(pattern)) for rule, pattern in (re.match(r"(\S+) \| (.*) \| ", line).groups() for line in lines)]


def findings(source):
    """Returns (rule, place, line) of each finding."""
    said = subprocess.run(["cppcheck", "--addon=misra", "--std=c99", "--quiet", "--template={id} {file}:{line}", "--force",
                           "-DDBL_MANT_DIG=53", source],  # a macro of <float.h>, which cppcheck does not know
                          cwd=source.parent, capture_output=True, text=True, check=True).stderr
    found = []
    for rule, file, line in re.findall(r"^misra-c2012-(\S+) (.+):(\d+)$", said, re.M):
        found.append((rule, f"{file}:{line}", pathlib.Path(source.parent, file).read_text().splitlines()[int(line) - 1]))
    if not found:  # each pair has deviations
        sys.exit(f"the addon found nothing in {source.name}: {said[:400]}")
    return found


def unexplained(source, table, used):
    left = []
    for rule, place, line in findings(source):
        mine = [row for row in table if row[0] == rule and row[1].search(line)]
        used.update(mine)
        if not mine:
            left.append(f"{place}: rule {rule}: {line.strip()[:120]}")
    return left


def main():
    export_model, *pairs = sys.argv[1:]
    own = pairs[:1] == ["--own"]
    pairs = pairs[own:]
    if not shutil.which("cppcheck"):
        print("SKIPPED: no cppcheck here")
        return 77
    few = pairs
    if not pairs:
        names = subprocess.run([export_model], capture_output=True, text=True, check=True).stdout.split()
        pairs = [f"{name}:{scalar}" for name in names for scalar in ("float", "double", "int16")]
    table, used, failed = rows(), set(), False
    with tempfile.TemporaryDirectory() as folder:
        for pair in pairs:
            example, scalar = pair.split(":")
            name = f"{example}_{scalar}"
            source = pathlib.Path(folder, name + ".c")
            written = subprocess.run([export_model, example, "c99", scalar, name, source.with_suffix(".h")],
                                     capture_output=True, text=True)
            if written.returncode and not few and re.search("target c99 writes|^int16 ", written.stderr):
                continue
            last = source
            left = unexplained(source, table, used) if not written.returncode else [written.stderr]
            print("\n".join([f"FAILED  {pair}", *left] if left else [f"ok      {pair}"]))
            failed |= bool(left)
        source = last
        text = source.read_text()
        altered = re.sub(r"if \((\w+)\) \{ return \w+; \}", r"if (\1) \1 = false;", text, count=1)
        source.write_text(altered)
        if altered == text or not any("rule 15.6" in line for line in unexplained(source, table, set())):
            print("FAILED  an if without braces was not detected")
            failed = True
    for row in table:
        if row not in used and not own:
            print(f"FAILED  no line deviates from {row[0]} any more: {row[1].pattern}")
            failed = True
    return failed


if __name__ == "__main__":
    sys.exit(main())
