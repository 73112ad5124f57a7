#!/usr/bin/env python3
"""The pages of the tree: links and anchors, length of lines, whom each page is for. Needs no ROS and no build."""
import os
import re
import subprocess
import unittest
import urllib.parse

SOURCE = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
LONGEST = 120  # characters of a line
FENCE = re.compile(r'^\s*(```|~~~)')
LINK = re.compile(r'!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^()\s]+)(?:\s+"[^"]*")?\)')
TAG = re.compile(r'\b(?:src|href)="([^"]+)"')
CODE = re.compile(r'`+[^`]*`+')
ADDRESS = re.compile(r'^\s*(?:[-*]\s+)?<?https?://\S+>?\s*$')
NAMED_PAGE = re.compile(r'(?<![\w/.-])doc/[A-Za-z0-9_/.-]+?\.md\b')


def tracked_files():
    """Files of the tree, those that git does not know yet too, by their relative names."""
    done = subprocess.run(['git', '-C', SOURCE, 'ls-files', '--cached', '--others', '--exclude-standard'], check=False,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    names = done.stdout.splitlines()
    if not names:  # an export without git
        for folder, folders, files in os.walk(SOURCE):
            folders[:] = [name for name in folders if not name.startswith(('.', 'build'))]
            names += [os.path.relpath(os.path.join(folder, name), SOURCE) for name in files]
    return sorted(name for name in names if os.path.isfile(os.path.join(SOURCE, name)))


def lines_of(name):
    with open(os.path.join(SOURCE, name), encoding='utf-8') as file:
        return file.read().splitlines()


def prose(lines):
    """(number, line) of the lines outside fenced code."""
    fenced = False
    for number, line in enumerate(lines, 1):
        if FENCE.match(line):
            fenced = not fenced
        elif not fenced:
            yield number, line


def slug(heading):
    """The anchor that GitHub gives a heading."""
    text = re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', heading).replace('`', '')
    return re.sub(r'[^\w\- ]', '', text.strip().lower()).replace(' ', '-')


def anchors(lines):
    found, count = set(), {}
    for _, line in prose(lines):
        heading = re.match(r'#{1,6}\s+(.*?)\s*#*$', line)
        if heading:
            name = slug(heading.group(1))
            found.add(name if name not in count else '%s-%d' % (name, count[name]))
            count[name] = count.get(name, 0) + 1
        found.update(re.findall(r'<a (?:id|name)="([^"]+)"', line))
    return found


PAGES = [name for name in tracked_files() if name.endswith('.md')]


class Documents(unittest.TestCase):
    """Each test tells all faults at once."""

    def expect_none(self, faults):
        if faults:
            self.fail('%d faults\n%s' % (len(faults), '\n'.join(faults)))

    def test_there_are_pages(self):
        self.assertIn('README.md', PAGES)
        self.assertGreater(len([name for name in PAGES if name.startswith('doc/')]), 10)

    def test_links_and_anchors(self):
        faults, count = [], 0
        known = {name: anchors(lines_of(name)) for name in PAGES}
        for page in PAGES:
            for number, line in prose(lines_of(page)):
                bare = CODE.sub('x', line)
                for target in LINK.findall(bare) + TAG.findall(bare):
                    if re.match(r'[a-z]+:', target):
                        continue
                    count += 1
                    path, _, anchor = urllib.parse.unquote(target).partition('#')
                    file = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
                    if file.startswith('..') or not os.path.exists(os.path.join(SOURCE, file)):
                        faults.append('%s:%d: %s: there is no %s' % (page, number, target, file))
                    elif anchor and anchor not in known.get(file, ()):
                        faults.append('%s:%d: %s: no such heading in %s' % (page, number, target, file))
        self.assertGreater(count, 20)
        self.expect_none(faults)

    def test_pages_that_other_files_name(self):
        """`doc/NAME.md` in code, scripts, launch files and tables of changes."""
        faults, count = [], 0
        for name in tracked_files():
            if name.endswith(('.md', '.png', '.gif', '.bag', '.gz')) or name == os.path.relpath(__file__, SOURCE):
                continue
            try:
                lines = lines_of(name)
            except UnicodeDecodeError:
                continue
            for number, line in enumerate(lines, 1):
                for page in NAMED_PAGE.findall(line):
                    count += 1
                    if not os.path.exists(os.path.join(SOURCE, page)):
                        faults.append('%s:%d: names %s, which is not there' % (name, number, page))
        self.assertGreater(count, 5)
        self.expect_none(faults)

    def test_length_of_lines(self):
        faults = ['%s:%d: %d characters, expected at most %d' % (page, number, len(line), LONGEST)
                  for page in PAGES for number, line in enumerate(lines_of(page), 1)
                  if len(line) > LONGEST and not ADDRESS.match(line)]
        self.expect_none(faults)

    def test_each_page_says_whom_it_is_for(self):
        """Below doc/: the first paragraph under the heading begins with `For ...:` or `For ..., ...: ...`."""
        faults = []
        for page in (name for name in PAGES if name.startswith('doc/')):
            lines = [line for line in lines_of(page) if line.strip()]
            paragraph = ' '.join(lines[1:4])
            if not lines[0].startswith('# '):
                faults.append('%s:1: %r, expected a heading' % (page, lines[0]))
            elif not re.match(r'For [^:]+:', paragraph):
                faults.append("%s: %r below its heading, expected 'For ...: ...'" % (page, paragraph[:60]))
        self.expect_none(faults)


if __name__ == '__main__':
    unittest.main()
