"""The parameters of AMCL (ROS 1), nav2's AMCL and Beluga's, and what becomes of each here.

Names are nav2's; where ROS 1 says otherwise, ALIASES translates.
"""

from collections.abc import Callable

ALIASES = {
    "kld_err": "pf_err",
    "kld_z": "pf_z",
    "odom_model_type": "robot_model_type",
    **{f"odom_alpha{n}": f"alpha{n}" for n in (1, 2, 3, 4, 5)},
    **{
        f"laser_{name}": name
        for name in ("max_beams", "z_hit", "z_short", "z_max", "z_rand", "sigma_hit")
    },
    "laser_lambda_short": "lambda_short",
    "initial_pose_x": "initial_pose.x",
    "initial_pose_y": "initial_pose.y",
    "initial_pose_a": "initial_pose.yaw",
    "initial_cov_xx": "initial_pose.covariance_x",
    "initial_cov_yy": "initial_pose.covariance_y",
    "initial_cov_aa": "initial_pose.covariance_yaw",
}

Check = Callable[[float], bool]
COUNT: tuple[str, Check] = ("a whole number above zero", lambda v: v >= 1 and v == int(v))
POSITIVE: tuple[str, Check] = ("a number above zero", lambda v: v > 0)
NOT_NEGATIVE: tuple[str, Check] = ("a number not below zero", lambda v: v >= 0)
SHARE: tuple[str, Check] = ("a number from 0 to 1", lambda v: 0 <= v <= 1)
NUMBER: tuple[str, Check] = ("a number", lambda _: True)

NUMBERS: dict[str, tuple[tuple[str, Check], str]] = {
    "min_particles": (COUNT, "the least number of particles"),
    "max_particles": (COUNT, "the greatest number of particles"),
    "pf_err": (POSITIVE, "epsilon of KLD sampling"),
    "pf_z": (NOT_NEGATIVE, "the normal quantile of KLD sampling"),
    "alpha1": (NOT_NEGATIVE, "variance of a turn per squared turn"),
    "alpha2": (NOT_NEGATIVE, "variance of a turn per squared way"),
    "alpha3": (NOT_NEGATIVE, "variance of a way per squared way"),
    "alpha4": (NOT_NEGATIVE, "variance of a way per squared turn"),
    "max_beams": (COUNT, "beams of a scan that weigh"),
    "sigma_hit": (POSITIVE, "spread of a beam's end about a wall"),
    "z_hit": (POSITIVE, "with z_rand and laser_max_range, the likelihood of an outlier"),
    "z_rand": (POSITIVE, "with z_hit and laser_max_range, the likelihood of an outlier"),
    "laser_max_range": (NUMBER, "range over which outliers spread; the longest beam used"),
    "update_min_d": (POSITIVE, "way between two measurements"),
    "update_min_a": (POSITIVE, "turn between two measurements"),
    "recovery_alpha_slow": (SHARE, "long memory of fits; at 0 only a surprise recovers"),
    "recovery_alpha_fast": (SHARE, "short memory of how well measurements fit"),
    "spatial_resolution_x": (POSITIVE, "the bins of KLD sampling"),
    "spatial_resolution_theta": (POSITIVE, "the bins of KLD sampling"),
    "random_seed": (NUMBER, "the seed of the random numbers, if not negative"),
    "initial_pose.x": (NUMBER, "the start"),
    "initial_pose.y": (NUMBER, "the start"),
    "initial_pose.yaw": (NUMBER, "the start"),
    "initial_pose.covariance_x": (NOT_NEGATIVE, "the uncertainty of the start"),
    "initial_pose.covariance_y": (NOT_NEGATIVE, "the uncertainty of the start"),
    "initial_pose.covariance_yaw": (NOT_NEGATIVE, "the uncertainty of the start"),
}
"""Name -> what it must be, and what it is used as."""

WORDS: dict[str, dict[str, str | None]] = {
    "laser_model_type": {
        "likelihood_field": None,
        "likelihood_field_prob": None,
        "beam": "scans are weighed by the likelihood field, which is smoother and faster",
    },
    "robot_model_type": {
        **dict.fromkeys(
            (
                "diff",
                "diff-corrected",
                "differential",
                "nav2_amcl::DifferentialMotionModel",
                "differential_drive",
            )
        ),
        **dict.fromkeys(
            (
                "omni",
                "omni-corrected",
                "omnidirectional",
                "nav2_amcl::OmniMotionModel",
                "omnidirectional_drive",
                "stationary",
            ),
            "motion is sampled as a turn, a way and a turn; sideways motion is a way too",
        ),
    },
}
"""Name -> its possible words, each with why it is not used as such, None if it is."""

SWITCHES = {"set_initial_pose": "says whether the start is known"}

_FRAMES = "the frames are always map, odom and base_link"
_TOPICS = "topics have fixed names in the registry of the schemas"
_BEAM_MODEL = "it belongs to the beam model, and the likelihood field is used"
_SKIPPING = "a beam that fits nowhere costs a pose no more than an outlier, so none need be skipped"
_OTHERS = "it concerns ROS, not the localization"

NOT_NEEDED: dict[str, str] = {
    "alpha5": "it belongs to the omnidirectional model",
    "z_short": _BEAM_MODEL,
    "z_max": _BEAM_MODEL,
    "lambda_short": _BEAM_MODEL,
    "laser_likelihood_max_dist": "beyond three sigma_hit an end counts as an outlier anyway",
    "laser_min_range": "drivers leave out what is too near to be measured",
    "do_beamskip": _SKIPPING,
    "beam_skip_distance": _SKIPPING,
    "beam_skip_threshold": _SKIPPING,
    "beam_skip_error_threshold": _SKIPPING,
    "resample_interval": "particles are drawn anew whenever fewer than half of them count",
    "selective_resampling": "particles are drawn anew whenever fewer than half of them count",
    "spatial_resolution_y": "bins are square: spatial_resolution_x counts",
    "initial_pose.z": "the robot moves in a plane",
    "always_reset_initial_pose": "a new map always means a new start",
    "first_map_only": "a new map is taken whenever one is published",
    "use_map_topic": "the map always comes as a topic",
    "base_frame_id": _FRAMES,
    "odom_frame_id": _FRAMES,
    "global_frame_id": _FRAMES,
    "scan_topic": _TOPICS,
    "map_topic": _TOPICS,
    "initial_pose_topic": _TOPICS,
    "tf_broadcast": "the pose is published as a message",
    "transform_tolerance": "the pose carries the stamp of its odometry",
    "save_pose_rate": "the belief is saved every second",
    "gui_publish_rate": "belief_period of the localizer's settings says how often",
    "bag_scan_period": "logs are replayed by their own stamps",
    "use_sim_time": "all stamps are those of the measurements",
    "nomotion_update": "a standing robot measures again every second",
    "execution_policy": "particles are worked on by one core",
    "freespace_downsampling": "free space is drawn from cell by cell, whatever the map's size",
    "service_introspection_mode": _OTHERS,
    "introspection_mode": _OTHERS,
    "allow_parameter_qos_overrides": _OTHERS,
    "bond_heartbeat_period": _OTHERS,
    "bond_disable_heartbeat_timeout": _OTHERS,
    "autostart": _OTHERS,
    "autostart_delay": _OTHERS,
    "start_type_description_service": _OTHERS,
    "restore_defaults": _OTHERS,
}
"""Name -> why it is not needed here."""
