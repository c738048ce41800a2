#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the tables of docs/performance.md from the counts and ratios that stand in the tree.

usage: bench/performance.py [--check]
  --check  write nothing; exit 1 where the page is not what the counts say
Each figure comes from the file whose own test holds it: bench/port_models/counted.json (cycles by models of ports),
docs/appendix/embedded_counts.md and bench/embedded/worst_case/README.md (instructions on emulated boards),
bench/results (ratios that were timed).
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/performance.md"

# Structure, numbers, its name in counted.json, in embedded_counts.md, in worst_case; why a cell has nothing.
ROWS = [
    ("KKL, 3-50x4-2 relu", "float", "relu_50x4", "float relu", None, ""),
    ("", "float, deterministic", None, "deterministic relu", None, "a"),
    ("", "int16", None, "int16 relu", None, "b"),
    ("KKL, 3-50x4-2 tanh", "float", "tanh_50x4", "float tanh", None, ""),
    ("", "float, deterministic", None, "deterministic tanh", None, "a"),
    ("", "int16", None, "int16 tanh", None, "b"),
    ("gated, 32 units", "float", "gated_32", "gated float", None, ""),
    ("", "int16", None, "gated int16", None, "b"),
    ("prior, 24 units", "float", None, "prior float", None, "a"),
    ("carried vectors", "float", None, "carried float", None, "a"),
    ("Luenberger, 2-50-2", "float, deterministic", None, None, "luenberger", "c"),
    ("general", "float, deterministic", None, None, "general", "c"),
    ("driven KKL, window", "any", None, None, None, "d"),
]
DESKTOP = [("Zen 4", "znver4"), ("Sapphire Rapids", "sapphirerapids"), ("Neoverse N1", "neoverse-n1"),
           ("Cortex-A72", "cortex-a72")]
EMBEDDED = [("M4F", "M4F"), ("M0+", "M0, M0+")]


def table_rows(file):
    """The cells of every row of a page's tables."""
    lines = (ROOT / file).read_text().splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]


def performance():
    cores = json.loads((ROOT / "bench/port_models/counted.json").read_text())["cores"]
    counts = {(r[0], r[1]): int(r[2]) for r in table_rows("docs/appendix/embedded_counts.md")
              if len(r) == 7 and r[2].isdigit()}
    worst = {}
    for r in table_rows("bench/embedded/worst_case/README.md"):
        if len(r) == 6 and r[2] in ("step", "estimate"):
            worst[r[0], r[1]] = worst.get((r[0], r[1]), 0) + int(r[3])
    head = ["structure", "numbers", *(name for name, _ in DESKTOP + EMBEDDED)]
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for structure, numbers, port, count, bound, why in ROWS:
        cells = [f"{cores[core][port]['cycles']:,}" if port else f"- {why}" for _, core in DESKTOP]
        for _, core in EMBEDDED:
            figure = counts.get((core, count)) or worst.get((core, bound))
            cells.append(f"{figure:,}" if figure else f"- {why or 'e'}")
        lines.append(f"| {structure} | {numbers} | {' | '.join(cells)} |")
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
                    ratios.setdefault(name, ["- f"] * len(results))[i] = f"{ratio['median']:.2f}"
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
            print("docs/performance.md is not what the counts say: run bench/performance.py")
        return now != text
    PAGE.write_text(now)
    return 0


if __name__ == "__main__":
    sys.exit(main())
