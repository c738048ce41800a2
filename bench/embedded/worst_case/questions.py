# SPDX-License-Identifier: MIT
"""What a branch teaches: beside the registers, a walk keeps what the flags are about ('#flags', '#fpscr': a register and what
it was compared with) and what a register was found not to be ('#not r7')."""
import intervals
from functions import LOST
from thumb_effects import float_operand, holds, is_number, operand


class Questions:
    @staticmethod
    def is_asked(name, keep):
        """A counter of a loop, or what flags are about that matter."""
        if name.startswith("#not "):
            return name[5:] in keep
        return name not in ("#flags", "#fpscr") or name[1:] in keep

    @staticmethod
    def question(ins, state):
        """Keeps what the flags are about: (register, what it was compared with)."""
        asked = state.get("#fpscr")
        for name in ("flags", "fpscr"):
            writes = LOST if ins.kind == "call" else ins.writes
            if "#" + name in state and (name in writes or state["#" + name][0] in writes):
                del state["#" + name]
        for name in [n for n in state if n.startswith("#not ") and n[5:] in (LOST if ins.kind == "call" else ins.writes)]:
            del state[name]
        if ins.condition or len(ins.operands) != 2:
            return
        if ins.name == "cmp" and is_number(operand(ins.operands[1], state)):
            state["#flags"] = (ins.operands[0], operand(ins.operands[1], state))
        elif ins.name == "vcmp" and float_operand(ins.operands[1], state):
            state["#fpscr"] = (ins.operands[0], float_operand(ins.operands[1], state))
        elif ins.name == "vmrs" and asked and "flags" in ins.writes:
            state["#flags"] = asked

    @staticmethod
    def learnt(state, condition, held, of_flags=True):
        """What is known where a condition held, or did not."""
        state = dict(state)
        if of_flags and condition in ("eq", "ne"):
            n, _, c, v = state.get("flags", (None,) * 4)
            state["flags"] = (n, int((condition == "eq") == held), c, v)
        register, other = state.get("#flags", ("", None))
        if register.startswith("s") and register != "sp":
            value = intervals.learnt(state.get(register), condition, held, other)
            if value is not None:
                state[register] = value
        elif register and (condition, held) in (("eq", True), ("ne", False)):
            state[register] = other
        elif register and (condition, held) in (("ne", True), ("eq", False)):
            state["#not " + register] = other
        return state

    def two_ways(self, f, ins, state, count):
        """An IT block that moves values, whose condition is not known, as a branch: what is learnt of it lasts."""
        condition, length = ins.operands[0], int(ins.operands[1])
        if holds(condition, state.get("flags")) is not None:
            return []
        block, at = [], ins.after
        for _ in range(length):
            block.append(self.instruction(at))
            at = block[-1].after
        matters = any(i.writes & f.relevant[at] for i in block)
        if not matters or any(i.name not in ("vmov", "float", "mov") or i.sets_flags for i in block):
            return []
        ways = []
        for held in (True, False):
            way = self.learnt(state, condition, held)
            for i in block:
                if (i.condition == condition) == held:
                    self.with_sp(f, i, way, False)
                    self.question(i, way)
            ways.append((count + length, self.node(f, at, way)))
        return ways
