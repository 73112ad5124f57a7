"""Cases of reference_test.py that need no rig: files, launch files, messages, programs. A module, no program."""
import concurrent.futures
import glob
import os
import re
import subprocess
import tempfile
import unittest
from xml.etree import ElementTree

import yaml

import rig_run
from reference_pages import material_keys, page, quoted, rows, sections
from reference_run import PROGRAMS, trial_plan


def known_keys(file, text, arguments):
    """The keys that a reader knows, out of its words about the key `zzz` of a file."""
    with open(file, 'w') as written:
        written.write(text)
    done = subprocess.run([os.path.join(PROGRAMS, 'preflight')] + arguments, stdin=subprocess.DEVNULL, timeout=60,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    found = re.search(r"unknown key 'zzz', expected one of (.*)", done.stderr)
    if done.returncode != 1 or not found:
        raise AssertionError('no word about the key zzz of %s: %s' % (file, done.stderr))
    return set(found.group(1).split(', ')) - {'zzz'}


BOX = 'name: a, material: putty, shape: box, size: [0.04, 0.04, 0.04]'
SCENE = 'urdf: table\n%sbodies:\n  - {%s}\n%s'
MOVES = {'press_finger': 'centre: [0, 0]', 'press_thumb': 'centre: [0, 0]', 'press_flat': 'centre: [0, 0]',
         'pinch': 'centre: [0, 0]', 'roll': 'centre: [0, 0]', 'knead': 'strokes: 1', 'potter': 'depth: 0.004'}


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix='reference_')
        cls.addClassCleanup(temporary.cleanup)
        folder = temporary.name
        cls.known, jobs = {}, {}
        path = lambda name: os.path.join(folder, name + '.yaml')
        scene = lambda name: ['scene:=' + path(name), 'hands:=none']
        jobs['scene'] = (path('scene'), SCENE % ('zzz: 1\n', BOX, ''), scene('scene'))
        jobs['body'] = (path('body'), SCENE % ('', BOX + ', pose: [0, 0, 0, 0, 0, 0], zzz: 1', ''), scene('body'))
        jobs['motion'] = (path('motion'), SCENE % ('', BOX, 'motions:\n  - {joint: a, velocity: 1, zzz: 1}\n'),
                          scene('motion'))
        jobs['material'] = (path('mud'), 'zzz: 1\n', ['material:=' + path('mud'), 'hands:=none'])
        jobs['rig'] = (path('rig'), 'zzz: 1\n', ['rig:=' + path('rig'), 'hands:=none'])
        jobs['score'] = (path('score'), 'zzz: 1\nmoves:\n  - {move: knead}\n',
                         ['hands:=choreography', 'file:=' + path('score')])
        for move, more in MOVES.items():
            jobs[move] = (path(move), 'moves:\n  - {move: %s, %s, zzz: 1}\n' % (move, more),
                          ['hands:=choreography', 'file:=' + path(move)])
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            for name, keys in zip(jobs, pool.map(lambda job: known_keys(*job), jobs.values())):
                cls.known[name] = keys

    def table(self, file, heading):
        return {name for row in rows(sections(page(file))[heading]) for name in quoted(row[0])}

    def test_keys_of_a_scene(self):
        self.assertEqual(self.table('scene_file.md', 'Keys of a scene'), self.known['scene'])
        # A mesh has these two instead of a size.
        self.assertEqual(self.table('scene_file.md', 'Keys of a body'), self.known['body'] | {'mesh', 'scale'})
        self.assertEqual(self.table('scene_file.md', 'Keys of a motion'), self.known['motion'])

    def test_keys_of_a_material(self):
        self.assertEqual(material_keys(), self.known['material'])

    def test_keys_of_a_score(self):
        text = sections(page('hand_sources.md'))['Scores']
        keys, moves = text.split('| `move` |')
        self.assertEqual({name for row in rows(keys) for name in quoted(row[0])}, self.known['score'])
        told = {row[0].strip('`'): set(quoted(row[1])) for row in rows('| `move` |' + moves)}
        told['press_thumb'] = told['press_flat'] = told['press_finger']
        self.assertEqual(told, {move: self.known[move] - {'move'} for move in MOVES})

    def test_keys_of_a_rig(self):
        text = sections(page('launch.md'))['The file of rig']
        listed = text.split('It takes these keys', 1)[1].split('\n\n')[1]
        self.assertEqual(set(quoted(listed)), self.known['rig'])

    def test_what_is_shipped(self):
        materials = self.table('material_file.md', 'Shipped materials')
        self.assertEqual(self.shipped('materials'), materials)
        scenes = page('scene_file.md').split('Shipped:')[1].split('A test asks')[0]
        self.assertEqual(self.shipped('scenes'), set(quoted(scenes)))
        self.assertLessEqual(self.shipped('hands'), set(quoted(sections(page('hand_sources.md'))['Scores'])))
        with open(os.path.join(rig_run.PACKAGE, 'doc', 'method', 'speed_accuracy.md'), encoding='utf-8') as file:
            text = file.read()
        with open(os.path.join(rig_run.PACKAGE, 'config', 'quality.yaml')) as file:
            for name, preset in yaml.safe_load(file).items():
                self.assertIn('`%s` %d × %d' % (name, preset['substeps'], preset['iterations']), page('parameters.md'))
                row = self.row_of_errors(name, preset)
                self.assertTrue(row in text, row)

    @staticmethod
    def row_of_errors(name, preset):
        """How a row of the first table of speed_accuracy.md begins, of a preset of quality.yaml."""
        errors = [('%.1f' % (100 * preset[scene]['force'])).replace('.0', '') + ' %%, %.2f spacings' %
                  preset[scene]['displacement'] for scene in ('kneading', 'wheel')]
        return '| `%s` | %d × %d | %s | %s |' % (name, preset['substeps'], preset['iterations'], *errors)

    @staticmethod
    def shipped(folder):
        """Names of the files of a folder of config/."""
        return {os.path.splitext(os.path.basename(path))[0]
                for path in glob.glob(os.path.join(rig_run.PACKAGE, 'config', folder, '*.yaml'))}

    def test_arguments_of_launch_files(self):
        told = sections(page('launch.md'))
        for path in sorted(glob.glob(os.path.join(rig_run.PACKAGE, 'launch', '*.launch'))):
            name = os.path.basename(path)
            with self.subTest(name):
                real = {one.get('name'): one.get('default') for one in ElementTree.parse(path).getroot().iter('arg')
                        if one.get('default') is not None}
                table = {row[0].strip('`'): row[1] for row in rows(told[name])}
                self.assertEqual(sorted(table), sorted(real))
                for argument, default in real.items():
                    if '$(' in default:
                        self.assertTrue(table[argument].startswith('computed: '), argument)
                    else:
                        self.assertEqual(table[argument], '`%s`' % default if default else 'empty', argument)

    def test_fields_of_messages(self):
        told = sections(page('messages.md'))
        names = [os.path.splitext(os.path.basename(path))[0]
                 for path in glob.glob(os.path.join(rig_run.PACKAGE, 'msg', '*.msg'))]
        self.assertEqual(sorted(told), sorted(names))
        for name in names:
            with open(os.path.join(rig_run.PACKAGE, 'msg', name + '.msg')) as file:
                fields = set(re.findall(r'^[\w/]+(?:\[\d*\])?\s+(\w+)', file.read(), re.MULTILINE)) - {'header'}
            words = set(quoted(told[name]))
            self.assertLessEqual(fields, words, name)
            first = {word for line in re.findall(r'^- (`.*?):', told[name], re.MULTILINE) for word in quoted(line)}
            self.assertLessEqual(first - {'header'}, fields, name)

    def test_displays_of_rviz(self):
        with open(os.path.join(rig_run.PACKAGE, 'rviz', 'rig.rviz')) as file:
            view = yaml.safe_load(file)
        names = {display['Name'] for display in view['Visualization Manager']['Displays']}
        told = {row[0] for row in rows(sections(page('rviz.md'))['Displays'].split('###')[0])}
        self.assertEqual(told, names)
        with open(os.path.join(rig_run.PACKAGE, 'plugins.xml')) as file:
            classes = re.findall(r'<class name="(tactile_clay/\w+)"[^>]*base_class_type="rviz::', file.read())
        self.assertGreater(len(classes), 3)
        for name in classes:
            self.assertIn('`%s`' % name, page('rviz.md'))


