"""rviz on a screen of its own: its camera, its pictures, and a moment that it shows. A module of tests."""
import math
import os
import re
import shutil
import subprocess

import rosbag
import roslib.packages
import yaml

import rig_messages
import rig_run

MOMENT = '2.35'  # s into the bag; both hands knead
WIDTH, HEIGHT = 1400, 900  # of rig.rviz: without a window manager rviz keeps the size that it was given
PATIENCE = 120.0  # s
SPACING = 0.005   # m
BACKGROUND = (236, 238, 241)
FIELD_OF_VIEW = math.radians(45.0)  # of rviz, from the bottom to the top
CONFIG = os.path.join(rig_run.PACKAGE, 'rviz', 'rig.rviz')
OVERLAY = (420, HEIGHT - 110)  # pixels; the state of the rig is written left of and below these
HANDS = ('/hands/tracked', '/hands/skin', '/hands/pressure')


class Camera:
    """The orbit view of an rviz configuration."""

    def __init__(self, config):
        with open(config) as file:
            text = file.read()
        number = lambda name: float(re.search(r'^ +%s: (\S+)$' % name, text, re.MULTILINE).group(1))
        pitch, yaw, distance = number('Pitch'), number('Yaw'), number('Distance')
        self.focus = [number(axis) for axis in 'XYZ']
        self.back = (math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch))
        self.right = (-math.sin(yaw), math.cos(yaw), 0.0)
        self.up = (-math.cos(yaw) * math.sin(pitch), -math.sin(yaw) * math.sin(pitch), math.cos(pitch))
        self.distance = distance
        self.scale = 0.5 * HEIGHT / math.tan(0.5 * FIELD_OF_VIEW)

    def project(self, point):
        """Pixel (x, y) of a point of the world, and pixels a metre there."""
        d = [a - b for a, b in zip(point, self.focus)]
        along = lambda axis: sum(a * b for a, b in zip(d, axis))
        depth = self.distance - along(self.back)
        return (0.5 * WIDTH + self.scale * along(self.right) / depth,
                0.5 * HEIGHT - self.scale * along(self.up) / depth,
                self.scale / depth)


class Picture:
    def __init__(self, rgb):
        self.rgb = rgb

    def __getitem__(self, at):
        offset = 3 * (at[1] * WIDTH + at[0])
        return tuple(self.rgb[offset:offset + 3])

    def save(self, path):
        subprocess.run(['convert', '-size', '%dx%d' % (WIDTH, HEIGHT), '-depth', '8', 'rgb:-', path], input=self.rgb,
                       check=True)

    def pixels(self, condition):
        """Set of the pixels of whose colour that is true."""
        return {(x, y) for y in range(HEIGHT) for x in range(WIDTH) if condition(self[x, y])}

    def around(self, at, radius):
        x, y = round(at[0]), round(at[1])
        return [self[i, j] for j in range(max(0, y - radius), min(HEIGHT, y + radius + 1))
                for i in range(max(0, x - radius), min(WIDTH, x + radius + 1))]


def differs(a, b, by=24):
    return max(abs(p - q) for p, q in zip(a, b)) > by


def drawn(picture):
    """How many pixels of a picture of rviz are not the background; 0 before it draws."""
    if differs(picture[WIDTH - 1, HEIGHT - 1], BACKGROUND):
        return 0
    return len(picture.pixels(lambda color: differs(color, BACKGROUND)))


