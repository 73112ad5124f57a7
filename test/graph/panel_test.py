#!/usr/bin/env python3
"""Buttons and keys of the experimenter's panel: see panel.test."""
import glob
import os
import subprocess
import unittest

import rosbag
import rosgraph
import rospy
from dynamic_reconfigure.msg import Config, ConfigDescription, DoubleParameter, Group, ParamDescription, StrParameter
from dynamic_reconfigure.srv import Reconfigure, ReconfigureResponse
from std_msgs.msg import Empty
from std_srvs.srv import Trigger, TriggerResponse
from tactile_clay.msg import ArrayState
from tactile_clay.srv import SculptureFile, SculptureFileResponse, Undo, UndoResponse

import rig_run
from rviz_window import HEIGHT, PATIENCE, Window

STOP_RED = (210, 40, 30)
PANEL_WIDTH = 350  # pixels
# Line in the log of the node, by the viscosity that it refuses: first another line than that of a refusal.
REFUSED = {1e7: 'something else',
           1e8: '/clay_simulator: no parameter was changed: viscosity of the clay is a number from 0 to a million, and '
                'not more than that, whatever somebody types'}


class Panel(unittest.TestCase):
    def test_buttons_and_keys(self):
        with rig_run.Graph() as graph:
            pictures = os.environ.get('ROS_HOME', graph.folder)  # for who looks
            os.environ.update(graph.environment)
            rospy.init_node('panel_test', anonymous=True, disable_signals=True)
            self.assertTrue(rosgraph.is_master_online())
            asked = []
            answer = lambda what, text: lambda request: asked.append((what, getattr(request, 'file', ''))) or text
            rospy.Subscriber('array/stop', Empty, lambda _: asked.append(('stop', '')))
            rospy.Service('array/reset', Trigger, answer('array', TriggerResponse(True, 'sounds again')))
            rospy.Service('clay_simulator/reset', Trigger, answer('clay', TriggerResponse(True, '')))
            rospy.Service('clay_simulator/save', SculptureFile, answer('save', SculptureFileResponse(True, 'saved')))
            rospy.Service('clay_simulator/load', SculptureFile,
                          answer('load', SculptureFileResponse(False, 'torn file')))
            config = lambda quality, viscosity: Config(strs=[StrParameter('quality', quality)],
                                                       doubles=[DoubleParameter('viscosity', viscosity)])
            held = rospy.Publisher('clay_simulator/parameter_updates', Config, queue_size=1, latch=True)
            holds = {'quality': 'balanced', 'viscosity': 150.5}
            held.publish(config(**holds))

            def change(request):
                for value in request.config.strs + request.config.doubles:
                    asked.append((value.name, value.value))
                    if value.value in REFUSED:
                        rospy.logwarn(REFUSED[value.value])
                        raise rospy.ServiceException('refused')
                    holds[value.name] = value.value
                held.publish(config(**holds))
                return ReconfigureResponse(config(**holds))
            rospy.Service('clay_simulator/set_parameters', Reconfigure, change)
            rospy.set_param('/clay_simulator/scene', '/somewhere/config/scenes/kindergarten.yaml')
            states = rospy.Publisher('array/state', ArrayState, queue_size=1, latch=True)
            silent = ArrayState(device='simulated', emitting=False, silent_reason='stopped by hand')
            rospy.Timer(rospy.Duration(0.5), lambda _: states.publish(silent))
            window = Window(graph, fullscreen=False)
            # Of the panel alone, on the left of the window.
            pixels = lambda picture, condition: {(x, y) for y in range(HEIGHT) for x in range(PANEL_WIDTH)
                                                 if condition(picture[x, y])}
            red = lambda picture: pixels(picture, lambda c: max(abs(a - b) for a, b in zip(c, STOP_RED)) < 6)
            # Beside the panel rviz shows its frames per second, which seldom stay the same on a busy machine.
            seen = window.settled(lambda picture: len(red(picture)) > 3000, part=red)
            seen.save(os.path.join(pictures, 'panel.png'))
            button = red(seen)
            middle = [str(sorted(v)[len(v) // 2]) for v in zip(*button)]  # other red spots are small

            def act(*words):
                subprocess.run(['xdotool'] + list(words), check=True, timeout=PATIENCE,
                               env=dict(os.environ, **window.environment))

            def come(what):
                rig_run.wait_until(lambda: what in [name for name, _ in asked], 30.0, what)
            rig_run.wait_until(lambda: graph.subscribed('/array/state'), PATIENCE, 'the panel')
            act('mousemove', middle[0], middle[1], 'click', '1')
            come('stop')
            asked.clear()
            for key, what in (('F12', 'stop'), ('shift+F12', 'array'), ('F8', 'clay'), ('F5', 'save'), ('F9', 'load')):
                act('key', key)
                come(what)
                rospy.rostime.wallsleep(0.5)  # its answer is shown before the next call
            self.assertEqual([name for name, _ in asked], ['stop', 'array', 'clay', 'save', 'load'])
            saved, loaded = asked[3][1], asked[4][1]
            self.assertRegex(saved, r'^/.*/clay_[-_0-9]+\.clay$')
            self.assertEqual(loaded, saved)
            # Quality by keys, from the one that holds: the next better one. Alt+Q brings the focus there.
            act('key', 'alt+q', 'Down')
            come('quality')
            self.assertEqual(asked[-1], ('quality', 'accurate'))
            act('key', 'alt+q', 'Up')
            rig_run.wait_until(lambda: ('quality', 'balanced') in asked, 30.0, 'the quality of before')
            # There is no undo until the clay serves it.
            act('key', 'ctrl+z')
            rospy.Service('clay_simulator/undo', Undo, answer('undo', UndoResponse(True, 'went back', 2.0)))

            def undone():
                act('key', 'ctrl+z')
                return 'undo' in [name for name, _ in asked]
            rig_run.wait_until(undone, 30.0, 'undo')
            # Nor is there an export until the surface serves it.
            rospy.Service('clay_surface/export', SculptureFile,
                          answer('export', SculptureFileResponse(True, 'triangles written')))
            for key, ending in (('F7', 'stl'), ('shift+F7', 'ply')):
                exported = lambda: [file for name, file in asked if name == 'export' and file.endswith(ending)]

                def pressed():
                    act('key', key)
                    return exported()
                rig_run.wait_until(pressed, 30.0, 'an export')
                self.assertRegex(exported()[0], r'^/.*/clay_[-_0-9]+\.' + ending + '$')
            # A recording, on and off.
            written = lambda end: glob.glob(os.path.join(graph.folder, 'run_*.bag' + end))
            act('key', 'F6')
            rig_run.wait_until(lambda: written('.active') and os.path.getsize(written('.active')[0]) > 10000, PATIENCE,
                               'a recording')
            window.picture().save(os.path.join(pictures, 'panel_recording.png'))
            act('key', 'F6')
            rig_run.wait_until(lambda: written(''), PATIENCE, 'a closed bag')
            self.assertFalse(written('.active'))
            with rosbag.Bag(written('')[0]) as bag:
                self.assertIn('/array/state', bag.get_type_and_topic_info().topics)
            asked.clear()
            act('key', 'F9')
            come('load')
            # The last line is red: the file could not be loaded.
            words = lambda picture: {at for at in pixels(picture, lambda c: c[0] > 150 and c[1] < 90 and c[2] < 90)
                                     if at[1] > int(middle[1]) + 130}
            self.assertFalse(words(seen))
            window.settled(words, part=words).save(os.path.join(pictures, 'panel_answer.png'))
            # All live parameters by keys, in a window beside the panel: the second one, a number.
            told = rospy.Publisher('clay_simulator/parameter_descriptions', ConfigDescription, queue_size=1, latch=True)
            told.publish(ConfigDescription(
                groups=[Group(name='Default', parameters=[ParamDescription(name='quality', type='str'),
                                                          ParamDescription(name='viscosity', type='double')])],
                min=config('', 0.0), max=config('', 1e6), dflt=config('balanced', 100.0)))
            act('key', 'alt+m')
            rig_run.wait_until(lambda: graph.subscribed('/clay_simulator/parameter_descriptions'), 30.0, 'the table')

            def set_to(value):
                def typed():
                    act('key', 'Down')
                    act('type', '%d' % value)
                    act('key', 'Return')
                    rospy.rostime.wallsleep(0.5)
                    return ('viscosity', value) in asked
                rig_run.wait_until(typed, 30.0, 'the viscosity')
            set_to(250.0)
            window.settled(lambda picture: not words(picture), part=words).save(
                os.path.join(pictures, 'panel_parameters.png'))
            # Refused: the panel has the reason from the log of the node, if there is one, or says that it failed.
            lengths = []
            for value in REFUSED:
                set_to(value)
                refused = window.settled(words, part=words)
                lengths.append(len(words(refused)))
                refused.save(os.path.join(pictures, 'panel_refused%d.png' % len(lengths)))
            self.assertGreater(lengths[1], 1.2 * lengths[0], 'a line of a refusal is longer')
            self.assertEqual(holds, {'quality': 'balanced', 'viscosity': 250.0})


if __name__ == '__main__':
    rig_run.main('panel')
