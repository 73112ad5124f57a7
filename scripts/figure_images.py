"""Images of the screen cut, captioned, joined and animated. A module of `figure`, no program."""
import functools
import os
import subprocess

from figure_panels import HEIGHT, WIDTH

BACKGROUND = bytes((236, 238, 241))  # of rig.rviz
BACKGROUND_NAME = 'rgb(%d,%d,%d)' % tuple(BACKGROUND)  # for convert
CAPTION = 34               # pixels
FRAMES_A_SECOND = 10       # of animations
# Colours of pressure on the skin at equal distances from nothing to the full scale: those of hand_surface.
PRESSURE_COLORS = ((1.0, 0.93, 0.45), (1.0, 0.62, 0.10), (0.86, 0.14, 0.16), (0.38, 0.0, 0.22))
FULL_SCALE = 40            # kPa, of hand_surface


@functools.lru_cache()
def font():
    """ImageMagick's own choice is a font that Debian does not install with it."""
    return ['-font', subprocess.run(['fc-match', '--format', '%{file}', 'sans'], stdout=subprocess.PIPE,
                                    check=True).stdout]


def save(picture, panel_, path, told=None):
    """Cuts a panel out of an image of the window. `told`: a second line for the caption, and the full scale with its
    unit for a colour bar."""
    (width, height), (x, y) = panel_['size'], panel_['middle']
    left, top = round(x * WIDTH - 0.5 * width), round(y * HEIGHT - 0.5 * height)
    cut = ['-crop', '%dx%d+%d+%d' % (width, height, max(0, left), max(0, top)), '+repage']
    lines = [line for line in (panel_['caption'], told[0] if told else '') if line]
    words = [] if not lines else ['-background', BACKGROUND_NAME, '-gravity', 'north', '-splice',
                                  '0x%d' % (CAPTION if told is None else 2 * CAPTION),
                                  *font(), '-pointsize', '20', '-annotate', '+0+6', '\n'.join(lines).replace('%', '%%')]
    subprocess.run(['convert', '-size', '%dx%d' % (WIDTH, HEIGHT), '-depth', '8', 'rgb:-'] + cut + words + [path],
                   input=picture,
                   check=True)
    if told:
        bar = path + '.bar.png'
        legend(bar, '', told[1], width // 2)
        joined([[path], [bar]], path, False)


def legend(path, title='pressure on the skin  ', full_scale='%d kPa' % FULL_SCALE, width=300):
    """The colours of pressure with their numbers, to lie below a figure."""
    height = 14
    line = b''
    for x in range(width):
        at = (len(PRESSURE_COLORS) - 1) * x / width
        k = int(at)
        line += bytes(round(255 * (a + (at - k) * (b - a))) for a, b in zip(PRESSURE_COLORS[k], PRESSURE_COLORS[k + 1]))
    words = lambda text, gravity: ['(', '-background', BACKGROUND_NAME, '-gravity', gravity, *font(), '-pointsize',
                                   '18', '-size', '%dx%d' % (260 if title else 100, CAPTION), 'caption:' + text, ')']
    bar = ['(', '-size', '%dx%d' % (width, height), '-depth', '8', 'rgb:-', '-background', BACKGROUND_NAME,
           '-gravity', 'center', '-extent', '%dx%d' % (width + 16, CAPTION), ')']
    subprocess.run(['convert'] + words(title + ' 0 ', 'east') + bar +
                   words(' ' + full_scale, 'west') +
                   ['+append', path], input=line * height, check=True)


def joined(rows, output, trim, below=None):
    command = ['convert']
    for row in rows:
        command += ['('] + row + ['+append', ')']
    command += ['-background', BACKGROUND_NAME, '-gravity', 'center'] + [below] * bool(below) + ['-append']
    if trim:  # the background is rig.rviz's
        command += ['-trim', '+repage', '-bordercolor', BACKGROUND_NAME, '-border', '24']
    os.makedirs(os.path.dirname(os.path.abspath(output)), exist_ok=True)
    subprocess.run(command + ['-strip', '-alpha', 'off', '-depth', '8', output],
                   check=True)


def moments(animation):
    """Those of an animation, s."""
    _, first, last = animation
    return [first + k / FRAMES_A_SECOND for k in range(round((last - first) * FRAMES_A_SECOND))]


def frame(folder, column, k):
    return os.path.join(folder, 'frame%s_%03d.png' % (column, k))


def animate(animation, output, folder):
    """Joins the frames of the panels side by side, and these to an animation."""
    columns = animation[0]
    for k in range(len(moments(animation))):
        subprocess.run(['convert'] + [frame(folder, j, k) for j in columns] + ['+append', frame(folder, '', k)],
                       check=True)
    subprocess.run(['ffmpeg', '-y', '-loglevel', 'error', '-framerate', str(FRAMES_A_SECOND), '-i',
                    os.path.join(folder, 'frame_%03d.png'), '-vf',
                    'scale=%d:-1,split[a][b];[a]palettegen=max_colors=128[p];'
                    '[b][p]paletteuse=dither=none:diff_mode=rectangle' % (80 + 240 * len(columns)),
                    output], check=True)
