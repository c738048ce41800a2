#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the tables of docs/performance.md from counts and ratios in other files of the project.

usage: bench/performance.py [--check]
  --check  writes nothing; exits with 1 if the page differs from the counts
Each figure comes from a file that has its own test: bench/port_models/counted.json (cycles by models of ports),
docs/appendix/embedded_counts.md and bench/embedded/README.md (instructions on emulated boards),
bench/results (ratios that were timed).
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/performance.md"

# Structure, its name in counted.json, its names in the pages of counts (float, deterministic, int16); None: an empty cell.
ROWS = [
    ("KKL, 3-50x4-2 relu", "relu_50x4", ("float relu", "deterministic relu", "int16 relu")),
    ("KKL, 3-50x4-2 tanh", "tanh_50x4", ("float tanh", "deterministic tanh", "int16 tanh")),
    ("gated, 32 units", "gated_32", ("gated float", "gated deterministic", "gated int16")),
    ("GRU of EdgeMark", None, ("gru float", "gru deterministic", "gru int16")),
    ("prior, 24 units", None, ("prior float", "prior deterministic", None)),
    ("filter, 4 states", None, ("filter float", "filter deterministic", None)),
    ("carried vectors", None, ("carried float", "carried deterministic", None)),
    ("Luenberger, 2-50-2", None, ("luenberger float", "luenberger deterministic", None)),
    ("driven KKL, 3-32x2-2", None, ("driven float", "driven deterministic", None)),
    ("general, 4-50-3", None, ("general float", "general deterministic", "general int16")),
]
DESKTOP = [("Zen 4", "znver4"), ("Sapphire Rapids", "sapphirerapids"), ("Neoverse N1", "neoverse-n1"),
           ("Cortex-A72", "cortex-a72")]
EMBEDDED = [("M4F", "M4F"), ("M0+", "M0, M0+")]
NUMBERS = ("float", "deterministic", "int16")
NOT_MODELLED, NO_INT16, NOT_TIMED = "- a", "- b", "- c"


def table_rows(file):
    """Returns the cells of every row of a page's tables."""
    lines = (ROOT / file).read_text().splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]


def performance():
    cores = json.loads((ROOT / "bench/port_models/counted.json").read_text())["cores"]
    counts = {(r[0], r[1]): f"{int(r[2]):,}" for page in ("docs/appendix/embedded_counts.md", "bench/embedded/README.md")
              for r in table_rows(page) if len(r) == 7 and r[2].isdigit()}
    head = ["structure", *(name for name, _ in DESKTOP), *(f"{name} {n}" for name, _ in EMBEDDED for n in NUMBERS)]
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for structure, port, names in ROWS:
        cells = [f"{cores[core][port]['cycles']:,}" if port else NOT_MODELLED for _, core in DESKTOP]
        cells += [counts[core, name] if name else NO_INT16 for _, core in EMBEDDED for name in names]
        lines.append(f"| {structure} | {' | '.join(cells)} |")
    return lines


SHOWN = ("best Eigen / nlo", "multiply-add peak", "machine's limit / ours", "one thread / two threads", "gated units, 32-32-2")
LEFT_OUT = ("within", "weights", "estimate")  # coarser tanh, narrow weights, estimates with their error


def machines():
    results = [json.loads(file.read_text()) for file in sorted((ROOT / "bench/results").glob("*.json"))]
    ratios = {}
    for i, result in enumerate(results):
        for bench in ("step_latency", "training_epoch"):
            for name, ratio in result["benches"].get(bench, {}).get("ratios", {}).items():
                if any(part in name for part in SHOWN) and not any(part in name for part in LEFT_OUT):
                    ratios.setdefault(name, [NOT_TIMED] * len(results))[i] = f"{ratio['median']:.2f}"
    lines = [f"| ratio | {' | '.join(result['machine']['cpu'] for result in results)} |", "|---" * (1 + len(results)) + "|"]
    return lines + [f"| {name} | {' | '.join(cells)} |" for name, cells in ratios.items()]


def filled(text, name, lines):
    start, end = f"<!-- {name} -->\n", f"\n<!-- end of {name} -->"
    head, rest = text.split(start)
    return head + start + "\n" + "\n".join(lines) + "\n" + end + rest.split(end)[1]


def main():
    text = PAGE.read_text()
    now = filled(filled(text, "performance", performance()), "machines", machines())
    if "--check" in sys.argv[1:]:
        if now != text:
            print("docs/performance.md does not agree with the counts: run bench/performance.py")
        return now != text
    PAGE.write_text(now)
    return 0


if __name__ == "__main__":
    sys.exit(main())
