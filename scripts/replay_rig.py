"""The rig of a bag, rebuilt from its description, and run. A module of `replay`, no program."""
import base64
import os
import re
import shutil
import socket
import urllib.parse
import zlib

import roslib.packages
import rospkg
import yaml

from rig_tools import LAUNCH, PACKAGE, Fault, known_arguments, rig_environment, run_rig

HARMLESS = ('simulated', 'debug')
# Parameters that a replay sets otherwise; all others are the bag's.
REPLACED = {'hand_tracking': ('source', 'file', 'url', 'topic', 'rate', 'loop', 'clean', 'prediction', 'lockstep',
                              'duration', 'wait_for_graph', 'recorder', 'recorded_first', 'unrecorded'),
            'hand_simulator': ('lockstep', 'live_input'),
            'hand_skeleton': ('lockstep',),
            'clay_simulator': ('scene', 'material', 'lockstep', 'threads', 'target_ms'),
            'clay_surface': ('scene',),
            'contact_pressure': ('lockstep',),
            'focal_point_renderer': ('lockstep',),
            'simulated_array': ('lockstep', 'check_stamps'),
            'array_driver': ('device', 'port', 'device_options', 'lockstep', 'check_stamps')}
NOT_RUN = ('boards', 'manager', 'diagnostic_aggregator', 'robot_state_publisher', 'hand_left_state_publisher',
           'hand_right_state_publisher')


class Rebuilt:
    """The rig's files in a folder. `space`: a workspace with a package of the bag's files; `scene`: its scene file."""

    def __init__(self, folder, files):
        self.folder, self.space = folder, os.path.join(folder, 'space')
        self.share = os.path.join(self.space, 'share', PACKAGE)
        texts = {entry['role']: entry for entry in files}
        by_name = {entry['name']: self.place(entry) for entry in files if entry['name']}
        for entry in files:
            text = entry.get('text')
            if text is None:
                self.write(self.place(entry), zlib.decompress(base64.b64decode(entry['zlib'])))
                continue
            if entry['role'] in ('scene', 'urdf'):
                text = self.renamed(text, by_name, entry['role'] == 'urdf')
            self.write(self.place(entry), text.encode())
        self.scene = self.place(texts['scene'])
        self.places = by_name
        self.add_programs()

    def add_programs(self):
        """What runs is of this computer. Last, so that nothing of a bag stands in its place."""
        programs = roslib.packages.find_node(PACKAGE, 'hand_tracking')
        if not programs:
            raise Fault('the programs of %s are not built or not installed here' % PACKAGE)
        installed = rospkg.RosPack().get_path(PACKAGE)
        for name in ('package.xml', 'plugins.xml'):
            shutil.copy(os.path.join(installed, name), self.share)
        for name in ('launch', 'rviz'):
            shutil.copytree(os.path.join(installed, name), os.path.join(self.share, name), dirs_exist_ok=True)
        os.makedirs(os.path.join(self.space, 'lib'))
        os.symlink(os.path.dirname(programs[0]), os.path.join(self.space, 'lib', PACKAGE))
        open(os.path.join(self.space, '.catkin'), 'w').close()

    def place(self, entry):
        """Where a file goes: those of the package into the package, all others into a tree like that they came from."""
        path = entry['path']
        if entry['role'] == 'urdf' and path.endswith('.xacro'):
            path += '.urdf'  # its macros are expanded
        root = os.path.join(self.folder, 'files') if path.startswith('/') else self.share
        found = os.path.normpath(root + '/' + path)
        if not found.startswith(root + '/'):
            raise Fault("has a file '%s' that is outside of its folder" % path)
        return found

    @staticmethod
    def renamed(text, places, addresses):
        """A text in which files that only the other machine has, and expanded models, are named as their copies."""
        for name, place in places.items():
            if not (name.startswith(('/', '~/', 'file://', 'package://')) or place.endswith('.xacro.urdf')):
                continue
            new = 'file://' + urllib.parse.quote(place) if addresses else place
            text = re.sub(r'(?<![\w./~:-])' + re.escape(name) + r'(?![\w./-])', lambda _: new, text)
        return text

    @staticmethod
    def write(path, data):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, 'wb') as file:
            file.write(data)


def device_of(told):
    """The device of the rig's array."""
    if 'array_driver' not in told['nodes']:
        return 'simulated'
    return str(told['parameters'].get('array_driver', {}).get('device', 'debug'))


def rig_command(folder, rebuilt, told, hands, bag, changes):
    """The command that runs the rig in lockstep, and the new bag that it records."""
    parameters = told['parameters']
    device = device_of(told)
    known = known_arguments(rebuilt.share)
    arguments = {name: str(value) for name, value in told['arguments'].items() if name in known}
    new = os.path.join(folder, 'replayed.bag')
    material = str(parameters['clay_simulator'].get('material', ''))
    arguments.update(scene=rebuilt.scene, material=rebuilt.places.get(material, material),
                     quality=str(parameters['clay_simulator'].get('quality', 'balanced')),
                     target_ms='0', hands='bag', file=bag, topic=hands, rate='1.0', loop='false', clean='false',
                     prediction='0',
                     url='', tracker_pose='', rig='', wire='', port='', device_options='', rviz='false',
                     diagnostics='false', record=new, record_compression='none',
                     duration='0', threads='0', nodelets='false', lockstep='true',
                     device=device if device in HARMLESS else 'debug',
                     skeleton='true' if 'hand_skeleton' in told['nodes'] else 'false')
    kept = {node: {key: value for key, value in values.items() if key not in REPLACED.get(node, ())}
            for node, values in parameters.items() if isinstance(values, dict) and node not in NOT_RUN}
    for node in set(changes) & set(kept):
        kept[node]['changes'] = yaml.safe_dump(changes[node], width=1 << 20)
    with open(os.path.join(folder, 'parameters.yaml'), 'w') as file:
        yaml.safe_dump({node: values for node, values in kept.items() if values}, file)
    launch = os.path.join(folder, 'replay.launch')
    with open(launch, 'w') as file:
        file.write(LAUNCH)
    return ['roslaunch', launch] + ['%s:=%s' % item for item in sorted(arguments.items())], new


def run(command, rebuilt, namespace, folder):
    """Runs the rig to its end, with a master of its own. Raises Fault with a line of the rig where it fails."""
    with socket.socket() as probe:
        probe.bind(('localhost', 0))
        port = probe.getsockname()[1]
    environment = rig_environment(ROS_MASTER_URI='http://localhost:%d' % port, ROS_HOSTNAME='localhost', PWD=folder,
                                  ROS_HOME=os.path.join(folder, 'ros'), ROS_LOG_DIR=os.path.join(folder, 'ros', 'log'))
    environment.pop('ROS_IP', None)

    def before(name, path):
        environment[name] = path + (':' + environment[name] if environment.get(name) else '')
    before('CMAKE_PREFIX_PATH', rebuilt.space)
    before('ROS_PACKAGE_PATH', os.path.dirname(rebuilt.share))
    if namespace != '/':
        environment['ROS_NAMESPACE'] = namespace
    run_rig(command, environment, folder, os.path.join(folder, 'replay.log'))
