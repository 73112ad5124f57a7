#!/usr/bin/env python3
"""No file over 300 lines, no function over 60, no function, call or macro with more than 7 parameters or arguments, no
line over 120 characters: sizes.py [--all] [FOLDER].

Looks at all C++ below FOLDER/src and FOLDER/test; at the lines of C++, Python, shell and CMake below src, test, scripts
and cmake. A test of GoogleTest is a function with the name SUITE.NAME. Of Python below test and scripts, at the lines
of each file. What is built with braces, `Config{a, b, c}`, is no call. The C++ must be as clang-format leaves it.
FOLDER: of the checkout, without it that of this file. What is larger and meant to be is listed with its reason in
exceptions.txt beside this file. An exception that nothing needs any more is an error, too.
--all prints the ten largest of each kind as well.
"""
import argparse
import os
import re
import sys

LIMITS = {'lines of a file': 300, 'lines of a function': 60, 'parameters or arguments': 7, 'characters of a line': 120}
CPP = ('.cpp', '.h', '.hpp')
HERE = os.path.dirname(os.path.abspath(__file__))
WORDS_OF_NO_FUNCTION = ('if', 'for', 'while', 'switch', 'catch', 'return', 'namespace', 'struct', 'class', 'enum',
                        'union')


def blanked(text):
    """The text with comments, strings and directives replaced by spaces; line breaks stay."""
    token = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\''
                       r'|^[ ]*#(?:\\\n|[^\n])*',
                       re.DOTALL | re.MULTILINE)

    def blank(found):
        before = text[found.start() - 1:found.start()]
        if found.group().startswith("'") and before.isalnum():  # a digit separator, such as 1'000
            return found.group()
        return re.sub(r'[^\n]', ' ', found.group())
    return token.sub(blank, text)


def closing(text, start):
    """Index of the bracket that closes the one at `start`, whatever its kind."""
    depth = 0
    for at in range(start, len(text)):
        if text[at] in '([{':
            depth += 1
        elif text[at] in ')]}':
            depth -= 1
            if depth == 0:
                return at
    return len(text) - 1


def arguments(inside):
    """How many arguments or parameters stand between these parentheses. Commas within brackets or templates separate
    none. clang-format writes comparisons with spaces, `a < b`, and templates without, `map<A, B>`."""
    depth = count = 0
    for mark in re.findall(r'[(\[{)\]},]|(?<=\w)<(?![<=])|(?<=[^-\s])>(?!=)', inside):
        depth += (mark in '([{<') - (mark in ')]}>')
        count += mark == ',' and depth == 0
    return count + 1 if inside.strip() else 0


def calls(text):
    """(name, line, arguments) of whatever has arguments or parameters: calls, macros, declarations, definitions."""
    text = blanked(text)
    for match in re.finditer(r'(operator\s*\S{1,3}?|[\w:~]+|[>)\]])\s*\(', text):
        end = closing(text, match.end() - 1)
        name = match.group(1) if re.search(r'\w', match.group(1)) else 'call'
        yield name, text.count('\n', 0, match.start()) + 1, arguments(text[match.end():end])


def body_of(text, after):
    """Index of the brace that opens a function's body, given the end of its parameters; None for a declaration."""
    initialisers = False
    while after < len(text):
        character = text[after]
        if character == '{':
            # In a list of initialisers, `name_{value}` is no body: what stands before the brace is a name.
            if initialisers and re.search(r'[\w>]\s*$', text[:after]):
                after = closing(text, after)
            else:
                return after
        elif character == '(':
            after = closing(text, after)
        elif character == ':' and text[after:after + 2] != '::' and text[after - 1] != ':':
            initialisers = True
        elif character in ';}' or (character in '=,)' and not initialisers):
            return None
        after += 1
    return None


