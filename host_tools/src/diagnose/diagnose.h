// Where do the model and the measurements disagree, what is missing in the model, and how much of the gap does it
// close? `segcal diagnose`, and for experiments without files.
#pragma once

#include <functional>

#include "diagnose/fault.h"
#include "diagnose/gap.h"
#include "diagnose/imu_noise.h"
#include "diagnose/pixel_noise.h"
#include "diagnose/structure.h"
#include "replay/replay.h"

namespace host {

struct DiagnoseOptions {
  CoreOptions core;              ///< starting calibration, stated noise, effects that are known already
  std::string profile = "host";  ///< keeps up to 64 segments: four minutes; of longer recordings the most informative
  bool accept_faults = false;    ///< fits even where the data are bad
  bool dictionary = true;        ///< look beyond the catalogue where a gap stays open
  double stamp_exposure = 0;  ///< so many times the exposure was added to the stamps already: kappa counts from there
  std::function<void(const std::string& step, double fraction)> progress;  ///< may be empty
};

struct DiagnosedParameter {
  std::string name;  ///< "time_offset.t_d"
  double value = 0, sigma = 0;
  std::string unit;
};

/// An effect with a name, or an unlisted one in words.
struct DiagnosedEffect {
  std::string name;  ///< as in docs/diagnosis.md, section 4; "unlisted" for a term that the catalogue has not
  std::vector<DiagnosedParameter> parameters;
  double statistic = 0;  ///< with the other effects free; over the dispersion
  int dof = 0;
  double log10_p = 0;                ///< not corrected for the number of candidates
  double gap_closed = 0;             ///< of what this effect alone is about, on held-out segments
  std::string words;                 ///< a sentence to read aloud
  std::vector<std::string> or_else;  ///< effects that this motion does not tell from it
  std::string separates;             ///< the motion that would
};

/// A figure of all sensors together, and of each by itself.
struct SensorShares {
  double total = 0, camera = 0, gyro = 0, accel = 0;
};

struct NotNamed {
  std::string name, why;
};

/// A term that is estimated from now on, with its value.
struct ModelTerm {
  std::string effect;  ///< "time_offset"; empty: a term of the dictionary
  int bit = -1;        ///< of the effect in SEGCAL_EFFECT_*
  CoreTerm term;
  DiagnosedParameter parameter;
};

/// One candidate by itself: what the report lists.
struct CandidateScore {
  std::string name;
  double statistic = 0, log10_p = 0;
  int dof = 0;  ///< directions that would have shown; 0: cannot tell
};

struct Diagnosis {
  std::string verdict = "consistent";  ///< consistent, explained, partly_explained, unexplained or bad_data
  bool judged = true;                  ///< false: too short or too still; the verdict then says nothing
  std::string lost;                    ///< why nothing could be fitted although there is motion; empty: a fit was made
  std::string sentence;                ///< the answer, to read aloud
  bool cut_short = false;  ///< the work of one diagnosis was used up: something may be left that more would have found
  std::vector<DiagnosedEffect> effects;
  /// excess over the own noise floor without and with the effects; chi2/dof of noise
  SensorShares before, after, noise_floor;
  double after_sigma = 0;  ///< of after.total
  /// of each sensor's `before` and `after` by chance; degrees of freedom. No total of the sigmas
  SensorShares gap_sigma, gap_dof;
  double gap_closed = 0;   ///< share of before.total: by nested folds where there are eight segments, named or not
  double open_excess = 0;  ///< part of before.total that the verdict counts as open: without a name, or refused one
  std::vector<diagnosis::Structure> where;
  std::vector<diagnosis::Structure> left;  ///< the same with the effects, one per entry of `where`
  std::vector<double> where_after;         ///< correlation that is left with the effects, one per entry of `where`
  std::vector<NotNamed> rejected, cannot_tell;
  std::vector<CandidateScore> scores;
  /// With a step of the calibration: from the fit's values, which are a mean, to those before it, of the step's block.
  std::vector<double> before_step;
  std::vector<ModelTerm> model;  ///< effects by bit, then terms of the dictionary
  ImuNoise noise;                ///< with the factors that were found
  double pixel_sigma = 0.5;      ///< px, with the factor that was found
  std::vector<Fault> faults;
  bool faults_accepted = false;  ///< asked to go on in spite of them
  RawNoise raw_noise;
  diagnosis::PixelNoise pixels;
  TrackNoise tracks;  ///< of the last fit, where corner tracks drift and points were weighed so; no points: they do not
  ReplayResult fit_before, fit_after;  ///< without and with the effects; empty with bad_data
  double seconds = 0;                  ///< wall clock
};

/// Throws InputError where a recording cannot be used at all.
Diagnosis diagnose(const std::vector<Recording>& sessions, const DiagnoseOptions& options);

/// diagnosis.json, model.yaml, segcal_effects.h, diagnosis_data.json (what the report draws); `beside`: names and texts
/// of further files of the same run.
void write_diagnosis(const std::filesystem::path& folder, const Diagnosis& diagnosis,
                     const std::vector<Recording>& sessions,
                     const std::vector<std::pair<std::string, std::string>>& beside = {});
std::string diagnosis_json(const Diagnosis& diagnosis);

}  // namespace host
