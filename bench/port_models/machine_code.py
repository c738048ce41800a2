# SPDX-License-Identifier: MIT
"""Finds the instructions that one call of a function executes, from the assembly of a compiler.

llvm-mca reads a list of instructions and follows no jump. Therefore this module executes the call as far as jumps and
addresses need it: it computes integers. Vectors, the caller's data and the results of unknown instructions are None. A
jump or an address that depends on None is an error.

llvm-mca does not see that a load reads a value that was stored before, and would run the layers of a network in parallel.
trace() expresses this dependence by a register: after such a store the value moves to a general register, and the load uses
this register as its address. The time of this move represents the time of the store and the load.
"""
import re

MASK = (1 << 64) - 1
MOST = 500000  # instructions of one call


class Unknown(Exception):
    """Raised for a necessary instruction that the emulator does not know."""


def operands(text):
    """Returns the operands of one instruction. Commas inside brackets do not separate them."""
    parts, depth, start = [], 0, 0
    for at, char in enumerate(text):
        depth += (char in "([{") - (char in ")]}")
        if char == "," and depth == 0:
            parts.append(text[start:at].strip())
            start = at + 1
    return [*parts, text[start:].strip()] if text.strip() else []


def instructions(assembly):
    """Returns (instructions as (mnemonic, operands), {label: index}) of a file."""
    code, labels = [], {}
    for line in assembly.split("\n"):
        line = re.sub(r"^\s*#.*|//.*", "", line).strip()
        if line.endswith(":"):
            labels[line[:-1]] = len(code)
        elif line and not line.startswith("."):
            mnemonic, *rest = line.split(None, 1)
            code.append((mnemonic, operands(rest[0] if rest else "")))
    return code, labels


class Core:
    """The common part of both architectures: registers, memory of integers, and symbols with an address each."""

    def __init__(self):
        self.registers, self.memory, self.symbols, self.flags = {}, {}, {}, (0, 0)

    def symbol(self, name):
        """Returns the address of "name", "name+8" or "8+name"."""
        parts = name.lstrip("#:").removeprefix("lo12:").split("+")
        base = next(part for part in parts if not re.fullmatch(r"-?\d+", part))
        return self.symbols.setdefault(base, (len(self.symbols) + 16) << 24) + sum(int(p) for p in parts if p != base)

    @staticmethod
    def fused(_):
        """Returns true if an instruction is fused with the following jump."""
        return False

    def signed(self, value, bits=64):
        value &= (1 << bits) - 1
        return value - (1 << bits) if value >> (bits - 1) else value

    def holds(self, condition):
        """Returns true if the comparison of the two values in `flags` has this result."""
        if self.flags is None or None in self.flags:
            raise Unknown("a jump that the caller's data decide")
        a, b = self.flags
        s, t = self.signed(a), self.signed(b)
        return {"e": a == b, "ne": a != b, "l": s < t, "ge": s >= t, "le": s <= t, "g": s > t,
                "b": a < b, "ae": a >= b, "be": a <= b, "a": a > b, "s": s < t, "ns": s >= t}[condition]


def run(core, code, labels, name):
    """Returns the instructions of one call: [(text, loaded range or None, stored range or None, stored register)]"""
    if name not in labels:
        raise Unknown(f"there is no function {name}")
    at, returns, done = labels[name], [], []
    while len(done) < MOST:
        mnemonic, ops = code[at]
        at += 1
        if mnemonic == "ret" and not returns:
            return done
        if mnemonic == "ret":
            at = returns.pop()
        elif mnemonic in ("call", "bl"):
            returns.append(at)
            at = labels[ops[0]]
        else:
            target = core.jump(mnemonic, ops)
            moved = (None, None, None) if target is not None else core.execute(mnemonic, ops)
            if target is not None and done and core.fused(done[-1][0]):
                done.pop()
            done.append((f"{mnemonic}\t{', '.join(ops)}", *moved))
            if target:
                at = labels[target]
    raise Unknown(f"{name} takes more than {MOST} instructions")


def trace(core, assembly, name, waits=True):
    """Returns one call of a function of instructions() as text for llvm-mca. With `waits`, registers represent the
    dependences through memory."""
    done = run(core, *assembly, name)
    text = "\n".join(line for line, *_ in done)
    if not waits:
        return text + "\n"
    free = [register for register in core.general() if not core.uses(text, register)]
    if len(free) < 2:
        raise Unknown(f"{name} leaves no registers for the dependences through memory")
    writer, read_later = {}, {}
    for index, (_, loaded, stored, _) in enumerate(done):
        if loaded:
            sources = {writer[word] for word in range(loaded[0] // 4, (sum(loaded) + 3) // 4) if word in writer}
            if sources:
                read_later[index] = max(sources)
        if stored and done[index][3]:
            for word in range(stored[0] // 4, (sum(stored) + 3) // 4):
                writer[word] = index
    linked, lines = {}, []
    wanted = set(read_later.values())
    for index, (line, _, _, register) in enumerate(done):
        if index in read_later:
            line = core.addressed_by(line, linked[read_later[index]])
        lines.append(line)
        if index in wanted:
            linked[index] = free[len(linked) % len(free)]
            lines.append(core.link(register, linked[index]))
    return "\n".join(lines) + "\n"
