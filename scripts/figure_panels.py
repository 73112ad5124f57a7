"""What each picture of the documents shows: its runs, moments and views. A module of `figure`, no program."""
import math
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WIDTH, HEIGHT = 1400, 900  # pixels of the window
BAGS = os.path.join(ROOT, 'test', 'bags')

CLAY, BALLS = 'Clay', 'Clay as balls'
HANDS, PRESSURE = 'Hands, with the pressure on their skin', 'Samples of the pressure'
SKIN, POINTS, ARRAY = 'Samples of the skin', 'Focal points', 'Array'
TRANSDUCERS, STATE, SLICE = 'Transducers, by phase and amplitude', 'State of the rig', 'Slice of the sound'
RENDERED, TABLE, FORCES = 'Wanted and given pressure, side by side', 'Table and wheel', 'Forces on the clay'


def view(yaw=3.55, pitch=0.5, distance=0.55, focus=(0.0, 0.0, -0.02), **displays):
    """A camera, and what it shows: a tuple of names `only`, else the default view with `plus` and without `minus`."""
    return dict(yaw=yaw, pitch=pitch, distance=distance, focus=focus, **displays)


def panel(run, at, camera, size=(WIDTH, HEIGHT), middle=(0.5, 0.5), caption='', change=None, rendered=None):
    """One picture: a run, s of its input, a view, and what is cut out of the window (pixels; shares of the window).
    `rendered` names a picture of hands/rendered: its errors and its colour bar are written beside it."""
    return dict(run=run, at=at, view=camera, size=size, middle=middle, caption=caption, change=change,
                rendered=rendered, legend=size != (WIDTH, HEIGHT))


def bag(name):
    return dict(hands='bag', file=os.path.join(BAGS, name + '.bag'))


def palms(run, at, picture, caption):
    """One of the pictures of hands/rendered: both hands, seen from the front, and no more."""
    aside = {'wanted': 0.17, 'weight': 0.51, 'given': -0.17}[picture]
    return panel(run, at, view(only=(RENDERED,), yaw=math.pi, pitch=0.0, distance=0.55, focus=(0.28, aside, 0.17)),
                 size=(480, 440), middle=(0.5, 0.49), caption=caption, rendered=picture)


def incline(kind):
    return dict(scene='incline' + kind, hands='none')


def config(*names):
    with open(os.path.join(ROOT, 'config', *names)) as file:
        return file.read()


def scene_of(material, folder):
    """The kindergarten of another material: NAME, or NAME,KEY=VALUE for one with another number."""
    name, *change = material.split(',')
    if change:
        key, value = change[0].split('=')
        text, count = re.subn('^%s:.*' % key, '%s: %s' % (key, value), config('materials', name + '.yaml'), flags=re.M)
        if count != 1:
            sys.exit("figure: material %s has no '%s'" % (name, key))
        name += '_' + key
        with open(os.path.join(folder, name + '.yaml'), 'w') as file:
            file.write(text)
    text = config('scenes', 'kindergarten.yaml').replace('modelling_clay', name)
    text = text.replace('urdf: table.urdf', 'urdf: ' + os.path.join(ROOT, 'config', 'urdf', 'table.urdf'))
    path = os.path.join(folder, 'scene_of_%s.yaml' % name)
    with open(path, 'w') as file:
        file.write(text)
    return path


