# SPDX-License-Identifier: Apache-2.0
"""Mutants that the compiler refuses are taken out: by the lines it names, and one by one where a line has several."""
from mutation.rewrite import rewrite
from mutation.sites import Site


def lines_of(site, data):
    """First and last line of a site in its file."""
    return data.count(b"\n", 0, site.start) + 1, data.count(b"\n", 0, site.end) + 1


def alone(sites, number):
    """The sites with this one mutant."""
    for site in sites:
        kept = [mutant for mutant in site.mutants if mutant.number == number]
        if kept:
            yield Site(**{**vars(site), "mutants": kept})


def drop(sites, numbers):
    for site in sites:
        site.mutants = [mutant for mutant in site.mutants if mutant.number not in numbers]


def take_out_refused(tree, name, reader, command):
    """Writes the file with every mutant that compiles; the number of those that do not."""
    refused = set()
    while True:
        tree.put(name, rewrite(reader.data, reader.sites))
        lines = {line for file, line in tree.refused_lines(command) if file == name}
        if not lines:
            return refused
        suspects = sorted({mutant.number for site in reader.sites for mutant in site.mutants
                           for first, last in [lines_of(site, reader.data)]
                           if any(first <= line <= last for line in lines)})
        found = set()
        for number in suspects:
            tree.put(name, rewrite(reader.data, list(alone(reader.sites, number))))
            if tree.refused_lines(command):
                found.add(number)
        found = found or set(suspects)  # they only fail together
        if not found:
            raise RuntimeError(f"{name}: lines {sorted(lines)} are refused without a mutant on them")
        refused |= found
        drop(reader.sites, found)
