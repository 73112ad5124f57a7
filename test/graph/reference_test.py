#!/usr/bin/env python3
"""The reference (doc/reference) against the running rig, the readers of its files and the programs: see reference.test.

Each page says in its first lines that it is compared. Two marks are read: what is *(outside the rig)* or *(only where
set)* need not be there. In nodes.md, what stands before the first semicolon of a list must be there.
"""
import re
import unittest

import rig_run
from reference_files import Files, Programs  # noqa: F401  pylint: disable=unused-import
from reference_pages import (bullet, entries, limits, material_keys, node_sections, page, parameter_rows, rows,
                             sections)
from reference_run import FOREIGN, LIVE, SPARE, generic, runs

LOGGERS = {'NODE/get_loggers', 'NODE/set_logger_level'}


class Running(unittest.TestCase):
    def expect_same(self, what, real, told, optional=frozenset()):
        faults = ['%s %s is not in the page' % (what, name) for name in sorted(real - told)]
        faults += ['%s %s of the page is not there' % (what, name) for name in sorted(told - real - optional)]
        if faults:
            self.fail('\n' + '\n'.join(faults))

    def test_topics_and_their_types(self):
        told, optional = set(), set()
        for names, kind, outside in entries(page('topics.md')):
            pairs = {(name.lstrip('/'), kind) for name in names}
            told |= pairs
            optional |= pairs if outside else set()
        real = {(generic(topic, run.nodes), kind) for run in runs() for topic, kind in run.types.items()
                if not topic.startswith('/rosout')}
        told = {pair for pair in told if not pair[0].startswith('rosout')}
        self.assertGreater(len(real), 35)
        self.expect_same('topic', {' '.join(pair) for pair in real}, {' '.join(pair) for pair in told},
                         {' '.join(pair) for pair in optional})

    def test_services_and_their_types(self):
        told = {(name, kind) for names, kind, _ in entries(page('services.md')) for name in names}
        real = {(generic(name, run.nodes), kind) for run in runs() for name, kind in run.services.items()
                if not name.startswith(('/' + SPARE, '/rosout'))}
        self.assertGreater(len(real), 15)
        self.expect_same('service', {' '.join(pair) for pair in real}, {' '.join(pair) for pair in told})

    def test_nodes(self):
        described = set(node_sections())
        seen = {node for run in runs() for node in run.nodes} - {'rosout', 'test', SPARE}
        self.assertLessEqual(seen, described, 'nodes that nodes.md does not have')
        never = {'diagnostic_aggregator', 'rviz', 'show_moment'}
        self.assertLessEqual(described - never - FOREIGN, seen, 'nodes of nodes.md that do not run')

    def test_what_each_node_publishes_subscribes_and_serves(self):
        described, faults = node_sections(), set()
        topics = {name for names, _, _ in entries(page('topics.md')) for name in names}
        for run in runs():
            for node in run.nodes & set(described):
                for kind, word in enumerate(('Publishes', 'Subscribes', 'Services')):
                    if (node, word) == ('record', 'Subscribes'):
                        continue  # all
                    always, may = ({name.replace('~', node + '/').lstrip('/') for name in names
                                    if name[0] == '~' or name in topics or kind == 2}
                                   for names in bullet(described[node], word))
                    real = {name.lstrip('/') for name in run.of(kind, node)
                            if name != '/rosout' and generic(name, run.nodes) not in LOGGERS}
                    if node == 'manager':  # what its nodelet does is told of that
                        real = {name for name in real if name.startswith('manager/')}
                    faults |= {'%s: %s %s, which the page does not tell' % (node, word, name) for name in real - may}
                    faults |= {'%s: %s %s by the page, and does not' % (node, word, name) for name in always - real}
        if faults:
            self.fail('\n' + '\n'.join(sorted(faults)))

    def test_parameters(self):
        told, faults = parameter_rows(), []
        common = told['All nodes']
        everywhere = {name for table in told.values() for name in table}
        keys = material_keys()
        asked = {}
        for run in runs():
            for path in run.asked | run.set:
                node, _, name = path.lstrip('/').partition('/')
                if node in FOREIGN or node not in run.nodes or not name or node == 'rosout' or node == SPARE:
                    continue
                material = re.fullmatch(r'\w+/(\w+)', name)
                if node == 'clay_simulator' and material and material.group(1) in keys:
                    name = 'MATERIAL/COEFFICIENT'
                if path in run.asked:
                    asked.setdefault(node, set()).add(name)
                elif name not in everywhere:
                    faults.append('%s/%s is set, and in no page' % (node, name))
        for node, names in asked.items():
            table = told.get(node, {})
            faults += ['%s/%s is read, and not in the page' % (node, name)
                       for name in sorted(names - set(table) - set(common))]
            faults += ['%s/%s of the page is not read' % (node, name) for name in sorted(set(table) - names)
                       if not table[name][3]]
        self.assertGreaterEqual(set(asked), set(LIVE) | {'boards', 'hand_simulator', 'contact_pressure'})
        if faults:
            self.fail('\n' + '\n'.join(sorted(set(faults))))

    def test_live_parameters_with_defaults_and_ranges(self):
        told, faults, count = parameter_rows(), [], 0
        material = {row[0].strip('`'): row for row in rows(sections(page('material_file.md'))['Keys'])}
        for run in runs():
            for node in LIVE:
                for description in run.messages['/%s/parameter_descriptions' % node][:1]:
                    lists = [{one.name: one.value for kind in ('bools', 'ints', 'doubles', 'strs')
                              for one in getattr(config, kind)}
                             for config in (description.dflt, description.min, description.max)]
                    names = {one.name for group in description.groups for one in group.parameters}
                    for name in names:
                        value, low, high = (one[name] for one in lists)
                        where = node + '/' + name
                        if '/' in name:  # of a material, whose file has the value
                            self.expect_limits(faults, where, material[name.split('/')[1]][2], low, high)
                            continue
                        default, span, live, _ = told[node].get(name, ('', '', False, False))
                        if not live:
                            faults.append(where + ' changes live, and is not told so')
                            continue
                        count += 1
                        gate = node in ('simulated_array', 'array_driver')  # whose limits are those of its start
                        if not (gate and name == 'head_spl_cap'):
                            self.expect_default(faults, where, default, value)
                        self.expect_limits(faults, where, span, low, None if gate else high)
                    faults += ['%s/%s is told to change live, and does not' % (node, name)
                               for name, row in told[node].items() if row[2] and name not in names and '/' not in name]
        self.assertGreater(count, 30)
        if faults:
            self.fail('\n' + '\n'.join(sorted(set(faults))))

    @staticmethod
    def expect_default(faults, where, cell, value):
        cell = cell.strip('`')
        same = {'true': True, 'false': False, 'empty': ''}.get(cell, cell)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            same = float(cell) if re.fullmatch(r'-?[\d.]+(e[+-]?\d+)?', cell) else None
        if same != value:
            faults.append('%s has the default %r, and %r in the page' % (where, value, cell))

    @staticmethod
    def expect_limits(faults, where, span, low, high):
        told = limits(span)
        if isinstance(low, (bool, str)):
            return
        if told is None or told[0] != low or (high is not None and told[1] != high):
            faults.append('%s is from %r to %r, and %r in the page' % (where, low, high, span))


if __name__ == '__main__':
    rig_run.main('reference')
