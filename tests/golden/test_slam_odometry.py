from pathlib import Path

import numpy as np
import pytest

from pilotage.core.logs import read_log
from slam_metrics import read_relations, relation_errors

pytestmark = pytest.mark.data


def test_raw_odometry_of_freiburg_is_as_bad_as_published(data_dir: Path) -> None:
    log = read_log(data_dir / "slam" / "fr079.clf.gz")
    stamps = np.array([record.stamp for record in log.odometry])
    poses = np.array([record.pose for record in log.odometry])
    errors = relation_errors((stamps, poses), read_relations(data_dir / "slam" / "fr079.relations"))
    assert errors.missing == 0
    assert errors.translation.mean() == pytest.approx(6.51, abs=0.01)
