#!/usr/bin/env python3
"""Runs shellcheck over every shell script of the tree: shell.py. None may have a finding.

A line that is right as it is says so: `# shellcheck disable=SC1234  # the reason`.
"""
import os
import re
import subprocess
import sys

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
SHELL = re.compile(r'#!.*\b(sh|bash|dash)\s*$')


def scripts():
    """Their relative names: files whose first line names a shell, and those named .sh."""
    found = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = sorted(name for name in folders if name not in ('.git', 'build', 'devel'))
        for name in sorted(names):
            path = os.path.join(folder, name)
            if os.path.islink(path) or not os.path.isfile(path):
                continue
            with open(path, 'rb') as file:
                first = file.readline(200).decode(errors='replace')
            if name.endswith('.sh') or SHELL.match(first):
                found.append(os.path.relpath(path, ROOT))
    return found


def reasonless(name):
    """Lines that switch a finding off and do not say why."""
    with open(os.path.join(ROOT, name), encoding='utf-8') as file:
        return ['%s:%d: expected the reason behind it, as in "disable=SC1234  # the reason"' % (name, number)
                for number, line in enumerate(file, 1) if re.match(r'\s*# shellcheck disable=[\w,]+\s*$', line)]


def main():
    names = scripts()
    if not names:
        print('shell.py: no shell script in %s, expected some' % ROOT)
        return 1
    wrong = [line for name in names for line in reasonless(name)]
    print('\n'.join(wrong))
    # A file that has no first line with a shell is one for any of them.
    with_shell = [name for name in names if not name.endswith('.sh')]
    without = [name for name in names if name.endswith('.sh')]
    code = subprocess.run(['shellcheck', '-x'] + with_shell, cwd=ROOT, check=False).returncode
    if without:
        code |= subprocess.run(['shellcheck', '-x', '-s', 'sh'] + without, cwd=ROOT, check=False).returncode
    return 1 if code or wrong else 0


if __name__ == '__main__':
    sys.exit(main())
