"""The plan of a session of trials: reading it, the order of its trials, staircases. A module of `trial`, no program."""
import itertools
import math
import os
import random
import re
import statistics
import subprocess

import roslib.packages
import yaml

from rig_tools import COMPRESSIONS, Fault, known_arguments, one_line, open_input

NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_.-]*')  # of what becomes part of the name of a file
OF_THE_SESSION = ('record', 'record_skin', 'record_compression', 'duration')  # arguments of the rig that `trial` gives
REQUIRED = object()
MOST_VALUES = 200000  # of a plan


# YAML, with the lines of its keys

class Map(dict):
    """A map of a plan. `line`: where it begins; `lines`: of each key."""


class Loader(yaml.SafeLoader):
    """As YAML 1.2 has it: `yes` and `no` are texts, 3e5 is a number. A key that comes twice is an error."""

    def map(self, node):
        made = Map()
        made.line, made.lines = node.start_mark.line + 1, {}
        for key_node, value_node in node.value:
            key = self.construct_object(key_node)
            if not isinstance(key, str):
                raise yaml.MarkedYAMLError(None, None, "the key '%s' is no text" % (key,), key_node.start_mark)
            if key in made:
                raise yaml.MarkedYAMLError(None, None, "the key '%s' comes twice" % key, key_node.start_mark)
            made[key] = self.construct_object(value_node, deep=True)
            made.lines[key] = key_node.start_mark.line + 1
        return made


Loader.yaml_implicit_resolvers = {
    first: [one for one in known if one[0] not in ('tag:yaml.org,2002:bool', 'tag:yaml.org,2002:float',
                                                   'tag:yaml.org,2002:timestamp', 'tag:yaml.org,2002:int')]
    for first, known in yaml.SafeLoader.yaml_implicit_resolvers.items()}
Loader.add_implicit_resolver('tag:yaml.org,2002:bool', re.compile(r'^(true|false)$'), list('tf'))
Loader.add_implicit_resolver('tag:yaml.org,2002:int', re.compile(r'^[-+]?(0|[1-9][0-9]*)$'), list('-+0123456789'))
Loader.add_implicit_resolver('tag:yaml.org,2002:float', re.compile(
    r'^[-+]?(([0-9]+\.[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?|[0-9]+[eE][-+]?[0-9]+)$'), list('-+.0123456789'))
Loader.add_constructor('tag:yaml.org,2002:map', Loader.map)
Loader.add_constructor('tag:yaml.org,2002:float', lambda loader, node: float(node.value))


def load(text):
    """Content of YAML text. Raises yaml.YAMLError, and RecursionError where it is very deep."""
    loader = Loader(text)
    try:
        node = loader.get_single_node()
        if values_of(node, {}) > MOST_VALUES:
            raise yaml.MarkedYAMLError(None, None, 'more than %d values, aliases among them' % MOST_VALUES,
                                       node.start_mark)
        return loader.construct_document(node) if node else None
    finally:
        loader.dispose()


def values_of(node, known):
    """How many values a node stands for with all that its aliases repeat. known: those of other nodes, by id."""
    if id(node) not in known:
        known[id(node)] = math.inf  # in itself
        value = getattr(node, 'value', None)
        parts = itertools.chain(*value) if isinstance(node, yaml.MappingNode) else \
            value if isinstance(node, yaml.SequenceNode) else ()
        known[id(node)] = 1 + sum(values_of(part, known) for part in parts)
    return known[id(node)]


class Reader:
    """Reads a map of the plan key by key. What is wrong is a Fault with file, line, key and what was expected."""

    def __init__(self, file, content, path=''):
        self.file, self.content, self.path, self.known = file, content, path, []
        if not isinstance(content, Map):
            raise Fault("%s: '%s' is %r, expected a map of keys and values" % (file, path or 'the plan', content))

    def named(self, key):
        return self.path + '.' + key if self.path else key

    def fail(self, key, expected):
        line = self.content.lines.get(key, self.content.line)
        raise Fault('%s:%d: %s' % (self.file, line, expected))

    def take(self, key, fits, expected, fallback=REQUIRED):
        """The value of a key, which fits(value) must like."""
        self.known.append(key)
        if key not in self.content:
            if fallback is REQUIRED:
                self.fail(key, "'%s' is missing, expected %s" % (self.named(key), expected))
            return fallback
        value = self.content[key]
        if not fits(value):
            self.fail(key, "'%s' is %s, expected %s" % (self.named(key), yaml_of(value), expected))
        return value

    def text(self, key, expected='a text', fallback=REQUIRED):
        return self.take(key, lambda value: isinstance(value, str), expected, fallback)

    def name(self, key, fallback=REQUIRED):
        return str(self.take(key, lambda value: isinstance(value, (str, int)) and NAME.fullmatch(str(value)),
                             'a name of letters, digits, _, . and -', fallback))

    def whole(self, key, low, high, fallback=REQUIRED):
        return self.take(key, lambda value: type(value) is int and low <= value <= high,
                         'a whole number from %d to %d' % (low, high), fallback)

    def number(self, key, low, high, fallback=REQUIRED):
        return self.take(key, lambda value: is_number(value) and low <= value <= high,
                         'a number from %g to %g' % (low, high), fallback)

    def choice(self, key, choices, fallback):
        return self.take(key, lambda value: value in choices, 'one of ' + ', '.join(choices), fallback)

    def truth(self, key, fallback):
        return self.take(key, lambda value: isinstance(value, bool), 'true or false', fallback)

    def items(self, key, expected, fallback=REQUIRED):
        return self.take(key, lambda value: isinstance(value, list) and value, expected, fallback)

    def inner(self, key):
        """A Reader of the map of a key; None where there is none."""
        self.known.append(key)
        if key not in self.content:
            return None
        if not isinstance(self.content[key], Map):
            self.fail(key, "'%s' is %s, expected a map of keys and values" %
                      (self.named(key), yaml_of(self.content[key])))
        return Reader(self.file, self.content[key], self.named(key))

    def finish(self):
        for key in self.content:
            if key not in self.known:
                known = ', '.join(sorted(self.known))
                self.fail(key, "unknown key '%s', expected one of %s" % (self.named(key), known))


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def yaml_of(value):
    return repr(value) if not isinstance(value, bool) else str(value).lower()


