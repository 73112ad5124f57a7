#!/usr/bin/env python3
"""The package for Debian that cpack makes: control file, list of files, a tool that runs from it: deb_test.py
BUILD_FOLDER"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
BUILD = os.path.abspath(sys.argv.pop())


def output(*command, **options):
    return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True,
                          check=True, timeout=200, **options).stdout


@unittest.skipUnless(shutil.which('dpkg-shlibdeps'), 'no dpkg-shlibdeps')
class Deb(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix='deb_')
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        # What is built is packed: a generator that does not ask make for all targets first. Quickly: not small, and
        # without dpkg-shlibdeps, which takes a minute of all programs; test_libraries has it of one.
        done = subprocess.run(['cpack', '-G', 'DEB', '-B', cls.folder, '--config',
                               os.path.join(BUILD, 'CPackConfig.cmake'),
                               '-D', 'CPACK_CMAKE_GENERATOR=Ninja', '-D', 'CPACK_DEBIAN_COMPRESSION_TYPE=none',
                               '-D', 'CPACK_DEBIAN_PACKAGE_SHLIBDEPS=OFF'],
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=200,
                              check=False)
        packages = glob.glob(os.path.join(cls.folder, '*.deb'))
        if done.returncode != 0 or len(packages) != 1:
            raise AssertionError(done.stdout)
        cls.package = packages[0]
        cls.root = os.path.join(cls.folder, 'root')
        output('dpkg', '-x', cls.package, cls.root)
        cls.files = [line.split(maxsplit=5)[5] for line in output('dpkg', '-c', cls.package).splitlines()]
        cls.prefix = '/opt/ros/noetic' if os.path.isdir('/opt/ros/noetic') else '/usr'

    def field(self, name):
        return output('dpkg', '-f', self.package, name).strip()

    def test_control(self):
        self.assertIn('tactile-clay', self.field('Package'))
        with open(os.path.join(SOURCE, 'package.xml')) as file:
            self.assertIn('<version>%s</version>' % self.field('Version'), file.read())
        self.assertEqual(self.field('Architecture'), output('dpkg', '--print-architecture').strip())
        self.assertRegex(self.field('Maintainer'), r'^.+ <.+@.+>$')
        summary, *rest = self.field('Description').splitlines()
        self.assertLess(len(summary), 80)
        self.assertTrue(rest)

    def expect_installed(self, depends):
        """One of the alternatives of each dependency is here, where it was built."""
        known = set(output('dpkg-query', '-W', '-f', '${Package} ${Provides}\n').replace(',', ' ').split())
        for names in ({re.match(r'[\w.+-]+', one.strip()).group(0) for one in part.split('|')}
                      for part in depends.split(',')):
            self.assertTrue(names & known, names)
            self.assertFalse([name for name in names if 'tactile' in name or name.endswith('-dev')])

    def test_dependencies_are_packages_of_the_distribution(self):
        depends = self.field('Depends')
        for name in ('python3-rospkg', *(('python3-roslaunch', 'rviz') if self.prefix == '/usr' else ())):
            self.assertIn(name, depends)
        self.expect_installed(depends)

    def test_libraries(self):
        os.mkdir(os.path.join(self.folder, 'debian'))
        with open(os.path.join(self.folder, 'debian', 'control'), 'w') as control:
            control.write('Source: s\n\nPackage: p\nArchitecture: any\n')
        library = os.path.join(self.root + self.prefix, 'lib', 'libtactile_clay_device.so')
        told = output('dpkg-shlibdeps', '-O', '-l' + os.path.dirname(library), '-e' + library, cwd=self.folder)
        depends = re.search(r'^shlibs:Depends=(.*)$', told, re.MULTILINE).group(1)
        self.assertIn('libc6 ', depends)
        self.expect_installed(depends)
        with open(os.path.join(BUILD, 'CPackConfig.cmake')) as config:
            self.assertRegex(config.read(), r'set\(CPACK_DEBIAN_PACKAGE_SHLIBDEPS "ON"\)')

    def test_files(self):
        names = {name[1:] for name in self.files}
        for name in ('lib/tactile_clay/preflight', 'lib/tactile_clay/replay', 'lib/tactile_clay/rig_tools.py',
                     'lib/libtactile_clay_nodes.so', 'share/tactile_clay/package.xml', 'share/tactile_clay/plugins.xml',
                     'share/tactile_clay/launch/rig.launch', 'share/tactile_clay/config/quality.yaml',
                     'share/tactile_clay/test/bags/knead.bag', 'include/tactile_clay/hand/hand_source.h'):
            self.assertIn(os.path.join(self.prefix, name), names)
        self.assertTrue(any(re.search(r'/share/doc/[a-z-]+/copyright$', name) for name in names))
        for name in names:
            self.assertTrue(name == '/' or (self.prefix + '/').startswith(name) or name.startswith(self.prefix + '/'),
                            name)
            self.assertNotIn('__pycache__', name)
            # Those are of ROS.
            self.assertNotRegex(name, r'/(\.catkin|_setup_util\.py|env\.sh|(local_)?setup\.\w+)$')
        with open(os.path.join(self.root + self.prefix, 'lib', 'pkgconfig', 'tactile_clay.pc')) as file:
            self.assertIn('prefix=%s\n' % self.prefix, file.read())
        for line in output('dpkg', '-c', self.package).splitlines():
            self.assertIn(line[:10], ('drwxr-xr-x', '-rw-r--r--', '-rwxr-xr-x', 'lrwxrwxrwx'), line)
            self.assertIn(' root/root ', line)

    def test_tools_run_from_where_it_lies(self):
        programs = os.path.join(self.root + self.prefix, 'lib', 'tactile_clay')
        environment = {key: value for key, value in os.environ.items() if 'CATKIN' not in key and key not in (
            'CMAKE_PREFIX_PATH', 'LD_LIBRARY_PATH', 'ROS_PACKAGE_PATH', 'PYTHONPATH')}
        table = output(os.path.join(programs, 'speed_accuracy'), '--scene', 'incline', '--duration', '0.02',
                       '--substeps', '1',
                       '--iterations', '1', '--solver', 'minimise', '--reference', 'minimise:1x1', env=environment)
        self.assertIn('reference, minimise', table)
        self.assertIn('usage', output(sys.executable, os.path.join(programs, 'replay'), '--help',
                                      env=environment).lower())
        environment.update(ROS_PACKAGE_PATH=os.path.join(self.root + self.prefix, 'share'),
                           CMAKE_PREFIX_PATH=self.root + self.prefix)
        self.assertIn('<robot', output(os.path.join(programs, 'preflight'), 'scene:=press', env=environment))


if __name__ == '__main__':
    unittest.main()