class Window:
    """rviz on a screen of its own, as scripts/rig shows it, in a graph. `only`: names of the displays that are on; or
    the properties to be changed, by these names."""

    def __init__(self, graph, only=None, camera=None, fullscreen=True):
        config = CONFIG
        if only is not None:
            config = os.path.join(graph.folder, 'view.rviz')
            with open(CONFIG) as file:
                view = yaml.safe_load(file)
            for display in view['Visualization Manager']['Displays']:
                display['Enabled'] = display['Value'] = display['Name'] in only
                display.update(only.get(display['Name'], {}) if isinstance(only, dict) else {})
            current = view['Visualization Manager']['Views']['Current']
            if camera is not None:
                current.update(Yaw=camera['yaw'], Pitch=camera['pitch'], Distance=camera['distance'])
                current['Focal Point'] = dict(zip('XYZ', camera['focus']))
            with open(config, 'w') as file:
                yaml.safe_dump(view, file)
        self.config = config
        self.graph = graph
        reading, writing = os.pipe()
        graph.start(['Xvfb', '-displayfd', str(writing), '-screen', '0', '%dx%dx24' % (WIDTH, HEIGHT), '+extension',
                     'GLX'],
                    pass_fds=[writing])
        os.close(writing)
        with os.fdopen(reading) as opened:
            self.environment = {'DISPLAY': ':' + opened.readline().strip(), 'LIBGL_ALWAYS_SOFTWARE': '1',
                                'QT_X11_NO_MITSHM': '1', 'HOME': graph.folder, 'XDG_RUNTIME_DIR': graph.folder}
        self.log = open(os.path.join(graph.folder, 'rviz.log'), 'wb')
        self.rviz = graph.start([roslib.packages.find_node('tactile_clay', 'rig_view')[0]] +
                                ['--fullscreen'] * fullscreen + ['-d', config],
                                environment=self.environment, stdout=self.log, stderr=subprocess.STDOUT)

    def picture(self):
        done = subprocess.run(['import', '-window', 'root', '-depth', '8', 'rgb:-'], capture_output=True,
                              timeout=PATIENCE,
                              env=dict(os.environ, **self.environment))
        return Picture(done.stdout) if len(done.stdout) == 3 * WIDTH * HEIGHT else None

    def settled(self, condition, part=lambda picture: picture.rgb):
        """The picture once `condition` is true of it, and `part` of it stays the same. Raises AssertionError after
        `PATIENCE`."""
        seen = [None]

        def still():
            before, seen[0] = seen[0], self.picture()
            return None not in (before, seen[0]) and part(before) == part(seen[0]) and condition(seen[0])
        try:
            rig_run.wait_until(still, PATIENCE, 'a picture that shows what it should')
        except AssertionError as error:
            raise AssertionError('%s; %s' % (error, self.state(seen[0]))) from None
        return seen[0]

    def state(self, picture):
        """What there is instead of the picture that was waited for, in words. Keeps the picture for who looks."""
        words = ['no picture' if picture is None else '%d pixels drawn' % drawn(picture)]
        words += ['%s ended with %d' % (os.path.basename(process.args[0]), process.returncode)
                  for process in self.graph.processes if process.poll() is not None]
        if picture is not None:
            picture.save(os.path.join(os.environ.get('ROS_HOME', self.graph.folder), 'unexpected.png'))
        for name in ('rviz.log', 'show_moment.log'):
            path = os.path.join(self.graph.folder, name)
            if os.path.exists(path):
                with open(path, errors='replace') as log:
                    words.append('%s ends with:\n%s' % (name, ''.join(log.readlines()[-20:])))
        return ', '.join(words)


def kneading(moment=MOMENT):
    """A lockstep run of two hands that knead until a moment, and the last message of each topic."""
    for program in ('Xvfb', 'import'):
        if not shutil.which(program):
            raise AssertionError('%s is missing, expected the packages of scripts/setup' % program)
    run = rig_run.Run(dict(rig_run.LOCKSTEP, modulation='am', hands='bag', file=rig_run.bag('knead'), duration=moment),
                      rig_run.CHAIN + ['/tf_static', '/clay/particles', '/array/drive', '/array/geometry'])
    last = {topic: found[-1] for topic, found in run.messages.by_topic.items() if topic != '/tf_static'}
    frames = run.messages['/tf_static'][-1]
    for message in run.messages['/tf_static'][:-1]:
        frames.transforms += message.transforms
    last['/tf_static'] = frames
    return run, last


def publish(graph, last, topics):
    """Publishes these messages of `last` in a graph, latched. Returns the process that does."""
    bag = os.path.join(graph.folder, 'moment%d.bag' % len(topics))
    with rosbag.Bag(bag, 'w') as opened:
        for topic in topics:
            opened.write(topic, last[topic])
    with open(os.path.join(graph.folder, 'show_moment.log'), 'ab') as log:
        return graph.start([roslib.packages.find_node('tactile_clay', 'show_moment')[0], '_bag:=' + bag], stdout=log,
                           stderr=subprocess.STDOUT)


def silhouette(particles, camera):
    """Pixels of the balls of one spacing^3 about the particles."""
    expected = set()
    for particle in particles:
        x, y, scale = camera.project(particle)
        radius = 0.62 * SPACING * scale
        for j in range(math.ceil(y - radius), math.floor(y + radius) + 1):
            half = math.sqrt(radius * radius - (j - y) ** 2)
            expected.update((i, j) for i in range(math.ceil(x - half), math.floor(x + half) + 1))
    return expected


def places(cloud):
    """(x, y, z) of each point of a cloud, m."""
    return rig_messages.columns(cloud, 'x', 'y', 'z')


def has_strong_colours(test, picture):
    """Asserts that red, blue and green bodies are seen: channels by strength."""
    for first, *others in [(0, 1, 2), (2, 1, 0), (1, 0, 2)]:
        test.assertGreater(len(picture.pixels(lambda c: all(c[first] > 1.3 * c[k] for k in others))), 300)