def text_of(value):
    """A value as roslaunch and rosparam take it: 1e-07 would be a text."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        digits, letter, exponent = repr(value).partition('e')
        return digits + ('' if '.' in digits else '.0') + letter + exponent
    return str(value)


# Staircases

class Staircase:
    """Goes to where a trial is detected with a certain probability: `down` detections in a row make the next one
    harder, `up` misses in a row easier (Levitt 1971, doi 10.1121/1.1912375). 1 up and 2 down end at 70.7 %."""

    def __init__(self, rule):
        self.rule, self.value = rule, rule['start']
        self.count, self.hits, self.misses, self.way = 0, 0, 0, 0
        self.reversals = []  # values at which it turned

    def take(self, detected):
        self.count += 1
        self.hits, self.misses = (self.hits + 1, 0) if detected else (0, self.misses + 1)
        if self.hits >= self.rule['down']:
            self.move(-1)
        elif self.misses >= self.rule['up']:
            self.move(1)

    def move(self, way):
        self.hits = self.misses = 0
        if self.way not in (0, way):
            self.reversals.append(self.value)
        self.way = way
        step = self.rule['steps'][min(len(self.reversals), len(self.rule['steps']) - 1)]
        way *= 1 if self.rule['harder'] == 'down' else -1
        value = self.value * step ** way if self.rule['scale'] == 'log' else self.value + way * step
        self.value = min(max(value, self.rule['low']), self.rule['high'])

    def done(self):
        return len(self.reversals) >= self.rule['reversals'] or self.count >= self.rule['trials']

    def threshold(self):
        """Mean of the values at which it turned with its smallest step, geometric on a log scale. None before."""
        turned = self.reversals[len(self.rule['steps']) - 1:]
        turned = turned[len(turned) % 2:]  # as many upper ones as lower ones
        if not turned:
            return None
        if self.rule['scale'] == 'log':
            return math.exp(statistics.fmean(map(math.log, turned)))
        return statistics.fmean(turned)


def read_staircase(reader, answers):
    if reader is None:
        return None
    rule = dict(key=reader.text('key', 'an argument of the rig, or NODE/parameter'),
                start=reader.number('start', -math.inf, math.inf), low=reader.number('low', -math.inf, math.inf),
                high=reader.number('high', -math.inf, math.inf), down=reader.whole('down', 1, 20, 2),
                up=reader.whole('up', 1, 20, 1), harder=reader.choice('harder', ('down', 'up'), 'down'),
                scale=reader.choice('scale', ('linear', 'log'), 'linear'),
                reversals=reader.whole('reversals', 2, 1000, 8), trials=reader.whole('trials', 1, 10000, 100),
                detected=reader.text('detected', "one of 'answers', which counts as detected"),
                steps=reader.items('steps', 'a list of steps, the first until the first reversal and so on'))
    reader.finish()
    least = 1.0 if rule['scale'] == 'log' else 0.0
    if not all(is_number(step) and step > least for step in rule['steps']):
        reader.fail('steps', "'%s' is %s, expected numbers above %g" % (reader.named('steps'), rule['steps'], least))
    if not rule['low'] <= rule['start'] <= rule['high']:
        reader.fail('start', "'%s' is %g, expected it from 'low' %g to 'high' %g" %
                    (reader.named('start'), rule['start'], rule['low'], rule['high']))
    if rule['scale'] == 'log' and rule['low'] <= 0:
        reader.fail('low', "'%s' is %g, expected it above 0 on a log scale" % (reader.named('low'), rule['low']))
    if rule['detected'] not in answers:
        reader.fail('detected', "'%s' is '%s', expected one of 'answers': %s" %
                    (reader.named('detected'), rule['detected'], ', '.join(answers) or 'there are none'))
    if rule['reversals'] < len(rule['steps']) + 1:
        reader.fail('reversals', "'%s' is %d, expected at least %d: two more than there are larger steps" %
                    (reader.named('reversals'), rule['reversals'], len(rule['steps']) + 1))
    return rule


# The plan

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
