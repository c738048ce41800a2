# SPDX-License-Identifier: MIT
"""Instructions of the FPU: see thumb.py."""
import re

import intervals
from instruction import REGISTER, Unknown, addressing, halves, multiple, register_list

FLOATS = {"vadd", "vsub", "vmul", "vdiv", "vnmul", "vneg", "vabs", "vsqrt", "vcvt", "vcvtr", "vcvta", "vrinta", "vrintn",
          "vrintz", "vmaxnm", "vminnm", "vcvtb", "vcvtt", "vselgt", "vselge", "vseleq", "vselvs"}
FLOATS_READ_FIRST = {"vfma", "vfms", "vfnma", "vfnms", "vmla", "vmls", "vnmla", "vnmls"}


def decode(ins, name, ops, comment):
    head, _, kind = name.partition(".")
    if head in ("vpush", "vpop"):
        head, ops = ("vstmdb", ["sp!"] + ops) if head == "vpush" else ("vldmia", ["sp!"] + ops)
    if head in ("vldmia", "vstmia", "vldmdb", "vstmdb"):
        names = register_list(ops[1])
        ins.listed = [half for n in names for half in halves(n)]
        ins.name = "ldm" if head[1] == "l" else "stm"
        multiple(ins, head, ops[0], 4 * len(ins.listed))
        (ins.writes if head[1] == "l" else ins.reads).update(ins.listed)
        return ins
    if head in ("vldr", "vstr"):
        ins.listed = halves(ops[0])
        ins.name, ins.size = "ldr" if head == "vldr" else "str", 4 * len(ins.listed)
        addressing(ins, ops[1], None)
        if ins.memory[0] == "pc":
            ins.memory = ("", ((ins.at + 4) & ~3) + ins.memory[1], "", False, None)
        (ins.writes if head == "vldr" else ins.reads).update(ins.listed)
        return ins
    if head in ("vcmp", "vcmpe"):
        ins.name = "vcmp"
        ins.writes.add("fpscr")
        for op in ops:
            if REGISTER.match(op):
                ins.reads.update(halves(op))
        return ins
    if head == "vmrs":
        ins.reads.add("fpscr")
        ins.writes.add("flags" if ops[0].startswith("APSR") else ops[0])
        return ins
    if head == "vmsr":
        raise Unknown(f"{ins.at:x}: changes how floats are rounded")
    if head == "vmov":
        if len(ops) == 2:
            ins.name = "vmov"
            ins.writes.update(halves(ops[0]))
            if REGISTER.match(ops[1]):
                ins.reads.update(halves(ops[1]))
            else:
                pattern = re.search(r"0x([0-9a-f]{8})", comment or "")
                ins.operands = [ops[0], f"#0x{pattern[1]}" if pattern else "?"]
            return ins
        ins.name = "several"
        names = [half for op in ops for half in halves(op)]
        integer_first = ops[0].startswith("r")
        cut = [i for i, n in enumerate(names) if n.startswith("s") == integer_first][0]
        ins.writes.update(names[:cut])
        ins.reads.update(names[cut:])
        return ins
    if head in FLOATS or head in FLOATS_READ_FIRST:
        ins.name = "float"
        if kind == "f32" and head in intervals.KNOWN and all(op.startswith("s") for op in ops):
            ins.operation = head
        ins.writes.update(halves(ops[0]))
        for op in ops if head in FLOATS_READ_FIRST else ops[1:]:
            if REGISTER.match(op):
                ins.reads.update(halves(op))
        if head.startswith("vsel"):
            ins.reads.add("flags")
        return ins
    raise Unknown(f"{ins.at:x}: {name} {', '.join(ops)}: what does it do?")
