# SPDX-License-Identifier: MIT
"""What is known of the functions of a program before they are walked over: their blocks, the depth of their stack, their
loops with a bound from outside, and what can decide a later branch (strong liveness, from the last instruction back)."""
from dataclasses import dataclass, field

from instruction import Unknown, number
from thumb_effects import effects, is_number

KEPT = [f"r{i}" for i in range(4, 12)]
GIVEN = {"r0", "r1", "r2", "r3"} | {f"s{i}" for i in range(16)}
LOST = GIVEN | {"r12", "lr", "flags", "fpscr"}
AT_EXIT = set(KEPT) | {"r0", "r1", "r2", "r3"}


@dataclass
class Function:
    entry: int
    depth: dict = field(default_factory=dict)  # sp at each instruction, from what it was at entry
    leads: set = field(default_factory=set)  # where a block starts
    before: dict = field(default_factory=dict)  # instruction: those that may run before it
    escaped: int = 1  # the lowest slot whose address is taken
    arguments_escape: bool = False  # so is one of its arguments'
    relevant: dict = field(default_factory=dict)  # what may decide a later branch, before each instruction
    forgotten: dict = field(default_factory=dict)  # what of it, as too much would be known
    loops: dict = field(default_factory=dict)  # (branch, where it stays) with a bound given: header, instructions


@dataclass
class Bound:
    """A loop that ends after `most` rounds for a reason that is not in the code: the text of its line in a file."""

    file: str
    text: str
    most: int

    def is_at(self, file, _, text):
        return file.endswith(self.file) and text == self.text


def slots(ins, depth):
    """The stack slots of a load or store by sp, in the order of its list."""
    base, offset, index, pre, post = ins.memory
    if base != "sp" or index:
        return None
    start = depth + (0 if post is not None and ins.name in ("ldr", "str") else offset)
    return [f"m{start + 4 * i}" for i in range(len(ins.listed))]


