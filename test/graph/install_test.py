#!/usr/bin/env python3
"""What an install writes, what catkin_lint says, what programs say of themselves, and where documents lead to:
install_test.py BUILD_FOLDER
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import unittest

SOURCE = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
BUILD = os.path.abspath(sys.argv.pop())
PROGRAMS = os.path.join(BUILD, 'devel', 'lib', 'tactile_clay')


class Install(unittest.TestCase):
    def test_nothing_goes_elsewhere_than_into_the_prefix(self):
        """CMake lists what has an absolute destination, which `cmake --install --prefix` does not move."""
        scripts = glob.glob(os.path.join(BUILD, '**', 'cmake_install.cmake'), recursive=True)
        self.assertGreater(len(scripts), 5)
        installed = ''
        for path in scripts:
            with open(path) as script:
                text = script.read()
            self.assertFalse('CMAKE_ABSOLUTE_DESTINATION_FILES' in text, path)
            installed += text
        for name in ('setup.bash', '_setup_util.py', 'hand_tracking', 'replay', 'rig_view'):
            self.assertIn('/%s"' % name, installed)

    def test_catkin_lint(self):
        if shutil.which('catkin_lint') is None:
            self.skipTest('no catkin_lint')
        done = subprocess.run(['catkin_lint', '-q', SOURCE], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=100, check=False)
        self.assertEqual([line for line in done.stdout.splitlines() if ' error: ' in line], [])
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_each_script_tells_what_it_is(self):
        with open(os.path.join(SOURCE, 'cmake', 'ros.cmake')) as text:
            listed = text.read().split('catkin_install_python(PROGRAMS', 1)[1].split('DESTINATION')[0].split()
        self.assertGreater(len(listed), 5)
        for script in listed:
            with self.subTest(script):
                done = subprocess.run([sys.executable, os.path.join(SOURCE, script), '--help'], stdin=subprocess.DEVNULL,
                                      capture_output=True, text=True, timeout=30, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ''))
                self.assertGreater(len(done.stdout), 40)
                # Else rosrun finds it twice, here and in the development space, and asks which one is meant.
                self.assertFalse(os.access(os.path.join(SOURCE, script), os.X_OK), 'is executable')
                self.assertTrue(os.access(os.path.join(PROGRAMS, os.path.basename(script)), os.X_OK))

    def test_each_tool_tells_what_it_is(self):
        tools = []
        for path in sorted(glob.glob(os.path.join(SOURCE, 'src', 'tools', '*.cpp'))):
            with open(path) as text:
                tools += [os.path.splitext(os.path.basename(path))[0]] if 'int main(' in text.read() else []
        self.assertGreater(len(tools), 10)
        for tool in tools:
            with self.subTest(tool):
                done = subprocess.run([os.path.join(PROGRAMS, tool), '--help'], stdin=subprocess.DEVNULL, capture_output=True,
                                      text=True, timeout=30, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ''))
                self.assertIn(tool, done.stdout)
                self.assertGreater(len(done.stdout), 80)


def headings(page):
    """Anchors of the headings of a page, as GitHub makes them."""
    with open(page) as text:
        lines = re.findall(r'^#+ (.+)$', re.sub(r'(?ms)^```.*?^```$', '', text.read()), re.MULTILINE)
    return [re.sub(r'[^\w\- ]', '', re.sub(r'\[(.*?)\]\(.*?\)', r'\1', line).lower()).replace(' ', '-') for line in lines]


class Documents(unittest.TestCase):
    def setUp(self):
        self.pages = [os.path.join(SOURCE, name) for name in ('README.md', 'CONTRIBUTING.md')]
        self.pages += sorted(glob.glob(os.path.join(SOURCE, 'doc', '**', '*.md'), recursive=True))
        self.assertGreater(len(self.pages), 10)

    def test_links_lead_to_files_and_headings(self):
        for page in self.pages:
            with open(page) as text:
                links = re.findall(r'\]\(([^)\s]+)\)', re.sub(r'(?ms)^```.*?^```$', '', text.read()))
            for link in (link for link in links if '://' not in link):
                with self.subTest(page=os.path.relpath(page, SOURCE), link=link):
                    path, _, anchor = link.partition('#')
                    file = os.path.join(os.path.dirname(page), path) if path else page
                    self.assertTrue(os.path.exists(file), 'no such file')
                    if anchor:
                        self.assertIn(anchor, headings(file))

    def test_lines_are_short(self):
        for page in self.pages:
            with open(page) as text:
                long = [number for number, line in enumerate(text.read().splitlines(), 1) if len(line) > 120]
            self.assertEqual(long, [], os.path.relpath(page, SOURCE))

    def test_the_map_names_each_page(self):
        with open(os.path.join(SOURCE, 'doc', 'README.md')) as text:
            named = set(re.findall(r'\]\(([^)#\s]+)', text.read()))
        for page in self.pages[2:]:
            name = os.path.relpath(page, os.path.join(SOURCE, 'doc'))
            self.assertTrue(name == 'README.md' or name in named, name + ' is not in doc/README.md')


if __name__ == '__main__':
    unittest.main()
