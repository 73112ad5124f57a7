"""The files that a rig was made of, with their texts. A module of `describe_rig`, no program."""
import base64
import os
import re
import zlib
from xml.etree import ElementTree

import rospkg
import yaml

from rig_tools import find_file, path_of

LARGEST_MESH = 64 << 20   # bytes of a collision mesh that a bag takes
LARGEST_TEXT = 16 << 20   # bytes of a file, as its loaders have it
CORRECTIONS = ('corrections', 'second_corrections', 'firmware_corrections')


class Names(yaml.SafeLoader):
    """Reads each scalar as the text that it is, so that a material may be called 007; keeps merge keys."""


Names.yaml_implicit_resolvers = {'<': yaml.SafeLoader.yaml_implicit_resolvers['<']}


class Files:
    """The files that a rig was made of, each with its text or its data."""

    def __init__(self, share):
        self.share, self.list = share, []

    def config(self, *names):
        return os.path.join(self.share, 'config', *names)

    def entry(self, role, name, path=None):
        path = None if path is None else os.path.abspath(path)
        inside = path is not None and path.startswith(self.share + '/')
        # Of a file of the package the path is that in the package, wherever that is installed.
        entry = {'role': role, 'name': name, 'path': os.path.relpath(path, self.share) if inside else path}
        self.list.append(entry)
        return entry

    def add(self, role, name, find, text=None):
        """Adds the file that find() gives, with its text unless one is given. Returns (path, text), or (None, '') where
        it cannot be read."""
        try:
            path = find()
            if text is None:
                text = read(path, LARGEST_TEXT).decode('utf-8-sig')
            self.entry(role, name, path)['text'] = text
            return path, text
        except (OSError, UnicodeDecodeError, rospkg.ResourceNotFound) as error:
            self.entry(role, name)['missing'] = str(error)
            return None, ''

    def add_data(self, role, name, find):
        try:
            path = find()
            data = read(path, LARGEST_MESH)
            self.entry(role, name, path)['zlib'] = base64.b64encode(zlib.compress(data)).decode()
        except (OSError, rospkg.ResourceNotFound) as error:
            self.entry(role, name)['missing'] = str(error)


def read(path, most):
    with open(path, 'rb') as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError("'%s' has more than %d bytes" % (path, most))
    return data


def scene_files(files, scene, model, material):
    """Adds the scene with its materials, meshes and robot model. `model`: text of robot_description, or None;
    `material`: that which stands for those of all bodies, or an empty text."""
    path, text = files.add('scene', scene, lambda: find_file(scene, '', files.config('scenes'), '.yaml'))
    try:
        content = yaml.load(text, Names) or {}
        bodies = [body for body in content.get('bodies') or [] if isinstance(body, dict)]
        urdf = content.get('urdf')
    except (yaml.YAMLError, AttributeError):
        return  # the clay refuses it, with a line
    beside = os.path.dirname(path or '')
    own = {body['material'] for body in bodies if isinstance(body.get('material'), str)}
    for name in sorted(own | ({material} if material else set())):
        files.add('material', name, lambda: find_file(name, beside, files.config('materials'), '.yaml'))
    for name in sorted({body['mesh'] for body in bodies if isinstance(body.get('mesh'), str)}):
        files.add_data('mesh', name, lambda: path_of(name, beside))
    if not isinstance(urdf, str):
        return
    urdf_path, model = files.add('urdf', urdf, lambda: find_file(urdf, beside, files.config('urdf'), '.urdf'), model)
    try:
        collisions = ElementTree.fromstring(model.encode()).iterfind('.//collision//mesh')
        meshes = sorted({mesh.get('filename', '') for mesh in collisions})
    except ElementTree.ParseError:
        return
    for name in meshes:
        files.add_data('collision mesh', name, lambda: path_of(name, os.path.dirname(urdf_path or '')))


def correction_files(files, options):
    """Adds the calibration files that the options of a device name."""
    if not isinstance(options, dict):
        options = dict(re.findall(r'(\S+?)=(.*?)(?=\s+\S+=|\s*$)', str(options)))
    for key in CORRECTIONS:
        name = str(options.get(key, 'none'))
        if name != 'none':
            files.add(key, name, lambda: name)
