# SPDX-License-Identifier: Apache-2.0
"""The text of a file in which every mutant stands behind its switch. No line is added: a message of the compiler
names the line of the source."""


def number_mutants(sites, first):
    """Every mutant its number; all uses of one constant share one."""
    constants = {}
    for site in sites:
        for mutant in site.mutants:
            if mutant.role.startswith("constant "):
                mutant.number = constants.setdefault(mutant.role, first)
                first += mutant.number == first
            else:
                mutant.number = first
                first += 1
    return first


def switch(site, role):
    return next((f"VM({mutant.number})" for mutant in site.mutants if mutant.role == role), "false")


def around(site, data):
    """(before, in the place of the operator or the whole, behind)."""
    if site.kind == "negate":
        return "((", None, f") != {switch(site, 'negate')})"
    if site.kind == "force":
        return (f"({switch(site, 'true')} || (!{switch(site, 'false')} && static_cast<bool>(", None, ")))")
    if site.kind == "logic":
        role = site.mutants[0].role
        on = switch(site, role)
        return "(((static_cast<bool>(", f") != {on}) {role} (static_cast<bool>(", f") != {on})) != {on})"
    if site.kind == "call":
        role = site.mutants[0].role
        return f"::voltlap_mutation::{role}({switch(site, role)}, ", ",", ")"
    if site.kind == "minus":
        return f"::voltlap_mutation::negative({switch(site, 'minus')}, ", "", ")"
    text = data[site.start:site.end].decode()
    if site.kind == "literal":
        chosen = "".join(f"VM({mutant.number}) ? {mutant.role} : " for mutant in site.mutants) + text
        return "", f"static_cast<{site.cast}>({chosen})" if site.cast else f"({chosen})", ""
    if site.kind == "constant":
        return "", f"::voltlap_mutation::doubled(VM({site.mutants[0].number}), {text}, 0)", ""
    if site.mutants[0].role == "default":
        return f"{{ if (VM({site.mutants[0].number})) return {{}}; ", None, " }"
    return f"{{ if (!VM({site.mutants[0].number})) ", None, " }"


def rewrite(data, sites):
    """The bytes of the file with the switches of all mutants that the sites still have."""
    edits = []  # (offset, behind before in front, order, text, bytes of the source that it takes the place of)
    for site in sites:
        if not site.mutants:
            continue
        before, middle, behind = around(site, data)
        place = site.operator or (site.start, site.end)
        edits.append((site.start, 1, site.depth, before, 0))
        edits.append((site.end, 0, -site.depth, behind, 0))
        if middle is not None:
            edits.append((place[0], 2, site.depth, middle, place[1] - place[0]))
    out, at = [], 0
    for offset, _, _, text, taken in sorted(edits, key=lambda edit: edit[:3]):
        out.append(data[at:offset])
        out.append(text.encode())
        at = offset + taken
    return b"".join(out) + data[at:]
