"""From thrust logs to model cards and landings.

>>> import touchdown as td
>>> trial = td.Trial({"time_s": [0.0, 0.1, 0.2], "throttle": [0.2, 0.3, 0.4]}, name="a stand")
>>> trial
Trial('a stand', 3 rows, time_s, throttle)
>>> trial["throttle"]
array([0.2, 0.3, 0.4])
"""

from sindy import InternalError, SindyError, SindyWarning, __version__

from . import dist, identify
from ._campaign import Campaign, campaign, campaign_status
from ._card import Card
from ._land import Landings, land
from ._policy import Policy
from ._reproduce import Reproduction, reproduce
from ._space import Landing, Space
from ._table import Table
from ._trial import Trial, read
from ._validate import FreeRun, FreeRuns, validate

__all__ = [
    "Campaign",
    "Card",
    "FreeRun",
    "FreeRuns",
    "InternalError",
    "Landing",
    "Landings",
    "Policy",
    "Reproduction",
    "SindyError",
    "SindyWarning",
    "Space",
    "Table",
    "Trial",
    "__version__",
    "campaign",
    "campaign_status",
    "dist",
    "identify",
    "land",
    "read",
    "reproduce",
    "validate",
]
