// Feeds recordings to the core as a device would live them, and gathers what comes out.
#pragma once

#include <functional>

#include "clock/clock_search.h"
#include "replay/core.h"
#include "replay/passes.h"
#include "replay/track_noise.h"
#include "state/state_file.h"

namespace host {

/// What corners are weighed by: pixel_sigma and track_walk (stated); what the tracks of a first replay show (shown),
/// unless these refuse the calibration; or that in any case (estimated). What a model lacks makes residuals walk as
/// well: with its effects taken for noise, nothing would be left to refuse a calibration for.
enum class CornerNoise { stated, shown, estimated };

struct ReplayOptions {
  CoreOptions core;
  std::string profile = "mobile";
  bool joint_ekf = false;  ///< no segments: the filter gives the calibration itself, at the end of each session
  bool review = false;     ///< judge the result and name causes (review/review.h, review/joint_filter.h)
  std::vector<ClockSearch> clocks;  ///< what was found of the sessions' clocks, one each; may be empty
  CornerNoise corner_noise = CornerNoise::stated;
  /// at most so many times over all recordings, each from the result of the one before; single-session only
  int passes = 1;
  bool calibrate = true;  ///< false: odometry only, the calibration stays as it is
  /// Called after each session with what has been found so far; may be empty. The number counts from 0.
  std::function<void(std::size_t, const CoreResult&, const Calibration&)> after_session;
  /// the first session goes on from there; at the end it has this device's state, not written yet
  StateFile* state = nullptr;
  /// takes the core over when the replay is done, to ask it further things
  std::unique_ptr<Core>* keep_core = nullptr;
  std::function<void(double)> progress;  ///< called with the fraction done, 0..1; may be empty
};

/// One calibration that ran.
struct ReplayCalibration {
  std::int64_t t_ns = 0;    ///< stamp of the newest frame then
  bool by_targets = false;  ///< the device began it of its own, else the replay did at the session's end
  int segments = 0;
  std::string status;
  std::vector<CoreParameter> parameters;
};

/// A result hash that a device wrote into its log, and ours at the same place.
struct HashCheck {
  std::uint64_t expected = 0, found = 0;
};

struct ReplayTiming {
  double vio_ms_median = 0, vio_ms_p95 = 0;  ///< per processed frame, IMU included
  double score_ms_median = 0;                ///< per segment: frames on which a segment was closed
  double calibrate_ms = 0;                   ///< the last calibration
};

/// What was stated, or taken for granted, and what the data say of it. Nothing is refused for it.
struct Note {
  /// gyro_noise, accel_noise, pixel_noise, gravity, one_segment, start_conflict or unseen_effects
  std::string name;
  double factor = 1;  ///< what the data show over what was stated; of the last three in sigmas
  std::string words;  ///< a sentence
};

/// What a result may suffer from: a fault of the data, or an effect that the model lacks.
struct Suspect {
  std::string name;        ///< of a fault "kind.sensor", of an effect its own
  double statistic = 0;    ///< of a fault its size over the limit, of an effect chi-square
  double log10_p = 0;      ///< of an effect, corrected for the number of effects
  double bias_sigmas = 0;  ///< by how much the effect would move the released value `moves`
  std::string moves;
  std::string words;          ///< a sentence
  double move = 0;            ///< of that value, in its unit; 0: not known
  std::vector<double> moved;  ///< of each parameter, in its unit, without what chance makes of it; empty: not known
  bool in_sigmas = false;     ///< sigmas and covariance have grown by that
  bool certain = true;        ///< false: the segments cannot be sure; it counts in the sigmas and refuses nothing
};

/// An effect of the catalogue that the data do not ask for, and what it may move all the same.
struct UnseenEffect {
  std::string name;
  std::vector<double> moves;  ///< of each parameter, in its unit, a standard deviation
};

struct Health {
  std::uint32_t frames = 0, frames_used = 0, filter_restarts = 0;
  std::uint32_t frames_offered = 0;  ///< at the odometry's rate: a camera of 30 Hz offers every third image
  double segment_scatter = 1;        ///< variance of what the segments say, over what stated noise leaves; 1: as stated
  std::vector<double> noise_sigmas;  ///< of the parameters, by noise alone, not by how segments scatter
  double step_chi2 = 0;              ///< of the step from the start by the prior's sigmas
  int step_dof = 0;
  std::vector<Suspect>
      suspects;  ///< faults, then effects, certain ones and large statistics first; remarks; a first replay's
  std::vector<UnseenEffect> unseen;
  std::vector<Note> notes;  ///< on noise, gravity and effects that the data do not show
};

struct ReplayResult {
  Health health;
  std::string cause;                ///< why it is not calibrated; a sentence, where it was reviewed
  std::vector<ClockSearch> clocks;  ///< of the sessions
  CoreResult result;
  bool calibrated = false;  ///< a calibration ran
  std::vector<ReplayCalibration> calibrations;
  std::vector<ReplayPass> passes;  ///< one for each; all else here is of the last one
  Calibration calibration;
  Calibration start;  ///< where it started from, the mean of the prior
  ImuNoise noise;
  std::string config;  ///< config.yaml; empty where a device brought its own
  CoreModel model;
  std::vector<CoreState> trajectory;  ///< at each processed frame
  std::vector<CoreSegment> segments;  ///< every segment scored, `kept` as at the end
  std::vector<CoreKept> kept;
  /// of these sessions, not of those before a restored state
  std::vector<std::pair<std::string, std::uint32_t>> counters;
  CoreMemory memory;
  TrackNoise track_noise;          ///< that the kept segments' tracks show
  bool weighed_by_tracks = false;  ///< `model` has the noise of a first replay's tracks
  ReplayTiming timing;
  std::uint64_t result_hash = 0;       ///< at the end
  std::vector<HashCheck> hash_checks;  ///< one for each in the log
};

/// The images of all cameras at one stamp; null: this camera has none.
struct RigFrame {
  std::int64_t t_ns = 0;
  std::vector<const Frame*> cameras;
};

/// In the order of the log, so that stamps that repeat or go back reach the core, which counts them. Cameras of one rig
/// share their trigger: a frame joins the one of cam0 with the same stamp, or stands before the first later one.
std::vector<RigFrame> rig_frames(const Recording& recording);

/// The calls that feed a recording in order: those that its device made; without one, frames follow the first sample
/// that is not before them, as the filter wants samples up to the frame and a device sees the image later than these.
std::vector<DeviceCall> calls_of(const Recording& recording, const std::vector<RigFrame>& frames);

/// Replays the recordings one after the other, each as a session of the same device; twice, where options.corner_noise
/// asks for it.
ReplayResult replay(const std::vector<Recording>& sessions, const ReplayOptions& options);
/// Whether another replay should weigh corners by what the tracks of the first show. By the noise that residuals show
/// all residuals are as expected: with `shown`, a fit that failed with the noise of use stays failed, and what was
/// refused for another reason stays so, unless the tracks show clearly less noise, with which they may tell enough.
bool asks_again(CornerNoise noise, const ReplayResult& first);
/// Once, with corners weighed by options.core.
ReplayResult replay_as_stated(const std::vector<Recording>& sessions, const ReplayOptions& options);

}  // namespace host