def figures(materials, folder):
    """For each figure its panels by rows, and the panels of the first row, first and last moment of its animation."""
    kneading = dict(scene='kindergarten', **bag('knead'))
    knead = dict(kneading, modulation='am')  # the paper's focal points
    potter = dict(scene='potters_wheel', **bag('potter'))
    touch = view(yaw=math.pi, pitch=0.12, distance=1.0, focus=(0.28, 0.17, 0.17), only=(RENDERED,))
    slope = view(yaw=4.71, pitch=0.2, distance=0.55, focus=(0.05, 0.0, 0.0), only=(CLAY, TABLE))
    slopes = (('', 'full model'), ('_no_viscosity', 'no viscosity'), ('_no_bonds', 'no elastoplasticity'),
              ('_no_friction', 'no friction'))
    third = (460, 460)
    table = view(distance=0.82, pitch=0.8, focus=(-0.02, 0.0, 0.0), minus=(STATE,))
    wheel = view(distance=0.68, pitch=0.7, focus=(0.0, 0.0, 0.02), minus=(STATE,))
    press = bag('press_deeper')
    moment = 3.23333  # s; two fingers press with their pads
    return {
        'rig': ([[panel(kneading, 3.2, view(minus=(STATE,)))]], None),
        'soft_hand': ([[panel(dict(scene='stiff_bar', hands='choreography', file='press_bar', hand_model='soft'), 2.6,
                              view(yaw=5.15, pitch=0.2, distance=0.24, focus=(0.03, 0.0, 0.04), plus=(BALLS,),
                                   minus=(CLAY, POINTS, STATE)), change=('Clay as balls', 'Alpha', 0.35))]], None),
        'print': ([[panel(dict(scene='plasticine', hands='choreography', file='press_thumb'), at,
                          view(yaw=3.7, pitch=0.65, distance=0.16, focus=(0.0, 0.0, 0.012), only=(CLAY, TABLE) + hands),
                          size=third, caption=words)
                    for at, words, hands in ((0.1, 'before', ()), (1.85, 'a thumb presses', (HANDS,)),
                                             (3.3, 'after', ()))]], None),
        'touch': ([[panel(kneading, moment, touch, size=(1300, 400), middle=(0.5, 0.46))]], None),
        '2': ([[panel(incline(kind), at, slope, size=(330, 220), middle=(0.5, 0.46), caption=words if at < 0.2 else '')
                for kind, words in slopes] for at in (0.1, 0.2, 1.1)], ((0, 1, 2, 3), 0.0, 1.2)),
        '3': ([[panel(knead, moment, view(yaw=3.4, pitch=0.42, distance=0.62, focus=(0.0, 0.0, 0.04),
                                          only=(BALLS, SKIN, TABLE, FORCES)), size=third,
                      caption='forces on the particles of the clay', change=(SKIN, 'Size (m)', 0.003, 'Alpha', 1)),
                panel(knead, moment, view(yaw=math.pi, pitch=-1.0, distance=0.59, focus=(0.0, 0.0, 0.03),
                                          only=(HANDS,)), size=third, middle=(0.5, 0.459),
                      caption='pressure on the skin'),
                panel(knead, moment, view(yaw=3.4, pitch=0.25, distance=0.68, focus=(0.0, 0.0, -0.04),
                                          only=(HANDS, POINTS, ARRAY, TRANSDUCERS, SLICE)), size=third,
                      caption='focal points, and a slice of their sound', change=(POINTS, 'Numbers', False))]],
              ((0, 1, 2), 1.4, 5.0)),
        '4': ([[palms(knead, moment, 'wanted', 'wanted by the clay'),
                palms(knead, moment, 'given', 'given, with weights')],
               [palms(knead, moment, 'weight', 'weights'),
                palms(dict(knead, perceptual_weights='false'), moment, 'given', 'given, without weights')]],
              ((0, 1), 1.4, 5.0)),
        '5': ([[panel(knead, at, table, size=third) for at in (1.5, 3.2, 11.8)]], ((0,), 1.4, 5.8)),
        '6': ([[panel(dict(press, scene=scene_of(material, folder)), 1.6,
                      view(yaw=3.9, pitch=0.3, distance=0.26, focus=(0.045, 0.05, 0.03), only=(CLAY, HANDS, TABLE)),
                      size=(560, 460), caption=re.sub('[_,]+', ' ', material)) for material in materials]],
              ((0, 1), 0.6, 1.8)),
        '7': ([[panel(potter, at, wheel, size=third) for at in (1.0, 2.6, 7.9)]], ((0,), 0.6, 5.6)),
    }
