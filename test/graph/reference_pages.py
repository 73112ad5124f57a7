"""Reads the pages of doc/reference, for reference_test.py: tables, lists and marks. A module, no program."""
import math
import os
import re

import rig_run

REFERENCE = os.path.join(rig_run.PACKAGE, 'doc', 'reference')
OUTSIDE, WHERE_SET = '*(outside the rig)*', '*(only where set)*'


def page(name):
    with open(os.path.join(REFERENCE, name), encoding='utf-8') as file:
        return file.read()


def sections(text, level=2):
    """{heading: text below it} of the headings of a level."""
    parts = re.split(r'^%s (.+)$' % ('#' * level), text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


def quoted(text):
    return re.findall(r'`([^`]+)`', text)


def rows(text):
    """Cells of the rows of all tables, without their heads."""
    found = [re.split(r'\s*\|\s*', line.strip())[1:-1] for line in text.splitlines() if line.startswith('|')]
    return [row for k, row in enumerate(found) if not set(''.join(row)) <= set('-| ') and
            not (k + 1 < len(found) and set(''.join(found[k + 1])) <= set('-| '))]


def entries(text):
    """[(names, type, marked)] of the list `- **`name`**, **`name`**: `type`...`."""
    found = re.findall(r'^- (\*\*`.+?`\*\*): `([\w/]+)`([^\n]*)', text, re.MULTILINE)
    return [(re.findall(r'\*\*`([^`]+)`\*\*', names), kind, OUTSIDE in rest) for names, kind, rest in found]


def bullet(text, name):
    """(what is always there, all) of the list `- NAME: ...` of a node's section, as sets of quoted names."""
    found = re.search(r'^- %s: (.*?)(?=^- |^\s*$|\Z)' % name, text, re.MULTILINE | re.DOTALL)
    words = found.group(1) if found else ''
    return set(quoted(words.split(';')[0])), set(quoted(words))


def node_sections():
    return {name: text for heading, text in sections(page('nodes.md')).items() for name in heading.split(', ')}


def parameter_rows():
    """{node: {name: (default, range, live, marked)}}; {heading of a section: the same} for those that are shared."""
    text = page('parameters.md') + '\n' + page('parameters_array.md')
    own, also = {}, {}
    for heading, body in sections(text).items():
        table, live = {}, False
        for line in body.splitlines():
            live = line.startswith('Live') or (live and not line.startswith('Read'))
            for name, default, span, *_ in ([row for row in rows(line) if len(row) == 4] if '`' in line else []):
                table.update(dict.fromkeys(quoted(name), (default, span, live, WHERE_SET in name)))
        own[heading] = table
        told = re.search(r'Also: (.*?)(?=^\s*$)', body, re.MULTILINE | re.DOTALL)
        also[heading] = re.findall(r'\(#([\w-]+)\)', told.group(1)) if told else []
    anchors = {heading.lower().replace(' ', '-'): heading for heading in own}
    return {heading: dict(pair for part in [heading] + [anchors[anchor] for anchor in also[heading]]
                          for pair in own[part].items()) for heading in own}


def limits(span):
    """(lowest, highest) of a range as it is written, or None where it is none of numbers."""
    number = r'(-?[\d.]+(?:e[+-]?\d+)?)'
    for form, ends in ((number + r' to ' + number, (1, 2)), (r'above ' + number + r', at most ' + number, (1, 2)),
                       (r'above ' + number, (1, None)), (number + r' or more', (1, None))):
        found = re.match(form, span)
        if found:
            return tuple(float(found.group(k)) if k else math.inf for k in ends)
    return None


def material_keys():
    """Names of the coefficients in material_file.md."""
    return {row[0].strip('`') for row in rows(sections(page('material_file.md'))['Keys'])}
