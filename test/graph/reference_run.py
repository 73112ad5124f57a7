"""Rigs that run, and what their masters know, for reference_test.py. A module, no program."""
import glob
import os
import re
import signal
import sys
import time

import rosservice

import rig_run

sys.dont_write_bytecode = True  # of modules beside programs
sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'scripts'))
import trial_plan  # noqa: E402,F401  pylint: disable=wrong-import-position,unused-import
from rig_tools import nodes_of_rig  # noqa: E402  pylint: disable=wrong-import-position

PROGRAMS = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay')
# Nodes that are programs of other packages: their parameters are not ours to tell.
FOREIGN = {'robot_state_publisher', 'hand_left_state_publisher', 'hand_right_state_publisher', 'diagnostic_aggregator'}
LIVE = ('hand_tracking', 'clay_simulator', 'focal_point_renderer', 'simulated_array', 'array_driver')
SPARE = 'spare_contact_pressure'  # a nodelet, so that there is a manager
STABLE = 1.0  # s without a new node, topic or service
DEBUG = ['--master-logger-level', 'debug']  # the master writes down what it is asked for


class Seen:
    """What the master of a run knows: topics with types, services with types, parameters set and asked for."""

    def __init__(self, graph, arguments, extra=()):
        """Starts the rig, and further commands, in a graph."""
        self.graph = graph
        later = FOREIGN - {'robot_state_publisher'}
        self.names = [name for name in nodes_of_rig(arguments) if name not in later]
        self.names += ['record', 'describe_rig'] if 'record' in arguments else []
        self.recording = graph.record(['/%s/parameter_descriptions' % name for name in LIVE if name in self.names])
        self.rig = graph.rig({key: value.replace('./', graph.folder + '/') for key, value in arguments.items()})
        for command in extra:
            graph.start(command)

    def read(self):
        """Once all is there. The rig is ended then."""
        graph = self.graph
        self.wait(graph, self.rig, self.names)
        master = graph.master()
        self.types = dict(master.getTopicTypes('/test')[2])
        self.state = [{name: {node for node in nodes if not node.startswith('/record_')}  # not of this test
                       for name, nodes in part} for part in master.getSystemState('/test')[2]]
        self.services = {}
        for service in (name for name, nodes in self.state[2].items() if nodes):
            uri = master.lookupService('/test', service)[2]
            self.services[service] = rosservice.get_service_headers(service, uri)['type']
        self.set = set(master.getParamNames('/test')[2])
        os.killpg(self.rig.pid, signal.SIGINT)  # it ends while others are read
        self.messages = graph.recorded(self.recording)
        with open(glob.glob(os.path.join(graph.folder, 'log', '**', 'master.log'), recursive=True)[0],
                  errors='replace') as log:
            found = re.findall(r": (?:get|has)Param\('/[^']*', '(/[^']*)'\)$", log.read(), re.MULTILINE)
        self.asked = set(found)
        self.nodes = {node.lstrip('/') for part in self.state for nodes in part.values() for node in nodes}
        return self

    @staticmethod
    def wait(graph, rig, names):
        topics = list(rig_run.CHAIN) + (['/rig/description'] if 'describe_rig' in names else [])
        known, since, deadline = None, 0.0, time.monotonic() + 60
        while True:
            now = graph.master().getSystemState('/test')[2]
            count = [len(nodes) for part in now for _, nodes in part]
            if count != known:
                known, since = count, time.monotonic()
            there = {node for part in now for _, nodes in part for node in nodes}
            missing = [name for name in names if '/' + name not in there]
            missing += [topic for topic in topics if not any(name == topic for name, _ in now[0])]
            if not missing and time.monotonic() - since > STABLE:
                return
            if rig.poll() is not None or time.monotonic() > deadline:
                raise AssertionError('the rig ended, or has no %s:\n%s' % (missing, graph.words()))
            time.sleep(0.3)

    def of(self, kind, node):
        """Names that a node publishes (0), subscribes to (1) or serves (2)."""
        return {name for name, nodes in self.state[kind].items() if '/' + node in nodes}


def runs():
    """Two rigs that have each node between them."""
    if not runs.cache:
        manager = [os.path.join(PROGRAMS, 'nodelet_manager'), '__name:=manager']
        nodelet = 'rosrun nodelet nodelet load tactile_clay/contact_pressure manager'.split() + ['__name:=' + SPARE]
        cheap = dict(scene='press', quality='fast', threads='1')
        first = dict(cheap, hands='bag', file=rig_run.bag('press_finger'), loop='true', clean='true', hand_model='soft',
                     skeleton='true', modulation='field', record='true',
                     record_skin='false')
        second = dict(cheap, hands='none', device='sonic_surface', wire='./port', head_spl_cap='200')
        with rig_run.Graph(DEBUG) as one, rig_run.Graph(DEBUG) as other:  # side by side
            runs.cache = [seen.read() for seen in (Seen(one, first), Seen(other, second, [manager, nodelet]))]
    return runs.cache


runs.cache = []


def generic(name, nodes):
    """A name as the pages have it: relative, with NODE for the node that every node's topic or service is below."""
    relative = name.lstrip('/')
    node, _, rest = relative.rpartition('/')
    common = ('get_loggers', 'set_logger_level', 'set_parameters', 'parameter_descriptions', 'parameter_updates')
    return 'NODE/' + rest if node in nodes and rest in common else relative
