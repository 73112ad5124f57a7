"""Files of a user's own, of which a rig is made: a scene, materials, a mesh, a table. A module of tests."""
import os

import rig_run

SCENE = """# Three blocks of three materials
spacing: 0.006
urdf: my_table.urdf
bodies:
  - {name: red, material: soft.yaml, shape: box, size: [0.04, 0.04, 0.04], pose: [0.045, 0.05, 0, 0, 0, 0.3]}
  - {name: far, material: %s/else where/own.yaml, shape: box, size: [0.02, 0.02, 0.02],
     pose: [-0.05, -0.05, 0, 0, 0, 0]}
  - {name: wedge, material: putty, shape: mesh, mesh: wedge.stl, pose: [-0.05, 0.08, 0, 0, 0, 0]}
"""
CORNERS = ((0, 0, 0), (0.03, 0, 0), (0, 0.03, 0), (0, 0, 0.03))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def write(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, 'w') as file:
        file.write(text)


def config(*names):
    with open(os.path.join(rig_run.PACKAGE, 'config', *names)) as file:
        return file.read()


OWN_RIG = 'temperature: 24.5\nfull_scale_pressure: 300000.0\n'


def own_files(folder):
    """A scene of the user's own: materials beside it, by an absolute name and of the package; a mesh; a table."""
    scene = os.path.join(folder, 'mine.yaml')
    write(scene, SCENE % folder)
    write(os.path.join(folder, 'else where', 'own.yaml'), config('materials', 'dough.yaml'))
    write(os.path.join(folder, 'soft.yaml'), config('materials', 'modelling_clay.yaml') + 'adhesion: 50\n')
    write(os.path.join(folder, 'my_table.urdf'), config('urdf', 'table.urdf'))
    facets = ''.join('facet normal 0 0 0\nouter loop\n%sendloop\nendfacet\n' %
                     ''.join('vertex %g %g %g\n' % CORNERS[k] for k in face) for face in FACES)
    write(os.path.join(folder, 'wedge.stl'), 'solid wedge\n%sendsolid wedge\n' % facets)
    return scene
