// The order of diagnosis: faults, noise of the raw samples, a fit, noise of the image points, selection with refits,
// terms beyond the catalogue, the gap on held-out segments, the answer.
#include "diagnose/diagnose.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "diagnose/answer.h"
#include "diagnose/beyond.h"
#include "diagnose/candidates_report.h"
#include "diagnose/clock_offset.h"
#include "diagnose/evidence.h"
#include "diagnose/held_out_report.h"
#include "diagnose/judgeable.h"
#include "diagnose/noise_effects.h"
#include "diagnose/searched_model.h"
#include "diagnose/structure_report.h"
#include "stamps/exposures.h"

namespace host {
namespace {

using namespace diagnosis;

class Diagnoser {
 public:
  Diagnoser(const std::vector<Recording>& sessions, const Told& told, const DiagnoseOptions& options, Budget& budget)
      : sessions_(sessions),
        told_(told),
        options_(options),
        has_temperature_(
            std::all_of(sessions.begin(), sessions.end(), [](const Recording& r) { return r.imu.has_temperature; })),
        has_exposures_(std::all_of(sessions.begin(), sessions.end(), has_exposures)),
        model_(options.core, has_temperature_, has_exposures_),
        work_left_(budget),
        evidence_(sessions, without_effects(options.core, has_temperature_), options.profile, &work_left_,
                  [this](double fraction) { report(fraction); }) {
    model_.include(told);  // known to some ms, which bend all that is tested beside it
  }

  Diagnosis run() {
    out_.noise = options_.core.noise;
    out_.pixel_sigma = options_.core.pixel_sigma;
    if (!find_bad_data()) {
      find_imu_noise();
      fit_plain();
      if (!work_left_.must_answer() && !work_left_.allows(1)) return out_;
      if (judgeable(plain_, model_.candidates, evidence_.result(), &out_)) {
        find_effects();
        measure_gap();
      }
    }
    conclude(&out_);
    return out_;
  }

 private:
  void report(double fraction) {
    if (options_.progress) options_.progress(step_, fraction);
  }
  void begin(const std::string& step) {
    step_ = step;
    report(0);
  }

  bool find_bad_data() {
    begin("faults of the data");
    for (const Recording& r : sessions_) {
      const std::vector<Fault> found = find_faults(r, options_.core.calibration);
      out_.faults.insert(out_.faults.end(), found.begin(), found.end());
    }
    out_.faults_accepted = options_.accept_faults;
    return spoil_fits(out_.faults) && !options_.accept_faults;
  }

  /// Noise above the stated one is an effect of its own; the fits below are weighted with what was found.
  void find_imu_noise() {
    begin("noise of the raw samples");
    out_.raw_noise = raw_imu_noise(sessions_.front());
    const std::optional<NoiseEffect> found =
        imu_noise_effect(sessions_.front(), out_.raw_noise, &evidence_.options().noise);
    out_.noise = evidence_.options().noise;
    if (found) noise_effects_.push_back(*found);
  }

  Problem fit(const std::vector<bool>& estimated) {
    begin("fit " + std::to_string(++fits_));
    const Problem problem = evidence_.fit(model_.terms, estimated, model_.start);
    pixels_ = pixel_noise(evidence_.result().kept);
    return problem;
  }

  void fit_plain() { plain_ = fit(model_.columns_of(model_.needed)); }

  /// Less noise than stated is no fault (imu_noise.h): corner tracks follow their own error for many images, which
  /// neighbours do not show. Noise above it shows when the effects are in the model; then everything is weighed again.
  void find_effects() {
    out_.fit_before = evidence_.result();
    std::int64_t begun_with = work_left_.left();
    search_catalogue();
    if (tracks_drift()) {
      begun_with = work_left_.left();
      fit_plain();
      out_.fit_before = evidence_.result();
      search_catalogue();
    }
    look_beyond();
    work_of_search_ = begun_with - work_left_.left();
    for (int round = 0; round < decision::kNoiseRounds && !lens_has_no_name() && pixel_noise_is_above(); ++round) {
      begun_with = work_left_.left();
      model_.forget_additions();
      fit_plain();
      search_catalogue();
      look_beyond();
      work_of_search_ = begun_with - work_left_.left();
      noisy_pixels_ = true;
    }
    find_pixel_factor();
    if (!selection_.accepted.empty() || noisy_pixels_) out_.fit_after = evidence_.result();
    out_.cut_short = work_left_.used_up();
    report_candidates(selection_, has_temperature_, has_exposures_, &out_);
  }

  void search_catalogue() {
    SelectionOptions options;
    options.known = model_.known;
    options.work = &work_left_;
    options.at_step = [this](const auto&... asked) { return evidence_.at_step(asked...); };
    Problem last = plain_;
    std::map<std::vector<int>, std::vector<double>> starts;  // the same again is remembered (Evidence)
    const Refit refit = [this, &last, &starts](const std::vector<int>& accepted) {
      const auto before = starts.find(accepted);
      if (before != starts.end()) {
        model_.start = before->second;
      } else if (!accepted.empty()) {
        model_.begin_at(last, accepted);
      }
      last = fit_about_kappa(&model_, accepted, [&] { return fit(model_.columns_of(accepted)); });
      starts[accepted] = model_.start;
      if (accepted.empty()) plain_ = last;
      return last;
    };
    selection_ = select_effects(model_.candidates, options, refit);
  }

