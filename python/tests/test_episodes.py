"""Demonstrations are data sets of Minari, of the episodes that the environments have."""

import subprocess
import sys

import minari
import numpy as np
import pytest


@pytest.mark.parametrize("observation", ["belief", "perception"])
def test_minari_reads_demonstrations_and_their_environment_starts_as_they_do(tmp_path, observation):
    words = f"episodes ScoreEmptyGoal --behaviour striker --episodes 2 --seed 7 --out {tmp_path} --observation {observation}"
    subprocess.run([sys.executable, "-m", "naoisis._command", *words.split(), "--realism", "realistic"], check=True)
    kind = "" if observation == "belief" else f"-{observation}"
    dataset = minari.MinariDataset(tmp_path / f"naoisis/ScoreEmptyGoal/striker-realistic{kind}-seed7-v0/data")
    assert dataset.total_episodes == 2
    env = dataset.recover_environment()
    # The ranges of the environment are wide enough for other levels of realism, too.
    own, recorded = env.observation_space, dataset.observation_space
    assert own.shape == recorded.shape and (own.low <= recorded.low).all() and (own.high >= recorded.high).all()
    assert env.action_space == dataset.action_space
    for seed, episode in zip((7, 8), dataset.iterate_episodes()):
        steps = len(episode.rewards)
        assert len(episode.observations) == steps + 1 and len(episode.actions) == steps
        assert all(row in env.action_space for row in episode.actions)
        assert not episode.terminations[:-1].any() and episode.terminations[-1] + episode.truncations[-1] == 1
        first, _ = env.reset(seed=seed)
        assert np.allclose(first, episode.observations[0], atol=1e-6)
