"""Trains a small detector of balls and robots on images of ``naoisis dataset``, on the CPU, in a quarter of an hour.

It trains on one data set and tests on another one, with other light, another field, and robots of another league::

    naoisis dataset hsl2026_middle --looks bright.json --size 320x240 --images 5000 --out train_set
    naoisis dataset spl2025 --looks dim.json --size 320x240 --images 500 --seed 100000 --out test_set
    python train_detector.py train_set test_set

Needs PyTorch and Pillow. The network has 83,000 parameters. It predicts a heat map of box centres for each class, and the size of the box
at each centre (Zhou et al., Objects as Points, arXiv 1904.07850). The result on the second data set measures the transfer between two
appearances of this simulator, not the transfer to real images.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
import torch
from PIL import Image
from torch import nn
from torch.nn import functional

CLASSES = ["ball", "robot"]
STRIDE = 4
# The least side of a box that counts in the test, pixels. Smaller objects are in the training, but count neither as found nor as missed.
LEAST_PX = 8


def load(folder: Path) -> tuple[np.ndarray, list[np.ndarray]]:
    """Returns all images of a data set, of all splits, and the boxes of each image: class, left, top, width and height, pixels."""
    images, boxes = [], []
    for path in sorted(folder.glob("*/_annotations.coco.json")):
        coco = json.loads(path.read_text())
        names = {category["id"]: category["name"] for category in coco["categories"]}
        of_image: dict[int, list] = {image["id"]: [] for image in coco["images"]}
        for annotation in coco["annotations"]:
            if names[annotation["category_id"]] in CLASSES:
                number = CLASSES.index(names[annotation["category_id"]])
                of_image[annotation["image_id"]].append([number, *annotation["bbox"]])
        for image in coco["images"]:
            images.append(np.asarray(Image.open(path.parent / image["file_name"])))
            boxes.append(np.array(of_image[image["id"]], dtype=np.float32).reshape(-1, 5))
    return np.stack(images), boxes


class Block(nn.Module):
    """A convolution with batch normalisation and ReLU, and a skip connection if input and output have the same shape."""

    def __init__(self, before: int, after: int, stride: int = 1, dilation: int = 1) -> None:
        super().__init__()
        self.convolution = nn.Conv2d(before, after, 3, stride, dilation, dilation, bias=False)
        self.norm = nn.BatchNorm2d(after)
        self.is_added = before == after and stride == 1

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        new = functional.relu(self.norm(self.convolution(features)))
        return features + new if self.is_added else new


class Detector(nn.Module):
    """The network. Its output channels are the logits of a heat map for each class, the position of the centre within its cell (x, y), and
    the logarithms of width and height in cells. A cell has 4 x 4 pixels."""

    def __init__(self) -> None:
        super().__init__()
        self.fine = nn.Sequential(Block(3, 12, 2), Block(12, 24, 2))
        self.coarse = nn.Sequential(
            Block(24, 48, 2), Block(48, 48), Block(48, 48, dilation=2), Block(48, 48, dilation=4)
        )
        self.narrow = nn.Conv2d(48, 24, 1)
        self.both = Block(24, 24)
        self.head = nn.Conv2d(24, len(CLASSES) + 4, 1)
        # The initial probability of a centre is low, because objects are rare.
        nn.init.constant_(self.head.bias[: len(CLASSES)], -4.0)

    def forward(self, images: torch.Tensor) -> torch.Tensor:
        fine = self.fine(images.permute(0, 3, 1, 2).float() / 255 - 0.5)
        coarse = self.narrow(self.coarse(fine))
        return self.head(self.both(fine + functional.interpolate(coarse, fine.shape[-2:], mode="nearest")))


def in_other_light(images: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """Augments the images: returns them with random brightness, contrast and colour, each drawn once for an image."""
    count = len(images)
    gain = draw.uniform(0.5, 1.4, (count, 1, 1, 1)) * draw.uniform(0.8, 1.25, (count, 1, 1, 3))
    middle = images.mean((1, 2), keepdims=True, dtype=np.float32)
    contrast, grey = draw.uniform(0.6, 1.4, (count, 1, 1, 1)), draw.uniform(0, 1, (count, 1, 1, 1)) ** 3
    changed = (middle + (images - middle) * contrast.astype(np.float32)) * gain.astype(np.float32)
    changed += (changed.mean(3, keepdims=True) - changed) * grey.astype(np.float32)
    return changed.clip(0, 255).astype(np.uint8)


def targets(boxes: list[np.ndarray], rows: int, columns: int) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Returns the target heat maps, the targets of the other four outputs, and the mask of the cells that have them.

    ``rows`` and ``columns`` are the numbers of cells.
    """
    heat = np.zeros((len(boxes), len(CLASSES), rows, columns), np.float32)
    shape = np.zeros((len(boxes), 4, rows, columns), np.float32)
    there = np.zeros((len(boxes), 1, rows, columns), np.float32)
    v, u = np.mgrid[:rows, :columns]
    for index, of_image in enumerate(boxes):
        for number, left, top, width, height in of_image:
            x, y = (left + width / 2) / STRIDE, (top + height / 2) / STRIDE
            column, row = min(int(x), columns - 1), min(int(y), rows - 1)
            sd = np.maximum([width / STRIDE / 6, height / STRIDE / 6], 0.5)
            bump = np.exp(-(((u - column) / sd[0]) ** 2 + ((v - row) / sd[1]) ** 2) / 2)
            heat[index, int(number)] = np.maximum(heat[index, int(number)], bump)
            shape[index, :, row, column] = [x - column, y - row, np.log(width / STRIDE), np.log(height / STRIDE)]
            there[index, 0, row, column] = 1
    return torch.from_numpy(heat), torch.from_numpy(shape), torch.from_numpy(there)


