"""Data sets of images, read by readers that are not ours: pycocotools, supervision, and tarfile."""

import json
import subprocess
import tarfile

import numpy as np
import pytest

SIZE = (160, 120)
SPLITS = {"train": "train", "valid": "val", "test": "test"}


def _make(folder, *arguments):
    subprocess.run(
        [
            "naoisis",
            "dataset",
            "match3v3",
            "--out",
            folder,
            "--images",
            "24",
            "--size",
            "160x120",
            "--quiet",
            *arguments,
        ],
        check=True,
    )
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A data set in all layouts, with masks and depth, and one with outlines."""
    folder = tmp_path_factory.mktemp("datasets")
    _make(folder / "boxes", "--format", "coco,yolo,webdataset", "--masks", "--depth", "--names", "hulks")
    _make(folder / "outlines", "--format", "yolo", "--yolo", "segment", "--names", "hulks")
    _make(folder / "pose", "--format", "yolo", "--yolo", "pose")
    return folder


def _coco(folder, split):
    return json.loads((folder / "boxes" / split / "_annotations.coco.json").read_text())


def test_pycocotools_reads_boxes_and_outlines(made):
    coco_tools = pytest.importorskip("pycocotools.coco")
    evaluation = pytest.importorskip("pycocotools.cocoeval")
    count = 0
    for split in SPLITS:
        coco = coco_tools.COCO(made / "boxes" / split / "_annotations.coco.json")
        assert [coco.cats[number]["name"] for number in sorted(coco.cats)][:3] == ["Ball", "Robot", "GoalPost"]
        for annotation in coco.anns.values():
            mask = coco.annToMask(annotation)
            assert mask.shape == (SIZE[1], SIZE[0])
            # Outlines are within a pixel of the edges.
            assert abs(int(mask.sum()) - annotation["area"]) <= 5 + 0.06 * annotation["area"], annotation
            rows, columns = np.nonzero(mask)
            left, top, width, height = annotation["bbox"]
            assert left <= columns.min() and columns.max() < left + width + 1
            assert top <= rows.min() and rows.max() < top + height + 1
            count += 1
        # The annotations themselves, as results, are right about all of themselves.
        if split == "train":
            keys = ("image_id", "category_id", "bbox")
            results = [{key: annotation[key] for key in keys} | {"score": 1.0} for annotation in coco.anns.values()]
            score = evaluation.COCOeval(coco, coco.loadRes(results), "bbox")
            score.evaluate()
            score.accumulate()
            score.summarize()
            assert score.stats[0] == pytest.approx(1.0)
    assert count > 40


def test_masks_and_depth_belong_to_the_boxes(made):
    plt = pytest.importorskip("matplotlib.pyplot")
    ball = 4
    seen = 0
    for split in SPLITS:
        coco = _coco(made, split)
        names = {image["id"]: image["file_name"].removesuffix(".jpg") for image in coco["images"]}
        for annotation in coco["annotations"]:
            if annotation["category_id"] != 0:
                continue
            name = names[annotation["image_id"]]
            colours = (plt.imread(made / "boxes" / "masks" / split / f"{name}.png")[..., :3] * 255).round().astype(int)
            is_ball = (colours == [255, 120, 0]).all(axis=-1)
            assert is_ball.sum() == annotation["area"], ball
            depth = plt.imread(made / "boxes" / "depth" / split / f"{name}.png") * 65535 / 1000
            distance = annotation["attributes"]["distance_m"]
            assert 0.3 * distance < depth[is_ball].min() <= depth[is_ball].max() < 1.05 * distance
            seen += 1
    assert seen > 5


def test_supervision_reads_the_layout_of_ultralytics(made):
    supervision = pytest.importorskip("supervision")
    for split, folder in SPLITS.items():
        coco = _coco(made, split)
        boxes = made / "boxes"
        places = {"images_directory_path": str(boxes / "images" / folder), "data_yaml_path": str(boxes / "data.yaml")}
        read = supervision.DetectionDataset.from_yolo(
            annotations_directory_path=str(boxes / "labels" / folder), **places
        )
        assert read.classes == [category["name"] for category in coco["categories"]]
        assert len(read) == len(coco["images"])
        by_name = {image["file_name"]: image["id"] for image in coco["images"]}
        for path, image, detections in read:
            assert image.shape == (SIZE[1], SIZE[0], 3)
            number = by_name[path.replace("\\", "/").rsplit("/", 1)[-1]]
            expected = [it for it in coco["annotations"] if it["image_id"] == number]
            assert list(detections.class_id) == [it["category_id"] for it in expected]
            for box, it in zip(detections.xyxy, expected):
                left, top, width, height = it["bbox"]
                assert box == pytest.approx([left, top, left + width, top + height], abs=0.01)
        outlines = made / "outlines"
        read = supervision.DetectionDataset.from_yolo(
            images_directory_path=str(outlines / "images" / folder),
            annotations_directory_path=str(outlines / "labels" / folder),
            data_yaml_path=str(outlines / "data.yaml"),
            force_masks=True,
        )
        areas = np.concatenate([detections.mask.sum(axis=(1, 2)) for _, _, detections in read if len(detections)])
        assert len(areas) == len(coco["annotations"])
        # It rounds outlines to pixels and counts those on the edge, too.
        assert areas.sum() == pytest.approx(sum(it["area"] for it in coco["annotations"]), rel=0.35)


def test_key_points_have_the_columns_that_the_file_says(made):
    shape = next(
        line for line in (made / "pose" / "data.yaml").read_text().splitlines() if line.startswith("kpt_shape")
    )
    assert shape == "kpt_shape: [11, 3]"
    lines = [
        line.split() for path in (made / "pose" / "labels").rglob("*.txt") for line in path.read_text().splitlines()
    ]
    assert lines and all(len(line) == 5 + 3 * 11 for line in lines)
    assert any(line[7] == "2" for line in lines if line[0] == "1")


def test_archives_have_images_and_their_labels(made):
    names, objects = [], 0
    for path in sorted((made / "boxes").glob("*.tar")):
        with tarfile.open(path) as archive:
            members = archive.getnames()
            stems = {name.split(".")[0] for name in members}
            for stem in stems:
                assert {f"{stem}.jpg", f"{stem}.json", f"{stem}.mask.png", f"{stem}.depth.png"} <= set(members)
                described = json.load(archive.extractfile(f"{stem}.json"))
                objects += len(described["objects"])
            names += stems
    assert len(names) == 24 and objects == sum(len(_coco(made, split)["annotations"]) for split in SPLITS)
