# SPDX-License-Identifier: MIT
"""Line plots with logarithmic axes as SVG text, without any library."""
import math

WIDTH, HEIGHT = 640, 400
LEFT, RIGHT, TOP, BOTTOM = 76, 190, 36, 52
COLOURS = ("#0b63b5", "#d1495b", "#2e8540", "#8a5a00", "#6b4fa0", "#444444")


def grouped(value):
    return f"{value:,.0f}" if value >= 1 else f"{value:g}"


def ticks(low, high):
    """1, 2, 5 times powers of ten within [low, high], thinned to the powers where there are many."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    many = [f * 10.0**p for p in powers for f in (1, 2, 5)]
    within = [t for t in many if low * 0.999 <= t <= high * 1.001]
    if len(within) <= 7:
        return within
    return [10.0**p for p in powers if low * 0.999 <= 10.0**p <= high * 1.001]


def escaped(text):
    return text.replace("&", "&amp;").replace("<", "&lt;")


class Axis:
    def __init__(self, values, begin, end):
        self.low, self.high = min(values) / 1.25, max(values) * 1.25
        self.begin, self.end = begin, end

    def at(self, value):
        part = math.log(value / self.low) / math.log(self.high / self.low)
        return self.begin + part * (self.end - self.begin)


def line_plot(title, x_label, y_label, series):
    """SVG of series {label: [(x, y), ...]}, all numbers > 0; labels beside the last points."""
    points = [point for line in series.values() for point in line]
    x = Axis([p[0] for p in points], LEFT, WIDTH - RIGHT)
    y = Axis([p[1] for p in points], HEIGHT - BOTTOM, TOP)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
             f'width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12">',
             f'<title>{escaped(title)}</title><rect width="100%" height="100%" fill="white"/>',
             f'<text x="{LEFT}" y="22" font-size="14">{escaped(title)}</text>']
    for tick in ticks(x.low, x.high):
        at = x.at(tick)
        parts.append(f'<path d="M{at:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/><text x="{at:.1f}" '
                     f'y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{grouped(tick)}</text>')
    for tick in ticks(y.low, y.high):
        at = y.at(tick)
        parts.append(f'<path d="M{LEFT} {at:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/><text x="{LEFT - 8}" '
                     f'y="{at + 4:.1f}" text-anchor="end">{grouped(tick)}</text>')
    middle = (LEFT + WIDTH - RIGHT) / 2
    parts.append(f'<text x="{middle}" y="{HEIGHT - 12}" text-anchor="middle">{escaped(x_label)}</text>')
    parts.append(f'<text transform="translate(18 {HEIGHT / 2}) rotate(-90)" '
                 f'text-anchor="middle">{escaped(y_label)}</text>')
    free = TOP + 4.0  # labels never lie upon each other
    for number, (label, line) in enumerate(
            sorted(series.items(), key=lambda item: -sorted(item[1])[-1][1])):
        colour, line = COLOURS[number % len(COLOURS)], sorted(line)
        path = "L".join(f"{x.at(a):.1f} {y.at(b):.1f}" for a, b in line)
        parts.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        parts += [f'<circle cx="{x.at(a):.1f}" cy="{y.at(b):.1f}" r="3.5" fill="{colour}"/>'
                  for a, b in line]
        free = max(free, y.at(line[-1][1]) + 4)
        parts.append(f'<text x="{WIDTH - RIGHT + 8}" y="{free:.1f}" '
                     f'fill="{colour}">{escaped(label)}</text>')
        free += 16
    return "\n".join(parts) + "\n</svg>\n"
