#!/usr/bin/env python3
"""Runs a program in a ROS graph of its own: with_master.py PROGRAM [ARGUMENT]... Exits as the program does."""
import subprocess
import sys

import rig_run

with rig_run.Graph() as graph:
    code = subprocess.call(sys.argv[1:], env=graph.environment)
sys.exit(code)
