# SPDX-License-Identifier: MIT
"""Computes the least number of cycles that the ports need for a list of instructions, from the resources in llvm-mca's output.

llvm-mca's own figure, "Block RThroughput", looks at each group of ports separately. A division, for example, occupies one of
two ports for long, so the other port must do all the work that both could do. Therefore pairs of ports are examined, too.
"""
import collections
import itertools
import re

SEEN = 8  # occurrences of an instruction that show its ports


def least_cycles(said):
    """Returns the least cycles of the busiest port, or of the busiest two together, from the output of llvm-mca."""
    head, table = said.split("Resource pressure by instruction:\n")
    ports = table.split("Instructions:")[0].split()
    needs = collections.defaultdict(lambda: ([0] * len(ports), [0]))
    for line in table.splitlines()[1:]:
        cells = line.split()
        if len(cells) > len(ports):
            cycles, count = needs[" ".join(re.sub(r"\d+", "", cell) for cell in cells[len(ports):])]
            count[0] += 1
            for port, cell in enumerate(cells[:len(ports)]):
                cycles[port] += 0.0 if cell == "-" else float(cell)
    known = [(sum(cycles), {port for port, need in enumerate(cycles) if need}) for cycles, (count,) in needs.values()
             if count >= SEEN]
    pairs = itertools.combinations(range(len(ports)), 2)
    together = max(sum(need for need, used in known if used <= set(pair)) / 2 for pair in pairs)
    return max(float(re.search(r"Block RThroughput: +([\d.]+)", head)[1]), together)
