// The core as the host sees it: one interface over the C API, whatever profile it was compiled with.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "calibration_file.h"
#include "recording.h"
#include "replay/core_memory.h"
#include "state/flash_image.h"

namespace host {

/// A term of an effect as the C API counts them (segcal_term_t).
struct CoreTerm {
  int kind = 0, a = 0, b = 0, c = 0;
};

/// One standard deviation of the starting calibration's error, by group; 0: the core's default
/// (lib/src/calibration/prior.h).
struct PriorSigmas {
  double r_CI_rad = 0, p_CI_m = 0;
  double focal_length_share = 0;  ///< of f
  double principal_point_px = 0;
  double distortion = 0;  ///< of each coefficient
  double gyro_scale = 0, gyro_misalignment = 0;
  double accel_scale = 0, accel_misalignment = 0, r_AI_rad = 0;
};

struct CoreOptions {
  Calibration calibration;
  PriorSigmas prior_sigma;
  ImuNoise noise;
  double gravity = 0;        ///< m/s^2; 0: nobody stated it, the standard value is taken
  std::string metric = "A";  ///< A, D, E, set_d or random
  bool multi_session = false;
  int segments = 0;  ///< to keep; 0: 8, or as many as the profile holds
  double segment_s = 4;
  bool adaptive_segments = false;  ///< segments of half to twice segment_s, where motion says
  double pixel_sigma = 0.5;        ///< px, white noise of a corner per axis
  double track_walk = 0;           ///< px/sqrt(s), random walk of its error along the track, per axis
  std::uint64_t seed = 1;
  /// probability that a calibration drops segments of an unchanged device; -1: it never drops any
  double outdated_level = 1e-3;
  double trigger_fraction = 0;    ///< sigmas over the prior's at which the device calibrates of its own; 0: it does not
  bool hold_calibration = false;  ///< the filter runs with the calibration as it is, without estimates of its own
  std::vector<double> sigma_ref;  ///< normalises the metrics, per parameter; empty: the prior sigmas
  bool condense = false;          ///< segments that end after a release go into epochs
  bool joint_ekf = false;         ///< the filter's own calibration is the result; no segments
  std::vector<std::uint8_t> device_config;  ///< a device's own (recording.h): taken instead of all here; empty: none
  std::uint32_t effects = 0;                ///< SEGCAL_EFFECT_* that are estimated
  std::uint32_t watched_effects = 0;        ///< SEGCAL_EFFECT_* that each scored segment is asked about
  std::vector<CoreTerm> terms;              ///< and further terms
  std::vector<double> term_values;          ///< where they start, effects by bit, then `terms`; empty: at zero
  bool has_temperature = false;             ///< the samples tell the temperature
};

struct CoreState {
  std::int64_t t_ns = 0;
  Eigen::Vector4d q_GI_wxyz{1, 0, 0, 0};
  Eigen::Vector3d p_GI{0, 0, 0}, v_GI{0, 0, 0}, b_a{0, 0, 0}, b_g{0, 0, 0};
};

struct CoreDirection {
  std::vector<double> weight;  ///< per parameter, in units of its prior sigma; the largest is 1
  double relative_sigma = 1;
};

struct CoreSegment {
  std::int64_t start_ns = 0, end_ns = 0;
  std::uint32_t session = 0, serial = 0;
  int keyframes = 0, landmarks = 0, points = 0, rank = 0;
  double A = 0, D = 0, E = 0, gain_nats = 0;
  bool kept = false;
  bool settled = true;    ///< its states follow its own IMU samples, at the calibration that the odometry believed
  bool outdated = false;  ///< dropped by a calibration: newer segments contradict it
  std::vector<CoreDirection> not_excited;
  std::vector<double> sigma;  ///< per parameter, from this segment and the prior alone
};

struct CoreParameter {
  std::string name, unit, verdict;  ///< verdict: observed, weak or fixed
  double value = 0, initial = 0, sigma = 0, prior_sigma = 0;
};

struct CoreResult {
  std::string status = "insufficient";
  std::vector<CoreParameter> parameters;
  std::vector<CoreDirection> unobservable;
  int iterations = 0, segments = 0, partitions = 0, image_points = 0;
  bool converged = false;
  double chi2 = 0, dof = 0, noise_scale = 1, reprojection_rms_px = 0, reprojection_median_px = 0;
  /// of the parameters with nothing held (segcal_get_posterior), row-major; empty: not known
  std::vector<double> mean, covariance;
  std::vector<CoreEpoch> epochs;     ///< oldest first
  std::vector<CoreChange> changes;   ///< oldest first, an open one last
  std::vector<CoreSession> history;  ///< oldest first
  CoreCourse course;
};

struct CorePointResidual {
  std::int64_t t_ns;
  int camera;
  double u_sigma, v_sigma;
};
struct CoreImuResidual {
  std::int64_t t_ns;
  Eigen::Vector3d rotation, velocity, position;  ///< whitened
};

/// How far the core trusts what: all weights of a calibration (lib/src/segments/weights.h).
struct CoreModel {
  double gyro_noise_density = 0, gyro_random_walk = 0, accel_noise_density = 0, accel_random_walk = 0;
  double gravity = 0, pixel_sigma = 0, huber = 0;
  double bias_a_sigma = 0, bias_g_sigma = 0, velocity_sigma = 0, inverse_depth_sigma = 0,
         turned_inverse_depth_sigma = 0;
  double track_walk = 0;
  bool weighs_walks = false;  ///< the profile is built with SEGCAL_TRACK_WALK
};

/// 1/m, of the prior on an inverse distance below zero (kBehindDepthSigma in lib/src/segments/landmark_guess.h).
constexpr double behind_inverse_depth_sigma = 0.05;

struct CoreLandmark {
  std::uint32_t track_id = 0;
  int tie = -1;  ///< the same number in several segments: one landmark; -1: the segment's own
  Eigen::Vector3d anchor{0, 0, 0}, direction{0, 0, 1};
  double inverse_distance = 0;  ///< the landmark is at anchor + direction / inverse_distance
};

struct CorePoint {
  int landmark = 0, keyframe = 0, camera = 0;
  double u = 0, v = 0;    ///< px
  bool rejected = false;  ///< left out by the last calibration
};

/// Everything about one kept segment: what the report draws, and all that the calibration had of it.
struct CoreKept {
  CoreSegment segment;
  std::vector<CoreState> keyframes;
  std::vector<CorePointResidual> points;
  std::vector<CoreImuResidual> imu;
  int place = -1;             ///< order in the last calibration; -1: it took no part
  std::string join = "none";  ///< how it hangs on the one before: none, imu or bias
  double gap_s = 0;           ///< s from the one before
  std::int64_t lead_ns = 0;   ///< the samples begin this long before the first keyframe
  bool turned_only = false;   ///< linearised as pure rotation
  std::vector<CoreLandmark> landmarks;
  std::vector<CorePoint> measured;
  std::vector<ImuSample> samples;  ///< as stored, rounded to 16 bits
};

/// Square-root rows over [theta | candidates | residual] of some kept segments, without the prior (segcal_linearise).
struct CoreRows {
  int n_theta = 0, n_candidates = 0;  ///< theta with the terms that are estimated
  double dof = 0;                     ///< residuals minus states and landmarks
  std::vector<double> triangle;       ///< packed, row-major, n_theta + n_candidates + 1 columns
};

/// What one kept segment says through its camera, then through its gyroscope
/// (rotation, its bias' walk) beside the camera, then through its accelerometer
/// (velocity, position, its bias' walk) beside both; with the states at their best.
struct CoreSensorRows {
  int n_theta = 0, n_candidates = 0;  ///< as CoreRows
  /// What a sensor adds to the squares at (theta, candidates) = x is
  /// |root (x, -1)|^2. They add up to CoreRows of the same segment.
  std::array<Eigen::MatrixXd, 3> root;
  /// (s, t): how much the variance of sensor t adds to what s adds,
  /// expected. Sums of rows are degrees of freedom, theta not counted.
  Eigen::Matrix3d shared = Eigen::Matrix3d::Zero();
};

struct CoreMemory {
  std::size_t state_bytes = 0, segment_bytes = 0, workspace_bytes = 0;
};

enum class FrameOutcome { waiting, skipped, tracking, lost, refused };

class CoreSide;  // replay/core_side.h

class Core {
 public:
  virtual ~Core() = default;
  virtual void push_imu(const ImuSample& sample) = 0;
  /// Points of all cameras at one stamp; `per_camera` has one entry per camera (null: no image at this stamp).
  virtual FrameOutcome push_frame(std::int64_t t_ns, const std::vector<const Frame*>& per_camera) = 0;
  virtual bool state(CoreState* out) const = 0;
  /// Does all work that is pending: scores and, when the device began one, a calibration. True if one took effect.
  virtual bool background() = 0;
  /// false: background() leaves all work until it is due, so that be_late() can repeat what a device did.
  virtual void work_ahead(bool ahead) = 0;
  /// The calls that feed find work that is due undone, and drop it or put it off (segcal_background); else they do it.
  virtual void be_late(bool late) = 0;
  virtual void request_calibration() = 0;
  virtual void flush() = 0;
  virtual void new_session() = 0;
  /// False if there is no segment to calibrate from.
  virtual bool calibrate() = 0;
  virtual bool has_result() const = 0;
  virtual CoreResult result() const = 0;
  virtual Calibration calibration() const = 0;
  /// The segment scored last; false if there is none since the call before.
  virtual bool last_segment(CoreSegment* out) = 0;
  virtual std::vector<CoreKept> kept() const = 0;
  virtual CoreModel model() const = 0;
  /// Rows of the kept segments with these serial numbers, at the last calibration. Throws InputError for candidates
  /// that this profile has no room for.
  virtual CoreRows linearise(const std::vector<std::uint32_t>& serials, const std::vector<CoreTerm>& candidates) = 0;
  /// The same of one kept segment, sensor by sensor.
  virtual CoreSensorRows sensor_rows(std::uint32_t serial, const std::vector<CoreTerm>& candidates) = 0;
  /// Copies of these kept segments, fitted by themselves. `expected`: theta less the last calibration's, per column;
  /// the fit starts there, and is held there by a tenth of the prior's sigmas.
  virtual std::unique_ptr<CoreSide> side(const std::vector<std::uint32_t>& serials,
                                         const std::vector<double>& expected) const = 0;
  /// Serial numbers of what the last calibration dropped as outdated.
  virtual std::vector<std::uint32_t> outdated() const = 0;
  /// What keeps the odometry from running, in words; empty where it runs or only begins (segcal_get_health).
  virtual std::string trouble() const = 0;
  /// Data faults and other counters, by name.
  virtual std::vector<std::pair<std::string, std::uint32_t>> counters() const = 0;
  virtual CoreMemory memory() const = 0;
  virtual std::uint32_t work() const = 0;  ///< slices since it was made, each bounded (segcal_progress_t.slices)
  /// Before anything is pushed: goes on, in a new session, where the device that
  /// saved into this flash ended. Throws InputError without a file's name if that
  /// device's configuration or capacities were others, or if nothing whole is stored.
  virtual void restore(FlashImage* flash) = 0;
  /// After flush() or calibrate(): what outlives power. An empty image is made as large as this profile needs.
  virtual void save(FlashImage* flash) = 0;
  virtual std::uint64_t result_hash() const = 0;  ///< over all bits of what was found (segcal_result_hash)
};

/// `profile`: mcu, mobile, host or mobile_double. Throws InputError
/// for another name or a configuration that the core refuses.
std::unique_ptr<Core> make_core(const std::string& profile, const CoreOptions& options);
/// Segments that a profile has room for; those that it keeps (CoreOptions::segments: `wanted`).
int most_segments(const std::string& profile);
int segments_kept(const std::string& profile, int wanted);

}  // namespace host