def loss(output: torch.Tensor, heat: torch.Tensor, shape: torch.Tensor, there: torch.Tensor) -> torch.Tensor:
    """Returns the focal loss of the heat maps, plus the L1 loss of the other outputs in the cells that have a centre, per object."""
    logits = output[:, : len(CLASSES)]
    probability = logits.sigmoid()
    is_centre = heat == 1
    found = functional.logsigmoid(logits) * (1 - probability) ** 2 * is_centre
    # Cells near a centre count less.
    avoided = functional.logsigmoid(-logits) * probability**2 * (1 - heat) ** 4 * ~is_centre
    count = is_centre.sum().clamp(min=1)
    return (
        -(found.sum() + avoided.sum()) / count
        + (functional.l1_loss(output[:, -4:], shape, reduction="none") * there).sum() / count
    )


def detections(output: torch.Tensor, least: float) -> list[np.ndarray]:
    """Returns the detections of each image with a score of at least ``least``, in descending order of their scores: class, left, top,
    width, height (pixels) and score."""
    heat = output[:, : len(CLASSES)].sigmoid()
    peaks = (heat == functional.max_pool2d(heat, 3, 1, 1)) & (heat >= least)
    found = []
    for index in range(len(output)):
        number, row, column = torch.nonzero(peaks[index], as_tuple=True)
        right, down, width, height = output[index, -4:, row, column]
        width, height = width.exp() * STRIDE, height.exp() * STRIDE
        left, top = (column + right) * STRIDE - width / 2, (row + down) * STRIDE - height / 2
        score = heat[index, number, row, column]
        order = score.argsort(descending=True)
        found.append(torch.stack([number.float(), left, top, width, height, score], 1)[order].numpy())
    return found


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    """Returns the intersection over union of two boxes: left, top, width, height."""
    low, high = np.maximum(one[:2], other[:2]), np.minimum(one[:2] + one[2:], other[:2] + other[2:])
    common = np.prod(np.maximum(high - low, 0))
    return float(common / (np.prod(one[2:]) + np.prod(other[2:]) - common))


