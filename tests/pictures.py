"""HTML and SVG read back: that it is well formed, and what is drawn where."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np

VOID = {"br", "meta", "input"}


class _Reader(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.words, self.tags = [], [], set()

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.add(tag)

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def read(html):
    """The tags and the words of some HTML, every element of which is closed."""
    reader = _Reader()
    reader.feed(html)
    reader.close()
    assert not reader.open, reader.open
    return reader.tags, " ".join(" ".join(reader.words).split())


def drawn(html, number=0):
    """The shapes of an SVG in some HTML: tag, attributes and corners in pixels, y upwards, shape (n, 2)."""
    text = re.findall(r"<svg.*?</svg>", html, re.DOTALL)[number]
    shapes = []
    for item in ElementTree.fromstring(text):
        if "points" in item.attrib:
            points = [[float(x) for x in pair.split(",")] for pair in item.get("points").split()]
            shapes.append((item.tag.rpartition("}")[2], item.attrib, np.array(points) * [1.0, -1.0]))
    return shapes


def of_colour(html, colour, tag="polyline", number=0):
    """Corners of the shapes of a colour, of what kind."""
    key = "stroke" if tag == "polyline" else "fill"
    return [points for kind, given, points in drawn(html, number) if kind == tag and given.get(key) == colour]
