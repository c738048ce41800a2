# SPDX-License-Identifier: MIT
"""An instruction of Thumb as a walk sees it, and what objdump's text of its operands means."""
import re
from dataclasses import dataclass, field

ALIASES = {"sl": "r10", "fp": "r11", "ip": "r12", "sb": "r9"}
REGISTER = re.compile(r"^(r\d+|sp|lr|pc|s\d+|d\d+)$")


class Unknown(Exception):
    """An instruction that is not understood, or a program that cannot be bounded."""


@dataclass
class Instruction:
    at: int
    after: int
    name: str  # without condition and width
    operands: list
    condition: str = ""  # executed where it holds; else it is issued all the same, or, of a branch, not taken
    kind: str = "plain"  # plain, branch, call, return
    target: int = 0
    sets_flags: bool = False
    reads: set = field(default_factory=set)
    writes: set = field(default_factory=set)
    memory: tuple = ()  # (register, offset, index text, pre-written, post) of a load or store
    size: int = 4
    listed: list = field(default_factory=list)  # registers of a list, in order
    sp_change: int = 0
    operation: str = ""  # of floats whose result intervals.py knows


def split_operands(text):
    parts, depth, part = [], 0, ""
    for c in text:
        depth += (c in "[{") - (c in "]}")
        if c == "," and depth == 0:
            parts.append(part.strip())
            part = ""
        else:
            part += c
    return parts + [part.strip()] if part.strip() else parts


def canonical(text):
    return re.sub(r"\b(sl|fp|ip|sb)\b", lambda m: ALIASES[m[1]], text)


def register_list(text):
    names = []
    for item in text.strip("{}").split(","):
        item = item.strip()
        if "-" in item:
            first, last = item.split("-")
            letter = first[0]
            names += [f"{letter}{i}" for i in range(int(first[1:]), int(last[1:]) + 1)]
        else:
            names.append(item)
    return names


def halves(name):
    """The registers of single precision that make up a name."""
    if name.startswith("d"):
        n = int(name[1:])
        return [f"s{2 * n}", f"s{2 * n + 1}"]
    return [name]


def number(text):
    return int(text.lstrip("#"), 0)


def registers_in(text):
    return {r for r in re.findall(r"\b(?:r\d+|sp|lr)\b", text)}


def addressing(ins, text, post):
    inside = text.strip("!").strip("[]")
    parts = [p.strip() for p in inside.split(",")]
    base, offset, index = parts[0], 0, ""
    if len(parts) > 1:
        if parts[1].startswith("#"):
            offset = number(parts[1])
        else:
            index = ",".join(parts[1:])
    ins.memory = (base, offset, index, text.endswith("!"), number(post) if post else None)
    ins.reads |= registers_in(base) | registers_in(index)
    if text.endswith("!") or post:
        ins.writes.add(base)
        if base == "sp":
            ins.sp_change = offset if text.endswith("!") else number(post)


def multiple(ins, name, base, size):
    written = base.endswith("!")
    base = base.rstrip("!")
    down = name.endswith("db")
    ins.memory = (base, -size if down else 0, "", False, (-size if down else size) if written else None)
    ins.reads.add(base)
    if written:
        ins.writes.add(base)
        ins.sp_change = ins.memory[4] if base == "sp" else 0
