"""AMCL's parameter files: what each name becomes, and one clear error for each fault."""

from pathlib import Path

import numpy as np
import pytest

from pilotage.core.motion import OdometryNoise
from pilotage.localizer.amcl_file import AmclFileError, AmclTranslation, Fate, read_amcl_file
from pilotage.localizer.amcl_names import ALIASES, NOT_NEEDED, NUMBERS, SWITCHES, WORDS
from pilotage.localizer.particle_localizer import ParticleParams

NAV2 = """
amcl:
  ros__parameters:
    use_sim_time: true
    alpha1: 0.2
    alpha2: 0.1
    alpha3: 0.3
    alpha4: 0.05
    alpha5: 0.2
    base_frame_id: base_footprint
    do_beamskip: false
    laser_max_range: 100.0
    laser_model_type: likelihood_field
    max_beams: 90
    max_particles: 3000
    min_particles: 400
    pf_err: 0.04
    pf_z: 0.95
    recovery_alpha_fast: 0.1
    recovery_alpha_slow: 0.001
    resample_interval: 1
    robot_model_type: nav2_amcl::OmniMotionModel
    sigma_hit: 0.15
    z_hit: 0.5
    z_rand: 0.5
    update_min_a: 0.3
    update_min_d: 0.4
    set_initial_pose: true
    initial_pose: {x: 1.5, y: -2.0, z: 0.0, yaw: 0.7}
    max_partcles: 12
bt_navigator:
  ros__parameters: {global_frame: map}
"""

ROS_1 = """
min_particles: 500
kld_err: 1e-2
odom_alpha1: 0.2
laser_sigma_hit: 0.1
laser_z_hit: 0.95
initial_pose_x: 3.0
initial_cov_xx: 0.04
odom_model_type: diff
"""


def read(folder: Path, text: str) -> AmclTranslation:
    file = folder / "amcl.yaml"
    file.write_text(text, "utf-8")
    return read_amcl_file(file)


def fates(translation: AmclTranslation) -> dict[str, Fate]:
    return {fate.name: fate for fate in translation.fates}


def test_nav2s_parameters_become_those_of_the_particle_filter(tmp_path: Path) -> None:
    params = read(tmp_path, NAV2).params
    assert params.motion == OdometryNoise(0.2, 0.1, 0.3, 0.05)
    assert (params.kld.least, params.kld.most) == (400, 3000)
    assert (params.kld.epsilon, params.kld.quantile) == (0.04, 0.95)
    assert (params.beams, params.update_way, params.update_turn) == (90, 0.4, 0.3)
    assert (params.recovery.slow, params.recovery.fast) == (0.001, 0.1)
    assert params.evidence.beam.sigma == 0.15
    # 0.5 / 100 m against 0.5, as AMCL's field adds them.
    assert params.evidence.beam.outlier == pytest.approx(0.005 / 0.505)


def test_every_parameter_of_the_file_is_accounted_for(tmp_path: Path) -> None:
    told = fates(read(tmp_path, NAV2))
    assert len(told) == 30, "all of them, but not those of another node"
    assert told["alpha5"].kind == "not needed"
    assert told["robot_model_type"].kind == "not needed"
    assert told["laser_model_type"].kind == "used"
    assert told["initial_pose.yaw"].kind == "used"
    assert told["max_partcles"].kind == "unknown"
    assert "global_frame" not in told
    assert all(fate.reason for fate in told.values())
    assert str(told["max_beams"]) == "max_beams: 90 - used: beams of a scan that weigh"


def test_ros_1_says_the_same_by_other_names(tmp_path: Path) -> None:
    translation = read(tmp_path, ROS_1)
    params = translation.params
    assert params.kld.least == 500
    assert params.kld.epsilon == 0.01
    assert params.motion == OdometryNoise(0.2, 0.2, 0.2, 0.2), "the others are AMCL's defaults"
    assert params.evidence.beam.sigma == 0.1
    assert fates(translation)["odom_model_type"].kind == "used"


