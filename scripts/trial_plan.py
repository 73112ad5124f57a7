"""The plan of a session of trials: reading it, and the order of its trials. A module of `trial`, no program."""
import itertools
import os
import random
import re
import subprocess

import roslib.packages
import yaml

from rig_tools import COMPRESSIONS, Fault, known_arguments, one_line, open_input
from trial_staircase import Staircase, read_staircase
from trial_yaml import Reader, is_number, load, text_of

OF_THE_SESSION = ('record', 'record_skin', 'record_compression', 'duration')  # arguments of the rig that `trial` gives


class Plan:
    """A plan, read and checked. `blocks`: maps with the plan's own values where a block has none."""

    def __init__(self, path, share):
        self.path, self.folder = path, os.path.dirname(os.path.abspath(path))
        try:
            with open_input(path, encoding='utf-8-sig') as file:
                self.text = file.read()
            content = load(self.text)
        except (OSError, UnicodeDecodeError) as error:
            words = getattr(error, 'strerror', None) or error
            raise Fault('%s: %s, expected the plan of a session' % (path, words)) from None
        except yaml.YAMLError as error:
            mark = getattr(error, 'problem_mark', None)
            raise Fault('%s%s: %s, expected YAML' % (path, ':%d' % (mark.line + 1) if mark else '',
                                                     one_line(getattr(error, 'problem', None) or error))) from None
        except RecursionError:
            raise Fault('%s: values are nested hundreds of levels deep, expected fewer' % path) from None
        self.arguments = [name for name in known_arguments(share) if name not in OF_THE_SESSION]
        reader = Reader(path, content)
        self.session, self.participant = reader.name('session'), reader.name('participant')
        where = os.path.expanduser(reader.text('folder', fallback='.'))
        self.session_folder = os.path.normpath(os.path.join(self.folder, where, self.session, self.participant))
        self.seed = reader.whole('seed', 0, 2**53, 1)
        bag = reader.inner('bag')
        self.skin = bag is None or bag.truth('skin', True)
        self.compression = bag.choice('compression', COMPRESSIONS, 'none') if bag else 'none'
        if bag:
            bag.finish()
        common = self.common(reader, dict(duration=None, instruction='', start='ask', ends='duration', answers=[]))
        rig = self.settings(reader.inner('rig'))
        maps = reader.items('blocks', 'a list of at least one block')
        reader.finish()
        self.blocks = [self.block(Reader(path, one, 'blocks[%d]' % k), common, rig) for k, one in enumerate(maps)]
        names = [block['name'] for block in self.blocks]
        for k, name in enumerate(names):
            if name in names[:k]:
                raise Fault("%s:%d: 'blocks[%d].name' is '%s', which another block has, too: expected another name" %
                            (path, maps[k].line, k, name))

    @staticmethod
    def common(reader, fallback):
        """What the plan says for all blocks, or a block for itself."""
        told = dict(duration=reader.number('duration', 0.1, 86400, fallback['duration']),
                    instruction=reader.text('instruction', fallback=fallback['instruction']),
                    start=reader.choice('start', ('ask', 'at_once'), fallback['start']),
                    ends=reader.choice('ends', ('duration', 'answer'), fallback['ends']),
                    answers=reader.items('answers', 'a list of answers', fallback['answers']))
        keys = [str(answer)[:1] for answer in told['answers']]
        if not all(isinstance(answer, str) and answer.strip() for answer in told['answers']) or \
                len(set(keys)) < len(keys):
            reader.fail('answers', "'%s' is %s, expected texts that begin with different letters, which are their "
                        "keys" % (reader.named('answers'), told['answers']))
        return told

    def settings(self, reader, names=()):
        """Arguments and parameters of the rig that a map of the plan gives."""
        if reader is None:
            return {}
        settings = {}
        for key in reader.content:
            if key in names:
                continue
            self.require_known(reader, key)
            settings[key] = reader.take(key, lambda value: isinstance(value, (str, bool)) or is_number(value),
                                        'a text, a number, true or false')
        return settings

    def require_known(self, reader, key, at=None):
        if key in OF_THE_SESSION:
            reader.fail(at or key, "'%s' is given by the session, expected it as %s" % (
                key, "'duration' of the plan or a block" if key == 'duration' else "'bag'"))
        if key not in self.arguments and not re.fullmatch(r'\w+(/\w+)+', key):
            reader.fail(at or key, "unknown key '%s', expected NODE/parameter or an argument of the rig: %s" %
                        (key, ', '.join(self.arguments)))

    def block(self, reader, common, rig):
        block = dict(name=reader.name('name'), practice=reader.whole('practice', 0, 1000, 0),
                     repetitions=reader.whole('repetitions', 1, 10000, 1),
                     order=reader.choice('order', ('random', 'listed'), 'random'))
        block.update(self.common(reader, common))
        rig = dict(rig, **self.settings(reader.inner('rig')))
        if block['duration'] is None:
            reader.fail('duration', "'%s' is missing, expected the duration of a trial in s, here or for the whole "
                        "plan" % reader.named('duration'))
        block['conditions'] = self.conditions(reader, rig)
        rule = block['staircase'] = read_staircase(reader.inner('staircase'), block['answers'])
        reader.finish()
        if rule:
            inner = Reader(reader.file, reader.content['staircase'], reader.named('staircase'))
            self.require_known(inner, rule['key'], 'key')
            if 'repetitions' in reader.content:
                reader.fail('repetitions', "'%s' and a staircase are given, expected one of them: 'reversals' and "
                            "'trials' end a staircase" % reader.named('repetitions'))
        if block['ends'] == 'answer' and not block['answers']:
            reader.fail('ends', "'%s' is answer, but there are no 'answers': expected some" % reader.named('ends'))
        return block

    def conditions(self, reader, rig):
        """[{name, instruction, own: what tells it from others, settings: of the rig, line}]"""
        listed = reader.items('conditions', 'a list of conditions', None)
        factors = reader.inner('factors')
        if listed and factors:
            reader.fail('factors', "'%s' and 'conditions' are given, expected one of them" % reader.named('factors'))
        made = []
        if factors:
            for key in factors.content:
                self.require_known(factors, key)
                factors.items(key, 'a list of values')
            for values in itertools.product(*factors.content.values()):
                own = dict(zip(factors.content, values))
                name = '_'.join(re.sub(r'[^A-Za-z0-9.-]+', '-', text_of(value)).strip('-.') or 'x' for value in values)
                made.append(dict(name=name, instruction=None, own=own, line=factors.content.line))
        for k, one in enumerate(listed or ([] if factors else [None])):
            if one is None:
                made.append(dict(name='all', instruction=None, own={}, line=reader.content.line))
                continue
            inner = Reader(reader.file, one, '%s[%d]' % (reader.named('conditions'), k))
            made.append(dict(name=inner.name('name', 'c%d' % (k + 1)),
                             instruction=inner.text('instruction', fallback=None),
                             own=self.settings(inner, ('name', 'instruction')), line=one.line))
        names = [one['name'] for one in made]
        for k, one in enumerate(made):
            if one['name'] in names[:k]:
                raise Fault("%s:%d: two conditions of block '%s' are both called '%s', expected different names" %
                            (reader.file, one['line'], reader.content.get('name'), one['name']))
            one['settings'] = dict(rig, **one['own'])
        return made

    def keys(self):
        """Settings in which conditions differ: columns of the table of trials."""
        found = {}
        for block in self.blocks:
            for condition in block['conditions']:
                found.update(dict.fromkeys(condition['own']))
            if block['staircase']:
                found[block['staircase']['key']] = None
        return list(found)

    def check_rig(self, environment):
        """Asks preflight about every condition. Raises Fault with its line."""
        found = roslib.packages.find_node('tactile_clay', 'preflight')
        if not found:
            raise Fault('the programs of tactile_clay are not built or not installed here')
        asked = set()
        for block in self.blocks:
            rule = block['staircase']
            for condition in block['conditions']:
                for value in [rule[at] for at in ('start', 'low', 'high')] if rule else [None]:
                    settings = dict(condition['settings'], **({rule['key']: value} if rule else {}))
                    words = tuple('%s:=%s' % (key, text_of(one)) for key, one in sorted(settings.items()))
                    if words in asked:
                        continue
                    asked.add(words)
                    done = subprocess.run([found[0], *words], cwd=self.folder, env=environment,
                                          stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                          text=True,
                                          timeout=60, errors='replace', check=False)
                    if done.returncode != 0:
                        lines = [line for line in done.stderr.splitlines() if line.startswith('tactile_clay: ')]
                        raise Fault("%s:%d: block '%s', condition '%s': %s" % (
                            self.path, condition['line'], block['name'], condition['name'],
                            one_line((lines or [done.stderr])[-1].replace('tactile_clay: ', '', 1))))

    def order(self):
        """The trials that are known beforehand: a list of them for each block."""
        order = {}
        for block in self.blocks:
            chance = random.Random('%d %s' % (self.seed, block['name']))
            listed = [condition['name'] for condition in block['conditions']]

            def round_of_all():
                return chance.sample(listed, len(listed)) if block['order'] == 'random' else list(listed)
            practice = []
            while len(practice) < block['practice']:
                practice += round_of_all()
            trials = [dict(condition=name, practice=True, repetition=0) for name in practice[:block['practice']]]
            if not block['staircase']:
                for repetition in range(1, block['repetitions'] + 1):
                    trials += [dict(condition=name, practice=False, repetition=repetition) for name in round_of_all()]
            order[block['name']] = trials
        return order

    def max_trials(self):
        """(number of trials, whether staircases may need fewer)"""
        count = sum(map(len, self.order().values()))
        stairs = sum(block['staircase']['trials'] * len(block['conditions']) for block in self.blocks
                     if block['staircase'])
        return count + stairs, stairs > 0

    def staircases(self, block, rows):
        """The staircase of each condition of a block, after what was answered."""
        stairs = {condition['name']: Staircase(block['staircase']) for condition in block['conditions']}
        for row in rows:
            if row['block'] == block['name'] and row['practice'] == 'no':
                stairs[row['condition']].take(row['answer'] == block['staircase']['detected'])
        return stairs

    def next_trial(self, order, rows):
        """The trial after these rows of the table: a map, or None at the end. It depends on nothing else."""
        for block in self.blocks:
            done = [row for row in rows if row['block'] == block['name']]
            fixed = order[block['name']]
            if len(done) < len(fixed):
                trial = dict(fixed[len(done)], value=block['staircase']['start'] if block['staircase'] else None)
            elif block['staircase']:
                stairs = self.staircases(block, rows)
                going = [name for name, one in stairs.items() if not one.done()]
                if not going:
                    continue
                name = random.Random('%d %s %d' % (self.seed, block['name'], len(done))).choice(going)
                trial = dict(condition=name, practice=False, repetition=stairs[name].count + 1,
                             value=stairs[name].value)
            else:
                continue
            condition = next(one for one in block['conditions'] if one['name'] == trial['condition'])
            settings = dict(condition['settings'])
            if block['staircase']:
                settings[block['staircase']['key']] = trial['value']
            instruction = block['instruction'] if condition['instruction'] is None else condition['instruction']
            return dict(trial, number=len(rows) + 1, block=block, settings=settings, instruction=instruction)
        return None