class Functions:
    def __init__(self, program, bounds=None):
        self.program, self.code = program, program.code
        self.given = bounds or []  # Bound of loops that the code does not bound
        self.bounds = {}  # (branch, where it stays): how often at most
        self.functions, self.pending, self.switches = {}, set(), {}

    def instruction(self, at):
        ins = self.code.get(at)
        if ins is None:
            raise Unknown(f"{at:x}: no code")
        if isinstance(ins, Unknown):
            raise ins
        return ins

    def where(self, at):
        name = max((a for a in self.program.names if a <= at), default=0)
        file, line, _ = self.program.lines([at])[at][0]
        return f"{at:x} in {self.program.names.get(name, '?')} ({file}:{line})"

    def successors(self, ins):
        if ins.kind == "return":
            return [ins.after] if ins.condition else []
        if ins.kind == "switch":
            return self.switch_targets(ins)
        if ins.kind == "branch":
            always = ins.name == "b" and not ins.condition
            return [ins.target] if always else [ins.after, ins.target]
        return [ins.after]

    def function(self, entry):
        if entry in self.functions:
            return self.functions[entry]
        if entry in self.pending:
            raise Unknown(f"{self.where(entry)}: a call of itself")
        self.pending.add(entry)
        f = Function(entry)
        f.depth[entry], f.leads = 0, {entry}
        todo = [entry]
        while todo:
            at = todo.pop()
            ins = self.instruction(at)
            change = ins.sp_change
            if change is None:
                change = self.sp_by_register(ins)
            for to in self.successors(ins):
                f.before.setdefault(to, []).append(at)
                if to != ins.after or len(f.before[to]) > 1 or ins.kind in ("branch", "switch"):
                    f.leads.add(to)
                depth = f.depth[at] + change
                if to not in f.depth:
                    f.depth[to] = depth
                    todo.append(to)
                elif f.depth[to] != depth:
                    raise Unknown(f"{self.where(to)}: the stack has two depths")
            if ins.name in ("mov", "add") and "sp" in ins.reads and "sp" not in ins.writes:
                rest = [op for op in ins.operands[1:] if op != "sp"]
                at_least = f.depth[at] + (number(rest[0]) if rest and rest[0].startswith("#") else 0)
                f.arguments_escape |= at_least >= 0
                f.escaped = at_least if f.escaped > 0 else min(f.escaped, at_least)
        self.loops_of(f)
        self.liveness(f)
        self.functions[entry] = f
        self.pending.discard(entry)
        return f

    def switch_targets(self, ins):
        """mov pc, r2 after: cmp r1, #N; a branch where above; r1 = 4 r1; r0 = a table in flash; r2 = [r0, r1]."""
        if ins.at in self.switches:
            return self.switches[ins.at]
        above, table, at = None, None, ins.at
        for _ in range(12):
            at = max((a for a in range(at - 4, at, 2) if a in self.code), default=None)
            before = self.code.get(at)
            if before is None or isinstance(before, Unknown):
                break
            if before.name == "ldr" and before.memory[0] == "":
                table = table or self.program.word(before.memory[1])
            if before.name == "cmp" and before.operands[1].startswith("#"):
                above = number(before.operands[1])
                break
        if above is None or table is None:
            raise Unknown(f"{self.where(ins.at)}: goes where the program computes")
        words = [self.program.word(table + 4 * i) for i in range(above + 1)]
        self.switches[ins.at] = sorted({word & ~1 for word in words})
        return self.switches[ins.at]

    def sp_by_register(self, ins):
        """add sp, r4: r4 was set to a number just before."""
        register, at = ins.operands[-1], ins.at
        for _ in range(12):
            at = max((a for a in range(at - 4, at, 2) if a in self.code), default=None)
            before = self.code.get(at)
            if before is None or isinstance(before, Unknown):
                break
            if register in before.writes:
                state = {}
                self.access(before, state, None) if before.memory else state.update(effects(before, {}))
                if is_number(state.get(register)):
                    value = state[register][1]
                    value -= (value & 0x80000000) << 1
                    return value if ins.name == "add" else -value
                break
        raise Unknown(f"{self.where(ins.at)}: sp moves by what is not known")

    def loops_of(self, f):
        """Finds what counts the rounds of loops with a bound from outside: of their tests, the way that stays inside."""
        bodies = {} if not self.given else self.bodies(f)
        tests = {at for body in bodies.values() for at in body if self.code[at].kind == "branch" and self.code[at].reads}
        for branch, places in (self.program.lines(tests) if tests else {}).items():
            most = [b.most for b in self.given if any(b.is_at(*place) for place in places)]
            ways = self.successors(self.code[branch])
            left = [h for h, body in bodies.items() if branch in body and sum(to in body for to in ways) == 1]
            if not most or not left:
                continue
            header = min(left, key=lambda h: len(bodies[h]))
            stays = next(to for to in ways if to in bodies[header])
            out = {at for at in bodies[header] if any(to not in bodies[header] for to in self.successors(self.code[at]))}
            # With no other way out, and back to its first instruction, it has run once before it first goes back.
            self.bounds[branch, stays] = min(most) - (out == {branch} and stays == header)
            f.loops[branch, stays] = (header, bodies[header])

    def bodies(self, f):
        """{header: instructions} of the natural loops: an edge back to what every way to its start comes by."""
        bodies = {}
        for header in f.leads:
            before = f.before.get(header, [])
            if len(before) < 2:
                continue
            seen, todo = {header}, [f.entry] if f.entry != header else []
            while todo:  # what is reached but by the header
                at = todo.pop()
                if at not in seen:
                    seen.add(at)
                    todo += self.successors(self.code[at])
            back = [at for at in before if at not in seen or at == header]
            if not back:
                continue
            body, todo = {header}, back
            while todo:
                at = todo.pop()
                if at not in body:
                    body.add(at)
                    todo += f.before.get(at, [])
            bodies[header] = body
        return bodies

    def calls_reads(self, f, ins):
        callee = self.function(ins.target)
        reads = set()
        for name in callee.relevant[callee.entry]:
            if name in GIVEN:
                reads.add(name)
            elif name.startswith("m") and int(name[1:]) >= 0:
                reads.add(f"m{int(name[1:]) + f.depth[ins.at]}")
        return reads

    def liveness(self, f):
        order = sorted(f.depth)
        f.relevant = {at: set() for at in order}
        todo = set(order)
        while todo:
            at = max(todo)
            todo.discard(at)
            ins = self.instruction(at)
            after = set()
            for to in self.successors(ins):
                after |= f.relevant[to]
            if ins.kind == "return":
                after = after | AT_EXIT
            reads, writes = set(ins.reads), set(ins.writes)
            at_sp = slots(ins, f.depth[at]) if ins.memory else None
            if at_sp and ins.name in ("ldr", "ldm"):
                pairs = zip(at_sp, ins.listed) if abs(ins.size) in (4, 8) else []
                reads |= {slot for slot, name in pairs if name in after or name == "pc"}
            if at_sp and ins.name in ("str", "stm"):
                writes = writes | set(at_sp)
                reads = {name for slot, name in zip(at_sp, ins.listed) if slot in after} | (reads - set(ins.listed))
            if ins.kind == "call":
                reads, writes = self.calls_reads(f, ins), LOST
            deciding = ins.kind in ("branch", "switch") or (ins.kind == "return" and ins.condition)
            needed = reads if deciding or ins.kind == "call" or writes & after else set()
            before = needed | (after if ins.condition else after - writes)
            before.discard("sp")
            if before != f.relevant[at]:
                f.relevant[at] = before
                todo.update(f.before.get(at, []))
