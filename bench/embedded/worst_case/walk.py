# SPDX-License-Identifier: MIT
"""The most instructions that a function of a linked program can take, by walking over all of its paths.

A walk knows of registers and stack slots what the code itself fixes: numbers, and pointers as something unknown plus an
offset. Branches that this decides are followed, others both ways; so a loop that counts to a constant, or runs a pointer
to an end at a constant distance, is unrolled. Paths that meet knowing the same are one from there on: what no later branch
can depend on is forgotten (strong liveness), and the longest way through what remains is the bound. Where the walk comes
back to a place with nothing learnt, the loop has no bound: an error, with its address.

What is assumed, as of every compiled program: calls keep r4 to r11 (checked at each return) and s16 to s31, and no
pointer reaches the slots in which a compiler keeps registers.
"""
from collections import Counter

from functions import GIVEN, KEPT, LOST, Functions, slots
from instruction import Unknown
from questions import Questions
from thumb_effects import constant, effects, holds, is_number, operand, plus

MOST_STATES = 20_000  # of one instruction


class Walk(Functions, Questions):
    def __init__(self, program, bounds=None):
        super().__init__(program, bounds)
        self.known, self.active = {}, []

    def access(self, ins, state, f):
        """Loads and stores."""
        base, offset, index, pre, post = ins.memory
        depth = f.depth[ins.at] if f else 0
        pointer = constant(0) if base == "" else (f"sp:{f.entry:x}", depth) if base == "sp" else state.get(base)
        moved = offset if pre else post
        address = plus(pointer, constant(0) if post is not None and ins.name in ("ldr", "str") else ("", offset))
        if index:
            address = plus(address, operand(index, state) if "," not in index else None)
        at_sp = slots(ins, depth) if f else None
        results = {}
        if ins.name in ("ldr", "ldm"):
            for i, name in enumerate(ins.listed):
                value = None
                if at_sp:
                    value = state.get(at_sp[i]) if ins.size == 4 or ins.name == "ldm" or ins.size == 8 else None
                elif is_number(address):
                    size = abs(ins.size) if ins.name == "ldr" and ins.size != 8 else 4
                    word = self.program.word(address[1] + 4 * i, size)
                    if word is not None:
                        value = constant(word - (1 << 8 * size) if ins.size < 0 and word >> (8 * size - 1) else word)
                if value is not None and value[0] == "~f" and name.startswith("r"):
                    value = None
                if value is None and (ins.size in (4, 8) or ins.name == "ldm") and name.startswith("r"):
                    value = (f"@{ins.at:x}.{i}", 0)
                results[name] = value
        else:
            self.store(ins, state, f, at_sp, address)
        if moved is not None and base not in ("sp", "") and base not in results:
            results[base] = plus(pointer, ("", moved))
        return results

    def store(self, ins, state, f, at_sp, address):
        if at_sp:
            for slot, name in zip(at_sp, ins.listed):
                value = state.get(name) if abs(ins.size) in (4, 8) or ins.name == "stm" else None
                if value is None:
                    state.pop(slot, None)
                else:
                    state[slot] = value
            return
        if address is not None and address[0] == f"sp:{f.entry:x}":
            for i in range(len(ins.listed)):
                state.pop(f"m{(address[1] & ~3) + 4 * i}", None)
        elif is_number(address):
            if any(address[1] + 4 * i in self.program.frozen for i in range(len(ins.listed))):
                raise Unknown(f"{self.where(ins.at)}: writes what is said to be constant")
        else:
            self.forget_escaped(f, state)

    def forget_escaped(self, f, state):
        """A pointer into this frame may have been written through; not over its saved registers to its arguments."""
        for slot in [s for s in state if s[0] == "m" and int(s[1:]) >= f.escaped]:
            if not state[slot][0].startswith("in:") and (int(slot[1:]) < 0 or f.arguments_escape):
                del state[slot]

    def write(self, at, state, results, may=False):
        """Takes over what an instruction writes. A new unknown has its name: what had it before is another."""
        new = {v[0] for v in results.values() if v is not None and str(v[0]).startswith(f"@{at:x}.")}
        if new:
            for name in [n for n, v in state.items() if n not in ("flags", "fpscr") and v[0] in new]:
                del state[name]
        for name, value in results.items():
            if may and state.get(name) != value:
                value = None
            if value is None or (name in ("flags", "fpscr") and value == (None,) * 4):
                state.pop(name, None)
            else:
                state[name] = value

    def call(self, f, ins, state):
        callee = self.function(ins.target)
        given, depth = {}, f.depth[ins.at]
        for name in callee.relevant[callee.entry]:
            source = name
            if name.startswith("m"):
                source = f"m{int(name[1:]) + depth}"
            elif name not in GIVEN:
                continue
            if source in state:
                given[name] = state[source]
        most, exit_state = self.bound(ins.target, given)
        for name in LOST:
            state.pop(name, None)
        self.forget_escaped(f, state)
        results = {}
        for i in range(4):
            value = exit_state.get(f"r{i}")
            if value is None or value[0].startswith(("@", "sp:" + f"{callee.entry:x}", "in:")):
                value = (f"@{ins.at:x}.r{i}", 0)
            results[f"r{i}"] = value
        self.write(ins.at, state, results)
        return most

    def bound(self, entry, given=None):
        """The most instructions of a call, and what is known of the registers that it returns."""
        f = self.function(entry)
        state = {name: (f"in:{name}", 0) for name in KEPT}
        state.update({name: value for name, value in (given or {}).items() if name in f.relevant[entry]})
        key = (entry, frozenset(state.items()))
        if key not in self.known:
            if entry in self.active:
                raise Unknown(f"{self.where(entry)}: a call of itself")
            self.active.append(entry)
            self.known[key] = self.longest(f, state)
            self.active.pop()
        return self.known[key]

    def node(self, f, at, state):
        keep = f.relevant[at] - f.forgotten[at] if at in f.forgotten else f.relevant[at]
        kept = ((n, v) for n, v in state.items() if n in keep or (n[0] == "#" and self.is_asked(n, keep)))
        return (at, frozenset(kept))

    def longest(self, f, state):
        while True:
            found = self.longest_unless_many(f, state)
            if found:
                return found

    def longest_unless_many(self, f, state):
        """None where too many states meet at an instruction: what differs most among them is forgotten there, as the
        bits of a quotient that a loop shifts together."""
        root = self.node(f, f.entry, state)
        cost, ways, exits, stack, nodes = {}, {}, [], [root], Counter()
        while stack:
            node = stack[-1]
            if node not in ways:
                ways[node] = self.expand(f, node, exits)
                nodes[node[0]] += 1
                if nodes[node[0]] > MOST_STATES:
                    self.forget(f, node[0], [n for n in ways if n[0] == node[0]])
                    return None
                for _, to in ways[node]:
                    if to is not None and to not in cost:
                        if to in ways:
                            raise Unknown(f"{self.where(node[0])}: no bound for the loop to {self.where(to[0])}")
                        stack.append(to)
                continue
            stack.pop()
            if node in cost:
                continue
            for _, to in ways[node]:
                if to is not None and to not in cost:
                    raise Unknown(f"{self.where(node[0])}: no bound for the loop to {self.where(to[0])}")
            cost[node] = max((n + (0 if to is None else cost[to]) for n, to in ways[node]), default=-(10**9))
        if not exits:
            raise Unknown(f"{self.where(f.entry)}: never returns")
        joined = {n: v for n, v in exits[0].items() if all(e.get(n) == v for e in exits)}
        return cost[root], joined

    def forget(self, f, at, nodes):
        values = {}
        for _, items in nodes:
            for name, value in items:
                if name[0] in "rms":
                    values.setdefault(name, set()).add(value)
        most = max(values, key=lambda name: len(values[name]), default=None)
        if most is None or len(values[most]) < 2:
            raise Unknown(f"{self.where(at)}: too many paths")
        f.forgotten.setdefault(at, set()).add(most)

    def expand(self, f, node, exits):
        """[(instructions, node that follows or None)] from a node to the next block or branch."""
        at, state, count = node[0], dict(node[1]), 0
        while True:
            ins = self.instruction(at)
            count += 1
            taken = True
            if ins.condition:
                taken = holds(ins.condition, state.get("flags"))
            if ins.kind == "call":
                if taken is not True:
                    raise Unknown(f"{self.where(at)}: a conditional call")
                count += self.call(f, ins, state)
            elif ins.kind == "switch":
                return [way for to in self.successors(ins) for way in self.follow(f, ins, to, state, count)]
            elif ins.kind == "branch":
                if ins.name in ("cbz", "cbnz"):
                    value = state.get(ins.operands[0])
                    zero = value[1] == 0 if is_number(value) else False if value and value[0][:3] == "sp:" else None
                    taken = None if zero is None else zero == (ins.name == "cbz")
                    state["#flags"] = (ins.operands[0], constant(0))
                condition = ins.condition or {"cbz": "eq", "cbnz": "ne"}.get(ins.name)
                ways = []
                for to, held, goes in ((ins.target, True, taken is not False), (ins.after, False, taken is not True)):
                    if goes:
                        ways += self.follow(f, ins, to, self.learnt(state, condition, held, bool(ins.condition)), count)
                return ways
            elif ins.memory:
                if taken is not False:
                    before = dict(state)
                    results = self.access(ins, state, f)
                    self.write(ins.at, state, results, may=taken is None)
                    if taken is None:
                        for name in [n for n in state if before.get(n) != state[n]]:
                            del state[name]
            elif taken is not False:
                self.with_sp(f, ins, state, taken is None)
            self.question(ins, state)
            if ins.name == "it":
                ways = self.two_ways(f, ins, state, count)
                if ways:
                    return ways
            if ins.kind == "return" and taken is not False:
                self.returned(f, ins, state, exits)
                return [(count, None)] + (self.follow(f, ins, ins.after, state, count) if taken is None else [])
            at = ins.after
            if at in f.leads:
                return [(count, self.node(f, at, state))]

    def with_sp(self, f, ins, state, may):
        """Any other instruction; the value of sp is known from its place."""
        state["sp"] = (f"sp:{f.entry:x}", f.depth[ins.at])
        results = effects(ins, state)
        results.pop("sp", None)
        del state["sp"]
        self.write(ins.at, state, results, may)

    def follow(self, f, ins, to, state, count):
        """A way from a branch, unless a bound given for its loop is used up."""
        state = dict(state)
        for (branch, stays), (header, body) in f.loops.items():
            name = f"#{branch:x}"
            if (ins.at, to) == (branch, stays):
                taken = state.get(name, ("", 0))[1] + 1
                if taken > self.bounds[branch, stays]:
                    return []
                state[name] = ("", taken)
            elif to not in body or (to == header and ins.at not in body):
                state.pop(name, None)
        return [(count, self.node(f, to, state))]

    def returned(self, f, ins, state, exits):
        for name in KEPT:
            if state.get(name) != (f"in:{name}", 0):
                raise Unknown(f"{self.where(ins.at)}: returns with another {name}: {state.get(name)}")
        exits.append({n: v for n, v in state.items() if n in ("r0", "r1", "r2", "r3")})
