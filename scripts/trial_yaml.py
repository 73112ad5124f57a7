"""The YAML of a plan, with the lines of its keys, and what reads it key by key. A module of `trial`, no program."""
import itertools
import math
import re

import yaml

from rig_tools import Fault

NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_.-]*')  # of what becomes part of the name of a file
REQUIRED = object()
MOST_VALUES = 200000  # of a plan


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
