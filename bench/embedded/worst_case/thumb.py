# SPDX-License-Identifier: MIT
"""What Arm's Thumb instructions do to what a walk knows (walk.py), read from objdump's text.

Each instruction becomes an Instruction: what it reads, what it writes, where it goes. Values that a walk knows are
(base, offset): base '' for a number, else something unknown that two pointers may share. What is not known is None.
A mnemonic that this file does not know is an error, never a guess.
"""
import re

import thumb_floats
from instruction import Instruction, Unknown, addressing, canonical, multiple, number, register_list, registers_in
from instruction import split_operands

CONDITIONS = ("eq", "ne", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le")
SETTERS = {"adds", "adcs", "subs", "sbcs", "rsbs", "negs", "ands", "orrs", "orns", "eors", "bics", "lsls", "lsrs",
           "asrs", "rors", "movs", "mvns", "muls"}
TWO_IN_ONE = {"add", "adc", "sub", "sbc", "rsb", "and", "orr", "orn", "eor", "bic", "lsl", "lsr", "asr", "ror", "mul"}
PLAIN = TWO_IN_ONE | {"mov", "movw", "mvn", "neg", "mla", "mls", "udiv", "sdiv", "uxth", "uxtb", "sxth", "sxtb", "ubfx",
                      "sbfx", "clz", "rev", "rev16", "smlad", "smuad", "smulbb", "smlabb", "smlabt", "smlatb", "smlatt",
                      "smultt", "smulbt", "smultb", "smmul", "pkhbt", "pkhtb", "ssat", "usat", "qadd", "qsub", "rbit",
                      "uxtab", "uxtah", "sxtah", "sxtab", "adr", "sxtb16", "smlsd", "csel"}
READS_FIRST = {"bfi", "bfc", "movt"}
LONG = {"umull", "smull", "umlal", "smlal", "smlalbb", "smlald"}
COMPARES = {"cmp", "cmn", "tst", "teq"}
NOTHING = {"nop", "dsb", "isb", "dmb", "bkpt", "cpsie", "cpsid", "pld"}


def strip_condition(name, condition):
    """vaddpl.f32 in an IT block for pl: vadd.f32"""
    head, dot, kind = name.partition(".")
    names = {condition, {"cs": "hs", "cc": "lo"}.get(condition, condition)}
    for suffix in names:
        if head.endswith(suffix):
            return head[: -len(suffix)] + dot + kind
    raise Unknown(f"{name}: not for {condition}, as its IT block says")


def decode(at, after, name, operands, condition, comment):
    """One instruction. `condition`: of the IT block that it stands in."""
    operands = canonical(operands)
    head = name.split(".")[0]
    width = name.endswith((".n", ".w"))
    name = name[:-2] if width else name
    ins = Instruction(at, after, name, split_operands(operands), condition)
    if condition:
        ins.reads.add("flags")
        if name not in ("b", "bx", "bl"):
            name = ins.name = strip_condition(name, condition)
    elif re.fullmatch(r"b(" + "|".join(CONDITIONS) + ")", name):
        ins.condition, name = name[1:], "b"
        ins.name = name
        ins.reads.add("flags")
    ops = ins.operands
    if condition and head.startswith("b") and re.fullmatch(r"b(l|x)?(" + "|".join(CONDITIONS) + ")", head):
        name = ins.name = head[:-2]
    if name in ("b", "bl"):
        ins.kind = "branch" if name == "b" else "call"
        ins.target = int(ops[0].split()[0], 16)
        return ins
    if name in ("cbz", "cbnz"):
        ins.kind, ins.target = "branch", int(ops[1].split()[0], 16)
        ins.reads.add(ops[0])
        return ins
    if name in ("bx", "blx", "tbb", "tbh"):
        if name != "bx" or ops[0] != "lr":
            raise Unknown(f"{at:x}: {name} {operands}: goes where the program computes")
        ins.kind = "return"
        return ins
    if name in NOTHING:
        return ins
    if name.startswith("v"):
        return thumb_floats.decode(ins, name, ops, comment)
    base = name[:-1] if name in SETTERS else {"addw": "add", "subw": "sub"}.get(name, name)
    ins.sets_flags = name in SETTERS
    if ins.sets_flags:
        ins.writes.add("flags")
    if base in PLAIN or base in READS_FIRST:
        if base == "csel":
            raise Unknown(f"{at:x}: {name}")
        ins.name = base
        ins.writes.add(ops[0])
        sources = ops[1:]
        if base in READS_FIRST or (base in TWO_IN_ONE and (len(ops) == 2 or (len(ops) == 3 and " " in ops[2]))):
            sources = ops
        for op in sources:
            ins.reads |= registers_in(op)
        if base in ("adc", "sbc"):
            ins.reads.add("flags")
        if "sp" in ins.writes:
            if base in ("add", "sub") and ops[-1].startswith("#"):
                ins.sp_change = number(ops[-1]) * (1 if base == "add" else -1)
            else:
                ins.sp_change = None  # by a register: the walk looks
        if ops[0] == "pc":
            if base == "mov" and ops[1] == "lr":
                ins.kind = "return"
                return ins
            ins.kind = "switch"
            ins.writes.discard("pc")
        return ins
    if base in LONG:
        ins.writes |= {ops[0], ops[1]}
        for op in ops if "al" in base else ops[2:]:
            ins.reads |= registers_in(op)
        return ins
    if base in COMPARES:
        ins.writes.add("flags")
        for op in ops:
            ins.reads |= registers_in(op)
        return ins
    load = re.fullmatch(r"(ldr|str)(b|h|sb|sh|d)?", base)
    if load:
        ins.size = {"b": 1, "sb": 1, "h": 2, "sh": 2, "d": 8, None: 4}[load[2]]
        count = 2 if load[2] == "d" else 1
        ins.name, ins.listed = load[1], ops[:count]
        addressing(ins, ops[count], ops[count + 1] if len(ops) > count + 1 else None)
        if ins.memory[0] == "pc":
            where = re.search(r"\(([0-9a-f]+)", comment or "")
            ins.memory = ("", int(where[1], 16) if where else ((at + 4) & ~3) + ins.memory[1], "", False, None)
        if load[1] == "ldr":
            ins.writes |= set(ins.listed)
        else:
            ins.reads |= set(ins.listed)
        if "pc" in ins.listed and load[1] == "ldr":
            if not (ins.memory[0] == "sp" and ins.memory[4]):
                raise Unknown(f"{at:x}: {name} {operands}: goes where the program computes")
            ins.kind = "return"
            ins.writes.discard("pc")
        if load[2] in ("sb", "sh"):
            ins.size = -ins.size
        return ins
    return decode_multiple(ins, base, ops)


def decode_multiple(ins, name, ops):
    """push, pop, ldm, stm: registers in a list, from the lowest address."""
    short = {"push": ("stmdb", "sp!"), "pop": ("ldmia", "sp!"), "ldm": ("ldmia", None), "stm": ("stmia", None)}
    if name in short:
        long, base = short[name]
        name, ops = long, ops if base is None else [base] + ops
    if name not in ("ldmia", "stmia", "ldmdb", "stmdb"):
        raise Unknown(f"{ins.at:x}: {ins.name} {', '.join(ins.operands)}: what does it do?")
    base = ops[0].rstrip("!")
    ins.name, ins.listed = name[:3], register_list(ops[1])
    size = 4 * len(ins.listed)
    multiple(ins, name, ops[0], size)
    if ins.name == "ldm":
        ins.writes |= set(ins.listed)
        if "pc" in ins.listed:
            if base != "sp":
                raise Unknown(f"{ins.at:x}: pc is loaded through {base}")
            ins.kind = "return"
            ins.writes.discard("pc")
    else:
        ins.reads |= set(ins.listed)
    return ins


def read(text):
    """objdump -d as {address: Instruction or Unknown} and {address: function}. What cannot be read is an error only
    where a walk comes by."""
    lines, names = [], {}
    for line in text.splitlines():
        symbol = re.match(r"^([0-9a-f]+) <(.+)>:$", line)
        if symbol:
            names[int(symbol[1], 16)] = symbol[2]
            continue
        code = re.match(r"^\s*([0-9a-f]+):\t([^\t]+)(?:\t(.*))?$", line)
        if code:
            lines.append((int(code[1], 16), code[2].strip(), code[3] or ""))
    found, block = {}, []
    for i, (at, name, operands) in enumerate(lines):
        after = lines[i + 1][0] if i + 1 < len(lines) else at + 4
        operands, _, comment = operands.partition("@")
        operands = re.split(r"\s*[;<]", operands)[0].strip()
        if at in names:
            block = []
        if re.fullmatch(r"it[te]{0,3}", name):
            first = operands.strip()
            other = {a: b for pair in zip(CONDITIONS[::2], CONDITIONS[1::2]) for a, b in (pair, pair[::-1])}[first]
            block = [first] + [first if c == "t" else other for c in name[2:]]
            found[at] = Instruction(at, after, "it", [first, str(len(block))])
            continue
        try:
            found[at] = decode(at, after, name, operands, block.pop(0) if block else "", comment)
            if found[at].kind == "call" and found[at].target not in names:
                found[at].kind, found[at].name = "branch", "b"  # in a function too long for a jump of an M0, which has saved lr
        except (Unknown, ValueError, IndexError, KeyError) as error:
            found[at] = Unknown(str(error) if isinstance(error, Unknown) else f"{at:x}: {name} {operands}: not read")
    return found, names
