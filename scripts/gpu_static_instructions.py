"""Static instruction counts of a kernel by kind, for scripts/gpu_static.py."""

import re
from collections import Counter

# The first match counts. `float`: additions and multiplications; `local`: stack and spills; `generic`: any memory space, selected by the
# address; `shared`: OpenCL's local memory.
KINDS = {
    "nvidia": {
        "load": r"LDG",
        "store": r"STG",
        "generic": r"(LD|ST)(\.|$)",
        "local": r"LDL|STL",
        "shared": r"LDS|STS",
        "constant": r"U?LDC",
        "atomic": r"ATOM|RED$|RED\.",
        "float": r"FFMA|FADD|FMUL",
        "double": r"D(FMA|ADD|MUL|SETP)",
        "special": r"MUFU",
        "convert": r"[IFU]2[IFU]|FRND",
        "compare": r"FMNMX|FSETP|FSET|FSEL|FCHK",
        "integer": r"U?(I|LOP|PLOP|SHF|LEA|PRMT|SEL|BMSK|POPC|FLO|BREV|SGXT|VABSDIFF|P2R|R2P)",
        "branch": r"BRA|BSSY|BSYNC|BREAK|EXIT|CALL|RET|BAR|WARPSYNC|JMP|BRX|YIELD",
    },
    "amd": {
        "load": r"(global|flat)_load",
        "store": r"(global|flat)_store",
        "local": r"scratch_|buffer_(load|store)",
        "shared": r"ds_",
        "constant": r"s_load|s_buffer_load",
        "atomic": r"(global|flat|buffer)_atomic",
        "float": r"v_(pk_|dual_)?(fma|fmac|fmaak|fmamk|mad|mac|add|sub|subrev|mul|mul_legacy)_f32",
        "double": r"v_\w+_f64",
        "special": r"v_(rcp|rsq|sqrt|exp|log|sin|cos)\w*_f32",
        "convert": r"v_(cvt|rndne|floor|trunc|fract|ldexp)",
        "compare": r"v_(cmpx?_\w+_f32|(dual_)?(min|max|med|minmax|maxmin)3?_f32|(dual_)?cndmask)",
        "branch": r"s_(c?branch|endpgm|swappc|setpc|barrier|call)",
        "other": r"s_(waitcnt|nop|delay_alu|clause|mov|inst_prefetch|sleep|code_end)|v_(dual_)?mov|v_accvgpr",
        "integer": r"[vs]_",
    },
}
# Patterns of the start of a function, and of an instruction.
BEGIN = {"nvidia": re.compile(r"^\s*\.section\s+\.text\.([^\s,]+)"), "amd": re.compile(r"^([A-Za-z_]\w*):.*; @")}
INSTRUCTION = {
    "nvidia": re.compile(r"^\s*/\*[0-9a-f]{4,}\*/\s+\{?\s*(?:@!?U?P\w+\s+)?([A-Z][A-Z0-9_.]*)"),
    "amd": re.compile(r"(?:^\t|:: )((?:s|v|global|flat|scratch|buffer|ds)_\w+)"),
}


def kind_of(vendor, name):
    return next((kind for kind, pattern in KINDS[vendor].items() if re.match(pattern, name)), "other")


def counted(vendor, assembly):
    """Instruction counts by kernel and kind. Called functions count where they are defined."""
    counts, current = {}, None
    for line in assembly.splitlines():
        begin = BEGIN[vendor].match(line)
        if begin:
            current = counts.setdefault(begin[1], Counter())
        elif line.startswith(".Lfunc_end"):
            current = None
        elif current is not None:
            current.update(kind_of(vendor, name) for name in INSTRUCTION[vendor].findall(line) if name != "NOP")
    return {name: dict(count) for name, count in counts.items()}
