"""Writes a contact sheet of 48 random images of a data set: ``python contact_sheet.py DATA_SET sheet.jpg``. Needs Pillow."""

import random
import sys
from pathlib import Path

from PIL import Image

COLUMNS, ROWS, WIDTH, HEIGHT = 6, 8, 208, 156

images = sorted(Path(sys.argv[1]).rglob("*.jpg"))
chosen = random.Random(1).sample(images, min(COLUMNS * ROWS, len(images)))
sheet = Image.new("RGB", (COLUMNS * WIDTH, ROWS * HEIGHT))
for index, path in enumerate(chosen):
    image = Image.open(path).resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
    sheet.paste(image, (index % COLUMNS * WIDTH, index // COLUMNS * HEIGHT))
sheet.save(sys.argv[2], quality=80)