  bool lens_has_no_name() const { return model_.lens_has_no_name(selection_); }

  /// If they do, points are weighed by what they show. Against white noise they look like many terms of the dictionary.
  bool tracks_drift() {
    const TrackNoise& found = evidence_.result().track_noise;
    if (!each_track_drifts(evidence_.result(), pixels_) || !work_left_.allows_fit()) return false;
    evidence_.options().pixel_sigma = found.white_px;
    evidence_.options().track_walk = found.walk_px_per_sqrt_s;
    out_.tracks = found;
    return true;
  }

  bool pixel_noise_is_above() {
    if (evidence_.options().track_walk > 0) return false;  // differences of neighbours hold both drifts
    find_pixel_factor();
    const double so_far = evidence_.options().pixel_sigma / options_.core.pixel_sigma,
                 above = out_.pixels.factor / so_far - 1;
    if (above <= std::max(decision::kNoiseAbove, decision::kNoiseSigmas * out_.pixels.sigma / so_far)) return false;
    if (!work_left_.allows(work_of_search_ + 1)) return false;  // it would lose what is found
    evidence_.options().pixel_sigma = out_.pixels.factor * options_.core.pixel_sigma;
    return true;
  }

  /// At the last fit, over the stated noise. What the model leaves in all is an upper bound of noise: near neighbours
  /// differ by more where a step of the calibration is not in the fit.
  void find_pixel_factor() {
    if (evidence_.options().track_walk > 0) {
      pixels_ = out_.pixels = PixelNoise{};
      return;
    }
    const double ratio = evidence_.result().model.pixel_sigma / options_.core.pixel_sigma;
    std::vector<TermGroup> groups;
    for (const Accepted& a : selection_.accepted) groups.push_back(selection_.candidates[a.candidate].columns);
    Problem bare = selection_.problem;
    bare.noise = 0;
    pixels_.factor = std::min(pixels_.factor, std::max(1 / ratio, std::sqrt(dispersion(bare, groups))));
    out_.pixels = pixels_;
    out_.pixels.factor *= ratio;
    out_.pixels.sigma *= ratio;
  }

  /// Terms that the catalogue has not, beside what it has; a catalogue's effect that they make superfluous goes.
  void look_beyond() {
    if (!options_.dictionary) return;
    begin("terms beyond the catalogue");
    Beyond beyond(&evidence_, &model_.terms, &model_.start, &selection_, &work_left_, has_temperature_);
    beyond.run([this](const std::vector<bool>& estimated) { return fit(estimated); });
  }

  void measure_gap() {
    if (selection_.accepted.empty() && !evidence_.taken().empty()) fit_plain();  // what was fitted last was dropped
    const CoreModel& weights = evidence_.result().model;
    const JoinedRows joined = [this](const std::vector<std::size_t>& places) { return evidence_.joined(places); };
    report_gap({selection_, model_.terms, told_, joined, evidence_.sensors(),
                noise_floors(selection_.problem.noise, pixels_, out_.raw_noise, weights, out_.noise)},
               &out_);
    begin("structure of the residuals");
    report_structure(sessions_, evidence_.result(), &out_);
    if (noisy_pixels_ && !lens_has_no_name() && out_.open_excess <= (1 - decision::kNamesFrom) * out_.before.total)
      name_pixel_noise();
    add_noise_gap(noise_effects_, &out_);
  }

  /// Where something else is open, what the points show beside noise is that.
  void name_pixel_noise() {
    out_.pixel_sigma = evidence_.options().pixel_sigma;
    const double ratio = evidence_.result().model.pixel_sigma / options_.core.pixel_sigma;
    noise_effects_.push_back(pixel_noise_effect(out_.pixels, evidence_.segments(), ratio));
  }

  const std::vector<Recording>& sessions_;
  const Told& told_;
  const DiagnoseOptions& options_;
  bool has_temperature_, has_exposures_;
  SearchedModel model_;
  Budget& work_left_;
  std::int64_t work_of_search_ = 0;  ///< of the last whole search
  Evidence evidence_;
  std::string step_;
  int fits_ = 0;
  Problem plain_;  ///< without effects
  PixelNoise pixels_;
  Selection selection_;
  std::vector<NoiseEffect> noise_effects_;
  bool noisy_pixels_ = false;
  Diagnosis out_;
};

}  // namespace

Diagnosis diagnose(const std::vector<Recording>& sessions, const DiagnoseOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Diagnosis out = with_clocks_aligned(
      sessions, options.core, [&options](const std::vector<Recording>& aligned, const Told& told, Budget& budget) {
        return Diagnoser(aligned, told, options, budget).run();
      });
  if (options.stamp_exposure != 0) count_kappa_from_recording(options.stamp_exposure, &out);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace host