def test_a_start_is_taken_where_one_is_given(tmp_path: Path) -> None:
    start = read(tmp_path, ROS_1).start
    assert start is not None
    assert start[0] == pytest.approx([3.0, 0.0, 0.0])
    assert start[1] == pytest.approx(np.diag([0.04, 0.25, (np.pi / 12.0) ** 2]))
    assert read(tmp_path, "min_particles: 500").start is None
    origin = read(tmp_path, "{set_initial_pose: true, alpha1: 0.1}").start
    assert origin is not None
    assert origin[0] == pytest.approx(np.zeros(3))


def test_a_start_that_is_not_to_be_set_is_not(tmp_path: Path) -> None:
    off = read(tmp_path, "amcl: {set_initial_pose: false, initial_pose: {x: 1.0}}")
    assert off.start is None
    assert fates(off)["initial_pose.x"].kind == "not needed"


def test_a_seed_counts_unless_it_is_negative(tmp_path: Path) -> None:
    assert read(tmp_path, "random_seed: 7").seed == 7
    none = read(tmp_path, "random_seed: -1")
    assert none.seed is None
    assert fates(none)["random_seed"].kind == "not needed"


def test_what_the_file_leaves_out_is_as_in_our_own_defaults(tmp_path: Path) -> None:
    ours = ParticleParams()
    assert read(tmp_path, "amcl: {ros__parameters: {scan_topic: scan}}").params == ours
    fewer = read(tmp_path, f"max_particles: {ours.kld.least - 1}").params.kld
    assert fewer.least == fewer.most == ours.kld.least - 1


def test_zero_alphas_of_recovery_turn_it_off(tmp_path: Path) -> None:
    both = read(tmp_path, "{recovery_alpha_slow: 0.0, recovery_alpha_fast: 0.0}").params
    assert both.recovery.slow == both.recovery.fast == 0.0


@pytest.mark.parametrize(
    "text",
    [
        "max_beams: 30",
        "amcl: {max_beams: 30}",
        "amcl: {ros__parameters: {max_beams: 30}}",
        "/robot/amcl: {ros__parameters: {max_beams: 30}}",
        "robot: {amcl: {ros__parameters: {max_beams: 30}}}",
        "/**: {ros__parameters: {max_beams: 30}}",
    ],
)
def test_the_section_is_found_wherever_it_stands(tmp_path: Path, text: str) -> None:
    assert read(tmp_path, text).params.beams == 30


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("max_beams: many", "max_beams must be a whole number above zero, not 'many'"),
        ("max_beams: 2.5", "max_beams must be a whole number"),
        ("max_beams: true", "max_beams must be a whole number"),
        ("laser_sigma_hit: 0", "laser_sigma_hit must be a number above zero"),
        ("alpha1: -0.1", "alpha1 must be a number not below zero"),
        ("alpha2: .nan", "alpha2 must be"),
        ("recovery_alpha_slow: 1.5", "recovery_alpha_slow must be a number from 0 to 1"),
        ("recovery_alpha_slow: 0.1", "recovery_alpha_slow (0.1) is above recovery_alpha_fast (0)"),
        ("{min_particles: 9, max_particles: 5}", "min_particles (9) is above max_particles (5)"),
        ("{pf_err: 0.1, kld_err: 0.1}", "kld_err says again what another name of it (pf_err)"),
        ("set_initial_pose: 3", "set_initial_pose must be true or false, not 3"),
        ("laser_model_type: sonar", "laser_model_type must be one of likelihood_field"),
        ("bt_navigator: {a: 1}", "no parameters of AMCL in it"),
        ("[1, 2]", "no parameters of AMCL in it"),
        ("", "no parameters of AMCL in it"),
        ("a: [", "not readable as YAML"),
    ],
)
def test_a_fault_is_named_in_one_line(tmp_path: Path, text: str, fault: str) -> None:
    with pytest.raises(AmclFileError) as caught:
        read(tmp_path, text)
    assert fault in str(caught.value)
    assert "amcl.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(AmclFileError, match=r"nowhere\.yaml: No such file"):
        read_amcl_file(tmp_path / "nowhere.yaml")


def test_names_have_one_meaning() -> None:
    tables = [set(NUMBERS), set(WORDS), set(SWITCHES), set(NOT_NEEDED), set(ALIASES)]
    assert sum(map(len, tables)) == len(set.union(*tables))
    assert set(ALIASES.values()) <= set.union(*tables[:4])
