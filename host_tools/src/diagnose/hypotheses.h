// Everything that `segcal diagnose` may say is missing in the model: one table with how the data are asked for it, how
// large it may be, what it has of the recording's error level before the data speak, what it is about, and its words.
//
// The columns of an effect are the core's (lib/src/sensors/effect_catalogue.h), and so are its parameters and their
// sizes; of a step they are the columns of its block, of exposure_offset those of time_offset. What no row of this
// table explains is "something else": it gets the verdict `unexplained`, and takes a name back where it is more than
// decision::kMostRest of the gap (held_out_report.h).
#pragma once

#include <string>
#include <vector>

namespace host::diagnosis {

/// How the data are asked.
enum class Kind {
  effect,    ///< columns of the core's catalogue
  exposure,  ///< time_offset's column times each segment's exposure (exposure_offset.h)
  step,      ///< columns of a block of theta once more, from an instant on (shift.h)
  noise,     ///< a mean square of raw samples or residuals (noise_effects.h): columns have no part in it
  term       ///< one column of the dictionary (model_terms.h): it has no name
};

/// What a recording must have for it to be a candidate at all.
enum class Asks { nothing, temperature, exposures };

/// What an effect is about. Residuals that still follow a cause of the same family take its name back.
enum Family : unsigned { of_nothing = 0, of_lens = 1, of_timing = 2, of_gyro = 4, of_accel = 8 };

struct Hypothesis {
  const char* name;
  Kind kind;
  unsigned about;  ///< Family, added up; of a term by its column
  Asks asks;
  const char* looks_like;  ///< "camera and IMU stamps are apart", for the sentence
  const char* needs;       ///< the motion, or the data, that show it
  double size = 0;         ///< plausible magnitude of each parameter, in its unit; 0: by block, sample or term
};
const std::vector<Hypothesis>& hypotheses();
/// Throws std::logic_error for a name that no row has.
const Hypothesis& hypothesis(const std::string& name);

/// The name of terms without one.
constexpr const char* kUnlisted = "unlisted";
/// The names that code speaks of.
constexpr const char* kExposureOffset = "exposure_offset";
constexpr const char* kCalibrationShift = "calibration_shift";

/// How far a shock may move a block of theta.
struct StepSize {
  const char* block;  ///< "r_CI" of each camera, "gyro.s"
  int count;          ///< 0: as many as the lens has
  double size;
  const char* unit;
};
const std::vector<StepSize>& camera_step_sizes();
const std::vector<StepSize>& imu_step_sizes();
/// "cam1.f" and "gyro.s" are both found.
const StepSize& step_size(const std::string& block);

/// Of the recording's error level, before the data speak (decision.h): shared equally among the effects that devices
/// are known to have, less for a step, less again for a term. A noise is asked by sigmas (decision::kNoiseSigmas).
double share_of(Kind kind, bool has_exposures = false);

/// The motion that shows an effect: "quick turns and changes of speed"; what all of them need for an empty name.
std::string needs(const std::string& effect);
/// The motion that tells two effects apart.
std::string separates(const std::string& a, const std::string& b);

}  // namespace host::diagnosis