def average_precision(found: list[np.ndarray], boxes: list[np.ndarray], number: int) -> tuple[float, float, float, int]:
    """Returns the average precision of the class ``number`` at an intersection over union of 0.5, recall and precision at a score of 0.3,
    and the number of objects."""
    marks, total = [], 0
    for of_image, truth in zip(found, boxes):
        of_class = [box[1:] for box in truth if box[0] == number]
        small = [box for box in of_class if min(box[2:]) < LEAST_PX]
        left = [box for box in of_class if min(box[2:]) >= LEAST_PX]
        total += len(left)
        for detection in of_image[of_image[:, 0] == number]:
            overlaps = [overlap(detection[1:5], box) for box in left]
            best = int(np.argmax(overlaps)) if overlaps else -1
            is_right = best >= 0 and overlaps[best] >= 0.5
            if is_right:
                left.pop(best)
            elif min(detection[3:5]) < LEAST_PX or any(overlap(detection[1:5], box) >= 0.3 for box in small):
                continue
            marks.append((detection[5], is_right))
    marks.sort(key=lambda mark: -mark[0])
    right = np.cumsum([mark[1] for mark in marks])
    precision = right / np.arange(1, len(marks) + 1)
    envelope = np.maximum.accumulate(precision[::-1])[::-1]
    ap = float(sum(envelope[index] for index, mark in enumerate(marks) if mark[1]) / max(total, 1))
    sure = sum(mark[0] >= 0.3 for mark in marks)
    return ap, float(right[sure - 1] / total) if sure else 0.0, float(precision[sure - 1]) if sure else 0.0, total


def report(name: str, detector: Detector, images: np.ndarray, boxes: list[np.ndarray]) -> list[float]:
    """Prints average precision, recall and precision of each class in a data set, and returns the average precisions."""
    detector.eval()
    with torch.no_grad():
        batches = [torch.from_numpy(images[start : start + 50]) for start in range(0, len(images), 50)]
        found = [of_image for batch in batches for of_image in detections(detector(batch), 0.02)]
    precisions = []
    for number, label in enumerate(CLASSES):
        ap, recall, precision, total = average_precision(found, boxes, number)
        print(
            f"{name}: {label}: AP50 {100 * ap:.1f} %, recall {100 * recall:.1f} %, precision {100 * precision:.1f} % of {total}"
        )
        precisions.append(ap)
    return precisions


def train(images: np.ndarray, boxes: list[np.ndarray], epochs: int, seed: int = 1) -> Detector:
    """Returns a detector trained on ``images`` and their ``boxes`` for ``epochs`` epochs."""
    torch.manual_seed(seed)
    order = np.random.default_rng(seed)
    detector = Detector()
    steps = epochs * (len(images) // 32)
    optimiser = torch.optim.AdamW(detector.parameters(), 2e-3, weight_decay=1e-4)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 4e-3, total_steps=max(steps, 1))
    rows, columns = -(-images.shape[1] // STRIDE), -(-images.shape[2] // STRIDE)
    for epoch in range(epochs):
        detector.train()
        begun, sums = time.monotonic(), 0.0
        batches = np.array_split(order.permutation(len(images)), max(len(images) // 32, 1))[: len(images) // 32 or 1]
        for batch in batches:
            of_batch, of_images = [boxes[index].copy() for index in batch], images[batch]
            if order.random() < 0.5:
                of_images = of_images[:, :, ::-1].copy()
                for of_image in of_batch:
                    of_image[:, 1] = images.shape[2] - of_image[:, 1] - of_image[:, 3]
            of_images = in_other_light(of_images, order)
            value = loss(detector(torch.from_numpy(of_images)), *targets(of_batch, rows, columns))
            optimiser.zero_grad()
            value.backward()
            optimiser.step()
            schedule.step()
            sums += value.item()
        print(
            f"epoch {epoch + 1} of {epochs}: loss {sums / len(batches):.3f}, {time.monotonic() - begun:.0f} s",
            flush=True,
        )
    return detector


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("train", type=Path, help="the folder of the data set to train on, in COCO format")
    parser.add_argument("test", type=Path, help="the folder of the data set to test on, with images of the same size")
    parser.add_argument("--epochs", type=int, default=6)
    arguments = parser.parse_args()
    images, boxes = load(arguments.train)
    unseen = load(arguments.test)
    detector = train(images, boxes, arguments.epochs)
    report("training images", detector, images[:500], boxes[:500])
    report("test images, other light and field", detector, *unseen)
    torch.save(detector.state_dict(), "detector.pt")


if __name__ == "__main__":
    main()
