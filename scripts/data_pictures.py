#!/usr/bin/env python3
"""Writes the pictures that scenes in data/ are coloured and lit by: python3 scripts/data_pictures.py"""

import math
import random
import struct
import zlib
from pathlib import Path

DATA = Path(__file__).resolve().parent.parent / "data"


def write_png(name, width, height, pixel, bits=8):
    """`pixel(x, y)` gives red, green and blue from 0 to 1, as they are stored: by sRGB's curve for colours."""
    most = (1 << bits) - 1
    code = struct.Struct(">3B" if bits == 8 else ">3H")
    rows = []
    for y in range(height):
        values = (tuple(round(most * min(max(c, 0.0), 1.0)) for c in pixel(x, y)) for x in range(width))
        rows.append(b"\0" + b"".join(code.pack(*value) for value in values))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0)
    body = zlib.compress(b"".join(rows), 9)
    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b"")
    (DATA / name).write_bytes(png)


def stripes(x, _):
    return (0.85, 0.8, 0.7) if x // 4 % 2 else (0.2, 0.35, 0.55)


def tiles(x, y):
    if x % 32 < 2 or y % 32 < 2:
        return 0.85, 0.85, 0.82
    tone = random.Random(x // 32 * 64 + y // 32).uniform(-0.06, 0.06)
    return 0.25 + tone, 0.55 + tone, 0.62 + tone


def boards(x, y):
    board = x // 16
    noise = random.Random(board * 97)
    tone, phase = noise.uniform(-0.08, 0.08), noise.uniform(0, 6)
    grain = 0.03 * math.sin(0.9 * (x % 16) + phase + 0.6 * math.sin(y / 23 + phase))
    gap = 0.25 if x % 16 == 0 else 0
    return tuple(c + tone + grain - gap for c in (0.62, 0.45, 0.3))


def brushed(_, y):
    """A roughness, plain."""
    alpha = 0.12 + 0.3 * (0.5 + 0.5 * math.sin(y * 2 * math.pi / 16))
    return alpha, alpha, alpha


def screen(x, y, width=192, height=128):
    """An opacity, plain: a frame around petals and rings that are cut out, in squares of 32 pixels."""
    if min(x, y, width - 1 - x, height - 1 - y) < 4:
        return 1, 1, 1
    u, v = (x % 32 - 15.5) / 16, (y % 32 - 15.5) / 16
    away, petals = math.hypot(u, v), 0.55 + 0.3 * math.cos(4 * math.atan2(v, u))
    is_cut = 0.16 < away < petals if (x // 32 + y // 32) % 2 else 0.35 < away < 0.8
    return (0, 0, 0) if is_cut else (1, 1, 1)


def evening(x, y, width=128, height=64):
    """A sky that glows around a low sun; below the horizon dark ground."""
    up = math.cos(math.pi * (y + 0.5) / height)
    if up < 0:
        return 0.16, 0.13, 0.12
    away = math.hypot((x - 0.5 * width) / width * 2 * math.pi, 0.22 - math.asin(up))
    glow = math.exp(-away * away / 0.5)
    sky = [0.25 - 0.1 * up + 0.5 * glow, 0.3 - 0.05 * up + 0.22 * glow, 0.45 - 0.08 * up + 0.05 * glow]
    return (1.0, 0.92, 0.75) if away < 0.12 else tuple(sky)


def main():
    write_png("stripes.png", 64, 4, stripes)
    write_png("tiles.png", 256, 256, tiles)
    write_png("boards.png", 128, 128, boards)
    write_png("brushed.png", 4, 64, brushed)
    write_png("screen.png", 192, 128, screen)
    write_png("evening.png", 128, 64, evening, bits=16)


if __name__ == "__main__":
    main()
