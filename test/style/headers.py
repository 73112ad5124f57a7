#!/usr/bin/env python3
"""Doxygen without warnings for every header of the package: headers.py [HEADER...].

Those that plugins of other packages include are among them. Doxygen works as the Doxyfile says, and writes nothing into
the tree.
"""
import glob
import os
import subprocess
import sys
import tempfile

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))


def main():
    headers = sys.argv[1:] or sorted(glob.glob(os.path.join(ROOT, 'src', '**', '*.h'), recursive=True))
    with open(os.path.join(ROOT, 'Doxyfile'), encoding='utf-8') as file:
        settings = file.read()
    with tempfile.TemporaryDirectory() as folder:
        settings += '\nINPUT = %s\nOUTPUT_DIRECTORY = "%s"\n' % (
            ' '.join('"%s"' % header for header in headers), folder)
        settings += 'WARN_AS_ERROR = FAIL_ON_WARNINGS\n'
        settings += 'GENERATE_HTML = NO\nGENERATE_XML = YES\n'  # comments are looked at only where something is written
        done = subprocess.run(['doxygen', '-'], cwd=ROOT, input=settings, text=True, check=False)
    return 1 if done.returncode else 0


if __name__ == '__main__':
    sys.exit(main())
