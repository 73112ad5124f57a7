#!/usr/bin/env python3
"""Follows each tutorial of doc/tutorials from its top: see tutorials.test.

A fenced block below the mark `<!-- file: NAME -->` is written to that file. A block of `sh` is run by a user whose home
folder has the checkout as ~/tactile_clay; what it exports, and the folder it ends in, hold for the next one. A block of
`text` is what the commands before it print: these lines in this order, perhaps with others between them; `...` stands
for anything within a line. Other marks stand before a block of `sh`:

    <!-- test: not run, REASON -->        it is left to the reader
    <!-- test: goes on -->                it runs beside the next ones, until the mark <!-- test: Ctrl-C -->
    <!-- test: fails -->                  its exit code is not 0
    <!-- test: keys {"PROMPT": "KEY"} --> it has a terminal, and gets the key at each line that holds the prompt
"""
import collections
import contextlib
import glob
import json
import os
import pty
import re
import shutil
import signal
import subprocess
import time
import unittest

import rig_run
from rig_run import PACKAGE, wait_until

PAGES = sorted(glob.glob(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'doc', 'tutorials',
                                      '*.md')))
PATIENCE = 120  # s, for the commands of a block, and for what one that goes on has to print
SECONDS = 0.5   # s of input, after which a rig ends that would play all of its recording at its own speed
MARK = re.compile(r'<!-- (file|test): (.+) -->$')
CONTROL = re.compile(r'\x1b\[[0-9;]*m|\x1b\][^\x07]*\x07|\r')  # colours and titles of a terminal
# Of a shell that has sourced nothing yet.
SOURCED = ('CMAKE_PREFIX_PATH', 'ROS_PACKAGE_PATH', 'PYTHONPATH', 'LD_LIBRARY_PATH', 'PKG_CONFIG_PATH')

RIG = """#!/bin/sh
# scripts/rig, for no longer than a test needs.
case " $* " in
  *" duration:="* | *" loop:=true "* | *" lockstep:=true "* | *" hands:=none "*) ;;
  *) set -- "$@" duration:=%g ;;
esac
exec "$(dirname "$0")/rig_itself" "$@"
""" % SECONDS
ROSRUN = """#!/bin/sh
# rosrun passes over programs below build/, where those under test are.
[ "$1" = tactile_clay ] || exec "%s" "$@"
program="%s/$2"
shift 2
exec "$program" "$@"
""" % (shutil.which('rosrun'), os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay'))
BLOCK = """. "$STATE/variables"
cd "$(cat "$STATE/folder")"
set -e
%s
export -p > "$STATE/variables"
pwd > "$STATE/folder"
"""

Block = collections.namedtuple('Block', 'kind text what line')  # kind: sh, text, file, or Ctrl-C, which is a mark alone


def blocks(path):
    """The blocks of a page that mean something to a test, in their order."""
    found, mark, kind, lines, start = [], (None, ''), None, [], 0
    with open(path) as page:
        for number, line in enumerate(page.read().splitlines(), 1):
            told = MARK.match(line)
            if kind is None and told and told.group(2) == 'Ctrl-C':
                found.append(Block('Ctrl-C', '', '', number))
            elif kind is None and told:
                mark = told.groups()
            elif kind is None and line.startswith('```'):
                kind, lines, start = line[3:], [], number
            elif kind is not None and line == '```':
                kind = 'file' if mark[0] == 'file' else kind
                if kind in ('file', 'sh', 'text'):
                    found.append(Block(kind, '\n'.join(lines) + '\n', mark[1], start))
                mark, kind = (None, ''), None
            elif kind is not None:
                lines.append(line)
    return found


def not_told(words, expected):
    """The first line of `expected` that the words do not have behind the ones before it; None: they have all."""
    said = iter(CONTROL.sub('', words).splitlines())
    for line in filter(None, map(str.strip, expected.splitlines())):
        pattern = re.compile('.*'.join(map(re.escape, line.split('...'))) + '$')
        if not any(pattern.match(one.strip()) for one in said):
            return line
    return None


def write(path, text, mode=0o644):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, 'w') as file:
        file.write(text)
    os.chmod(path, mode)


class Started:
    """Commands of a block that were started; `words` is what they have printed so far."""

    def __init__(self, process, output):
        self.process, self.output = process, output

    def words(self):
        with open(self.output, errors='replace') as output:
            return output.read()