class Programs(unittest.TestCase):
    def test_programs(self):
        text = page('tools.md')
        told = {name.strip() for part in sections(text).values() for name in sections(part, 3)} - {'The nodes'}
        nodes = set(quoted(sections(sections(text)['Running'], 3)['The nodes'].split('[nodes.md]')[0]))
        real = set()
        for name in os.listdir(PROGRAMS):
            path = os.path.join(PROGRAMS, name)
            if os.access(path, os.X_OK) and not self.is_left_over(path):
                real.add(name)
        self.assertGreater(len(real), 20)
        self.assertEqual(sorted(real - told - nodes), [], 'programs that tools.md does not have')
        scripts = set(os.listdir(os.path.join(rig_run.PACKAGE, 'scripts')))
        self.assertEqual(sorted(told - real - scripts), [], 'programs of tools.md that are not there')
        for name in scripts - real - {'__pycache__'}:
            self.assertTrue('scripts/' + name in text, name)

    @staticmethod
    def is_left_over(path):
        """Whether it is catkin's wrapper of a script that is gone: an old build folder keeps it."""
        with open(path, 'rb') as file:
            head = file.read(2000)
        found = re.search(rb"python_script = '([^']+)'", head)
        return bool(found) and not os.path.exists(found.group(1))

    def test_keys_of_a_plan_of_trials(self):
        told = sections(page('trial_plan.md'))
        tables = {'staircase': {name for row in rows(told['Staircases']) for name in quoted(row[0])}}
        for where in ('plan', 'block'):
            tables[where] = {name for row in rows(told['Keys of a plan']) if where in row[1] for name in quoted(row[0])}
        stairs = 'key: threads, start: 1, low: 1, high: 2, steps: [1], detected: a'
        plan = 'session: a\nparticipant: b\nduration: 1\nanswers: [a]\n%sblocks:\n  - {name: c, staircase: {%s}%s}\n'
        for where, more in (('plan', ('zzz: 1\n', stairs, '')), ('block', ('', stairs, ', zzz: 1')),
                            ('staircase', ('', stairs + ', zzz: 1', ''))):
            with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
                file.write(plan % more)
                file.flush()
                with self.assertRaises(trial_plan.Fault) as raised:
                    trial_plan.Plan(file.name, rig_run.PACKAGE)
            known = re.search(r"zzz', expected one of (.*)", str(raised.exception))
            self.assertTrue(known, raised.exception)
            self.assertEqual(set(known.group(1).split(', ')), tables[where], where)
