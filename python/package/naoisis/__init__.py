"""naoisis: a behavioural simulator of robot soccer. Coarse motion, strict perception.

A match in three lines::

    import naoisis
    match = naoisis.Match("match3v3", seed=1)
    match.run(); match.score

Robots know nothing but what two cameras, two sonars, odometry and team messages tell them, through this door as through
every other; what is true is apart, in :meth:`Match.truth`.
"""

from naoisis._batch import Batch, batch
from naoisis._match import Match
from naoisis._naoisis import LABELS, __version__
from naoisis._traces import Trace, read_beliefs, read_trace, trace_lines
from naoisis.errors import MatchError, NaoisisError, ScenarioError, SnapshotError, TraceError

__all__ = [
    "LABELS",
    "Batch",
    "Match",
    "MatchError",
    "NaoisisError",
    "ScenarioError",
    "SnapshotError",
    "Trace",
    "TraceError",
    "__version__",
    "batch",
    "read_beliefs",
    "read_trace",
    "trace_lines",
]
