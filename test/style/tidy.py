#!/usr/bin/env python3
"""Runs clang-tidy with the checks of .clang-tidy: tidy.py [--all] [--jobs N] BUILD_FOLDER [FILE...].

Without files those that are cheap, and those that keep people safe: files of src that include none of Eigen, ROS,
Boost, Ogre and Qt, and the safety gate with all that it stands on. They take some 90 s on two cores. --all: every file
of src, some 20 minutes.
The build folder has been built (its compile commands, and what each file includes, are read). Exits with 1 if anything
was found. What is right as it is says so: `// NOLINT(check): the reason`.
"""
import argparse
import concurrent.futures
import glob
import json
import os
import re
import subprocess
import sys

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
SAFETY = ('src/device/instrument.cpp', 'src/device/safety_gate.cpp', 'src/device/safety_limits.cpp',
          'src/device/sonic_surface.cpp', 'src/device/sonic_surface_protocol.cpp')
COSTLY = re.compile(r'/Eigen/|/ros/|/boost/|/OGRE/|/qt5/')


def all_files(build):
    """Source files of src that are compiled there, by their names in the tree."""
    with open(os.path.join(build, 'compile_commands.json'), encoding='utf-8') as file:
        names = {os.path.relpath(os.path.realpath(command['file']), ROOT) for command in json.load(file)}
    return sorted(name for name in names if name.startswith('src/'))


def cheap_files(build):
    cheap = set()
    for path in glob.glob(os.path.join(build, 'src', '**', '*.d'), recursive=True):
        with open(path, encoding='utf-8') as file:
            text = file.read()
        source = re.search(r'\bsrc/\S+\.cpp(?=\s)', text.split(':', 1)[-1])
        if source and not COSTLY.search(text):
            cheap.add(source.group())
    return cheap


def check(build, name):
    done = subprocess.run(['clang-tidy', '-p', build, '--quiet', os.path.join(ROOT, name)], check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode == 0:
        return ''
    return done.stdout or done.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--all', action='store_true')
    parser.add_argument('--jobs', type=int, default=int(os.environ.get('TACTILE_CLAY_JOBS', os.cpu_count())))
    parser.add_argument('build')
    parser.add_argument('files', nargs='*')
    options = parser.parse_args()
    known = all_files(options.build)
    files = options.files or known
    if not options.files and not options.all:
        cheap = cheap_files(options.build) | set(SAFETY)
        files = [name for name in known if name in cheap]
    if not set(SAFETY) <= set(known) or not files:
        print('tidy.py: %s: expected a folder in which all of src was built' % options.build)
        return 1
    found = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for name, lines in zip(files, pool.map(lambda name: check(options.build, name), files)):
            if lines:
                print('%s:\n%s' % (name, lines))
                found += 1
    print('clang-tidy: %d files, %d with findings' % (len(files), found))
    return 1 if found else 0


if __name__ == '__main__':
    sys.exit(main())
