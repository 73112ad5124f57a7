#!/usr/bin/env python3
"""Hands of the driver ros-drivers/leap_motion: see leap_motion.test."""
import math
import os
import subprocess
import unittest

import genpy.dynamic
import rospy
from rosgraph_msgs.msg import Log

import rig_messages
import rig_run
from array_stream import PROGRAMS
from tactile_clay.msg import TrackedHands

# The fields of its messages, without their comments, as `rosmsg show` lists definitions one after the other.
RULE = '=' * 80
DEFINITION = '\n'.join(['''std_msgs/Header header
int32 lmc_frame_id
int32 nr_of_hands
int32 nr_of_fingers
int32 nr_of_gestures
float32 current_frames_per_second
string to_string
Hand right_hand
Hand left_hand
''', RULE, '''MSG: leap_motion/Hand
std_msgs/Header header
int32 lmc_hand_id
bool is_present
bool valid_gestures
float32 time_visible
float32 confidence
float32 roll
float32 pitch
float32 yaw
geometry_msgs/Vector3 direction
geometry_msgs/Vector3 normal
float32 grab_strength
float32 pinch_strength
float32[] palm_velocity
geometry_msgs/Point palm_center
float32 palm_width
float32 sphere_radius
float32[] sphere_center
string to_string
Finger[] finger_list
Gesture[] gesture_list
Arm arm
''', RULE, '''MSG: leap_motion/Finger
std_msgs/Header header
int32 lmc_finger_id
uint8 type
float32 length
float32 width
string to_string
Bone[] bone_list
''', RULE, '''MSG: leap_motion/Bone
std_msgs/Header header
uint8 type
float32 length
float32 width
string to_string
geometry_msgs/Pose bone_start
geometry_msgs/Pose bone_end
float32[] center
''', RULE, '''MSG: leap_motion/Gesture
int32 lmc_gesture_id
bool is_valid
int64 duration_us
float32 duration_s
int32 gesture_state
int32 gesture_type
string to_string
int32[] pointable_ids
''', RULE, '''MSG: leap_motion/Arm
std_msgs/Header header
geometry_msgs/Pose elbow
geometry_msgs/Pose wrist
float32[] center
geometry_msgs/Vector3 direction
''', RULE, '''MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
''', RULE, '''MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
''', RULE, '''MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
''', RULE, '''MSG: geometry_msgs/Pose
Point position
Quaternion orientation
''', RULE, '''MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
'''])


def put(target, world):
    """Writes a point of `world` in the driver's axes, with the tracker at the world's origin."""
    target.x, target.y, target.z = -world[1], world[2], -world[0]