def functions(text):
    """(name, first line, lines) of each function with a body. Functions within functions count there."""
    text = blanked(text)
    found = []
    head = re.compile(r'([\w:~]+|operator\s*\S{1,3})\s*\(')
    at = 0
    while True:
        match = head.search(text, at)
        if not match:
            return found
        at = match.end()
        name = match.group(1)
        end = closing(text, match.end() - 1)
        body = None if name.split('::')[-1] in WORDS_OF_NO_FUNCTION else body_of(text, end + 1)
        if body is None:
            continue
        if name in ('TEST', 'TEST_F', 'TEST_P'):
            name = '.'.join(word.strip() for word in text[match.end():end].split(','))
        last = closing(text, body)
        begin = text.rfind('\n', 0, match.start()) + 1
        found.append((name, text.count('\n', 0, begin) + 1, text.count('\n', begin, last) + 1))
        at = last


def code(root):
    """Names of all files of code, from root."""
    for room in ('src', 'test', 'scripts', 'cmake'):
        for folder, _, names in sorted(os.walk(os.path.join(root, room))):
            for name in sorted(names):
                if name.endswith((*CPP, '.py', '.cmake', '.sh')) or name == 'CMakeLists.txt' or \
                        (room == 'scripts' and '.' not in name):
                    yield os.path.relpath(os.path.join(folder, name), root)


def measured(root):
    """(kind, name of what it is of, size, where): the longest line of each file; all else of C++ in src and test."""
    for path in code(root):
        with open(os.path.join(root, path), encoding='utf-8') as file:
            text = file.read()
        length, line = max((len(characters), k) for k, characters in enumerate(text.split('\n'), 1))
        yield 'characters of a line', path, length, '%s:%d' % (path, line)
        if not path.startswith(('src' + os.sep, 'test' + os.sep)) or not path.endswith(CPP):
            continue
        yield 'lines of a file', path, text.count('\n'), path
        for kind, sizes in (('lines of a function', functions(text)), ('parameters or arguments', calls(text))):
            for name, line, size in sizes:
                yield kind, '%s %s' % (path, name), size, '%s:%d: %s' % (path, line, name)


def measured_python(root):
    """As `measured`: the lines of each file of Python below test and scripts."""
    for path in code(root):
        if path.startswith(('test' + os.sep, 'scripts' + os.sep)):
            with open(os.path.join(root, path), encoding='utf-8') as file:
                text = file.read()
            if path.endswith('.py') or re.match(r'#!.*python', text):
                yield 'lines of a file', path, text.count('\n'), path


def exceptions():
    """Reason by key: `PATH`, `PATH NAME` or `FOLDER/`."""
    reasons = {}
    with open(os.path.join(HERE, 'exceptions.txt'), encoding='utf-8') as lines:
        for line in lines:
            if line.strip() and not line.startswith('#'):
                key, reason = line.split(': ', 1)
                reasons[key.strip()] = reason.strip()
    return reasons


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--all', action='store_true')
    parser.add_argument('folder', nargs='?', default=os.path.join(HERE, '..', '..'))
    options = parser.parse_args()
    reasons = exceptions()
    sizes = list(measured(options.folder)) + list(measured_python(options.folder))
    if options.all:
        for kind in LIMITS:
            print('largest ' + kind)
            for _, _, size, where in sorted((s for s in sizes if s[0] == kind), key=lambda s: -s[2])[:10]:
                print('  %4d  %s' % (size, where))
    needed, wrong = set(), 0
    for kind, key, size, where in sizes:
        if size <= LIMITS[kind]:
            continue
        excuse = next((e for e in reasons if e == key or (e.endswith('/') and key.startswith(e))), None)
        if excuse:
            needed.add(excuse)
        else:
            print('%s: %d %s, expected at most %d' % (where, size, kind, LIMITS[kind]))
            wrong += 1
    for excuse in sorted(set(reasons) - needed):
        print('exceptions.txt: %s: nothing there is too large, expected no such exception' % excuse)
        wrong += 1
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