class User:
    """A user with a home folder, the checkout in it, and a master of nobody else."""

    def __init__(self, graph):
        self.graph, self.count = graph, 0
        self.home, self.state = (os.path.join(graph.folder, name) for name in ('home', 'state'))
        self.checkout = os.path.join(self.home, 'tactile_clay')
        rig = rig_run.rig_script(self.checkout)
        os.rename(rig, rig + '_itself')
        write(rig, RIG, 0o755)
        for name in ('config', 'test'):
            os.symlink(os.path.join(PACKAGE, name), os.path.join(self.checkout, name))
        programs = os.path.join(graph.folder, 'programs')
        write(os.path.join(programs, 'rosrun'), ROSRUN, 0o755)
        write(os.path.join(self.state, 'folder'), self.home)
        write(os.path.join(self.state, 'variables'), '')
        self.environment = {key: value for key, value in graph.environment.items() if key not in SOURCED}
        self.environment.update(HOME=self.home, STATE=self.state, PATH=programs + ':' + os.environ['PATH'],
                                ROSCONSOLE_STDOUT_LINE_BUFFERED='1')  # as at a terminal

    def folder(self):
        with open(os.path.join(self.state, 'folder')) as folder:
            return folder.read().strip()

    def start(self, commands, **streams):
        self.count += 1
        name = os.path.join(self.state, 'block_%d' % self.count)
        write(name, BLOCK % commands)
        with open(name + '.words', 'wb') as output:
            process = subprocess.Popen(['bash', name], env=self.environment, cwd=self.home, stdout=output,
                                       stderr=subprocess.STDOUT, start_new_session=True,
                                       stdin=streams.get('stdin', subprocess.DEVNULL))
        self.graph.processes.append(process)
        return Started(process, name + '.words')

    def run(self, commands):
        started = self.start(commands)
        started.process.wait(PATIENCE)
        return started

    def run_with_keys(self, commands, keys):
        """Commands at a terminal, which get a key for each line with its prompt."""
        ours, theirs = pty.openpty()
        try:
            started, pressed = self.start(commands, stdin=theirs), dict.fromkeys(keys, 0)
            deadline = time.monotonic() + PATIENCE
            while started.process.poll() is None and time.monotonic() < deadline:
                for prompt, key in keys.items():
                    if started.words().count(prompt) > pressed[prompt]:
                        pressed[prompt] += 1
                        os.write(ours, key.encode())
                time.sleep(0.05)
            started.process.wait(1)
        finally:
            os.close(ours)
            os.close(theirs)
        return started


class Tutorials(unittest.TestCase):
    def follow(self, name):
        """Follows a page. Returns what each of its blocks has printed, by the block's line."""
        path = next(page for page in PAGES if os.path.basename(page) == name)
        with rig_run.Graph() as graph:
            user, last, going, said = User(graph), None, None, {}
            for block in blocks(path):
                place = '%s:%d' % (name, block.line)
                if block.kind == 'file':
                    write(os.path.join(user.folder(), block.what), block.text)
                elif block.kind == 'Ctrl-C':
                    self.assertIsNotNone(going, place)
                    self.assertIn(graph.stop(going.process), (130, -signal.SIGINT), place + '\n' + going.words())
                    going = None
                elif block.kind == 'text':
                    self.expect(block, last, going, place)
                elif not block.what.startswith('not run'):
                    last = self.commands(user, block, place)
                    said[block.line] = last
                    going = last if block.what == 'goes on' else going
            self.assertIsNone(going, name + ': ends while commands go on, expected <!-- test: Ctrl-C -->')
            self.assertGreater(len(said), 1, name)
            return [one.words() for one in said.values()]

    def commands(self, user, block, place):
        kind, _, more = block.what.partition(' ')
        if block.what == 'goes on':
            return user.start(block.text)
        started = user.run_with_keys(block.text, json.loads(more)) if kind == 'keys' else user.run(block.text)
        self.assertIn(block.what if kind != 'keys' else '', ('', 'fails'), place + ': an unknown mark')
        self.assertEqual(started.process.returncode != 0, block.what == 'fails',
                         '%s: exit code %d\n%s' % (place, started.process.returncode, started.words()))
        return started

    def expect(self, block, last, going, place):
        self.assertIsNotNone(last, place)
        if last is going:
            with contextlib.suppress(AssertionError):  # what it says by then is told below
                wait_until(lambda: not_told(last.words(), block.text) is None or last.process.poll() is not None,
                           PATIENCE, place)
        self.assertIsNone(not_told(last.words(), block.text), '%s: the commands say\n%s' % (place, last.words()))

    def test_the_marks_of_a_page(self):
        self.assertIsNone(not_told('a\n\x1b[0mb c d\x1b[0m\ne\n', 'a\nb ... d\n'))
        self.assertEqual(not_told('a\nb\n', 'b\na\n'), 'a')
        self.assertEqual(len(PAGES), 7)

    def test_the_map_names_each_page(self):
        """doc/README.md has all pages below doc/."""
        folder = os.path.normpath(os.path.join(os.path.dirname(PAGES[0]), '..'))
        with open(os.path.join(folder, 'README.md')) as text:
            named = set(re.findall(r'\]\(([^)#\s]+)', text.read()))
        pages = {os.path.relpath(page, folder) for page in glob.glob(os.path.join(folder, '**', '*.md'),
                                                                     recursive=True)}
        self.assertEqual(pages - named, {'README.md'})

    def test_first_run(self):
        self.follow('first_run.md')

    def test_own_scene(self):
        self.follow('own_scene.md')

    def test_own_material(self):
        """The finger is pushed back harder by the firmer clay."""
        said = self.follow('own_material.md')
        forces = re.findall(r'right index +contact +[\d.]+ s, force +([\d.]+) N', '\n'.join(said))
        self.assertEqual(len(forces), 2, said)
        self.assertGreater(float(forces[0]), 1.5 * float(forces[1]))

    def test_own_hands(self):
        self.follow('own_hands.md')

    def test_own_array(self):
        self.follow('own_array.md')

    def test_trial(self):
        self.follow('trial.md')

    def test_plugin_package(self):
        self.follow('plugin_package.md')


if __name__ == '__main__':
    rig_run.main('tutorials')