class LeapMotion(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node('leap_motion_test')

    def fill(self, kinds, message, hand):
        at = [(joint.position.x, joint.position.y, joint.position.z) for joint in hand.joints]
        message.is_present = True
        message.lmc_hand_id = 17
        message.confidence = 0.75
        message.to_string = 'a hand'
        message.palm_velocity = [0.0, 0.0, 0.0]
        message.sphere_center = [0.0, 0.0, 0.0]
        put(message.palm_center, at[0])
        put(message.arm.wrist.position, at[1])
        put(message.normal, rig_messages.rotate(hand.joints[0].orientation, (0, -1, 0)))
        put(message.direction, rig_messages.rotate(hand.joints[0].orientation, (0, 0, -1)))
        gesture = kinds['leap_motion/Gesture']()
        gesture.pointable_ids = [1, 2, 3]
        message.gesture_list.append(gesture)
        for number in range(5):
            first = 2 if number == 0 else 1 + 5 * number
            joints = at[first:first + (4 if number == 0 else 5)]
            if number == 0:
                joints.insert(0, joints[0])
            finger = kinds['leap_motion/Finger']()
            finger.type = number
            for kind, (start, end) in enumerate(zip(joints, joints[1:])):
                bone = kinds['leap_motion/Bone']()
                bone.type = kind
                bone.center = [0.0, 0.0, 0.0]
                put(bone.bone_start.position, start)
                put(bone.bone_end.position, end)
                finger.bone_list.append(bone)
            message.finger_list.append(finger)

    def test_hands_come_out_where_they_are(self):
        kinds = genpy.dynamic.generate_dynamic('leap_motion/Human', DEFINITION)
        hand = rig_run.Messages(rig_run.bag('press_finger'))['/hands/tracked'][0].hands[0]
        got = []
        rospy.Subscriber('hands/tracked', TrackedHands, got.append)
        driver = rospy.Publisher('leap_motion/leap_device', kinds['leap_motion/Human'], queue_size=1)
        self.addCleanup(driver.unregister)
        human = kinds['leap_motion/Human']()
        human.header.frame_id = 'leap_hands'
        self.fill(kinds, human.right_hand, hand)
        deadline = rospy.get_time() + 30
        while len(got) < 30 and rospy.get_time() < deadline and not rospy.is_shutdown():
            human.header.stamp = rospy.get_rostime()
            human.right_hand.palm_center.y += 1e-9  # a live hand trembles
            driver.publish(human)
            rospy.sleep(0.01)
        self.assertGreaterEqual(len(got), 30, 'no hands came')
        out = got[-1].hands
        self.assertEqual([(one.side, one.id) for one in out], [(hand.side, 17)])
        self.assertAlmostEqual(out[0].confidence, 0.75)
        for joint, expected in zip(out[0].joints, hand.joints):
            self.assertLess(math.dist((joint.position.x, joint.position.y, joint.position.z),
                                      (expected.position.x, expected.position.y, expected.position.z)), 1e-6)
        # It is then lost.
        human.right_hand.is_present = False
        deadline = rospy.get_time() + 30
        while got[-1].hands and rospy.get_time() < deadline:
            human.header.stamp = rospy.get_rostime()
            driver.publish(human)
            rospy.sleep(0.01)
        self.assertEqual(got[-1].hands, [])

    def test_a_finger_that_is_not_there_leaves_the_hand(self):
        kinds = genpy.dynamic.generate_dynamic('leap_motion/Human', DEFINITION)
        hand = rig_run.Messages(rig_run.bag('press_finger'))['/hands/tracked'][0].hands[0]
        got, lines = [], []
        rospy.Subscriber('/rosout', Log, lambda line: lines.append(line.msg))
        rospy.Subscriber('hands/tracked', TrackedHands, got.append)
        driver = rospy.Publisher('leap_motion/leap_device', kinds['leap_motion/Human'], queue_size=1)
        self.addCleanup(driver.unregister)

        def no_little_finger(fingers):
            fingers.pop()

        def bone_of_nan(fingers):
            fingers[4].bone_list[2].bone_end.position.x = math.nan

        for spoil, words in ((no_little_finger, 'no pointable for this finger'),
                             (bone_of_nan, 'little_distal: dipPosition is not finite')):
            with self.subTest(spoil.__name__):
                human = kinds['leap_motion/Human']()
                human.header.frame_id = 'leap_hands'
                self.fill(kinds, human.right_hand, hand)
                spoil(human.right_hand.finger_list)
                told = lambda: any('little finger left out: joint ' in line and words in line for line in lines)
                deadline = rospy.get_time() + 30
                del got[:]
                while (len(got) < 30 or not told()) and rospy.get_time() < deadline and not rospy.is_shutdown():
                    human.header.stamp = rospy.get_rostime()
                    human.right_hand.palm_center.y += 1e-9  # a live hand trembles
                    driver.publish(human)
                    rospy.sleep(0.01)
                self.assertTrue(told(), lines)
                self.assertEqual(len(got[-1].hands), 1)
                radii = got[-1].hands[0].radii
                self.assertEqual([radii[joint] > 0.0 for joint in (20, 25)], [True, False])  # tips: ring, little

    def test_another_definition_is_told(self):
        older = DEFINITION.replace('Arm arm\n', '').replace('float32 palm_width\n', '')
        lines = []
        rospy.Subscriber('/rosout', Log, lambda line: lines.append(line.msg))
        kinds = genpy.dynamic.generate_dynamic('leap_motion/Human', older)
        driver = rospy.Publisher('/other/leap_motion/leap_device', kinds['leap_motion/Human'], queue_size=1)
        # One of its own: a subscriber keeps to the definition that it met first.
        tracking = subprocess.Popen([os.path.join(PROGRAMS, 'hand_tracking'), '__ns:=/other', '_source:=leap_motion'])
        self.addCleanup(tracking.wait)
        self.addCleanup(tracking.terminate)
        told = rospy.get_name() + ' sends another version of leap_motion/Human (md5 '
        deadline = rospy.get_time() + 30
        while not any(told in line for line in lines) and rospy.get_time() < deadline:
            driver.publish()
            rospy.sleep(0.02)
        self.assertTrue(any(told in line for line in lines), lines)


if __name__ == '__main__':
    rig_run.main('leap_motion')
