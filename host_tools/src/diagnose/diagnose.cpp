// The order of diagnosis: faults, noise of the raw samples, a fit, noise of the image points, selection with refits, terms
// beyond the catalogue, the gap on held-out segments, the answer.
#include "diagnose/diagnose.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "diagnose/answer.h"
#include "diagnose/beyond.h"
#include "diagnose/catalogue.h"
#include "diagnose/evidence.h"
#include "diagnose/held_out_report.h"
#include "sensors/effect_terms.h"

namespace host {
namespace {

using namespace diagnosis;

constexpr std::size_t kFewestSegments = 4;
/// log10 p from which on structure in residuals is reported; all of it.
constexpr double kStructure = -3, kAll = 1e9;

class Diagnoser {
 public:
  Diagnoser(const std::vector<Recording>& sessions, const DiagnoseOptions& options)
      : sessions_(sessions), options_(options), has_temperature_(sessions.front().imu.has_temperature),
        catalogue_(core_catalogue(has_temperature_)),
        evidence_(sessions, with_temperature(options.core, has_temperature_), options.profile,
                  [this](double fraction) { report(fraction); }) {}

  Diagnosis run() {
    out_.noise = options_.core.noise;
    out_.pixel_sigma = options_.core.pixel_sigma;
    if (!find_bad_data()) {
      find_imu_noise();
      fit_plain();
      if (judgeable()) {
        find_effects();
        measure_gap();
      }
    }
    conclude(&out_);
    return out_;
  }

 private:
  /// Effects are this class' business.
  static CoreOptions with_temperature(CoreOptions core, bool has) {
    core.has_temperature = has;
    core.effects = 0;
    core.terms.clear();
    core.term_values.clear();
    return core;
  }

  /// Effects of the model that was given: estimated in every fit but the first, from its values.
  void begin_with_known() {
    std::size_t next = 0;
    const std::vector<double>& values = options_.core.term_values;
    const auto take = [this, &next, &values](std::size_t candidate) {
      const TermGroup& g = catalogue_.candidates[candidate].columns;
      known_.push_back(static_cast<int>(candidate));
      for (int i = 0; i < g.count; ++i) start_[g.first + i] = next < values.size() ? values[next++] : 0;
    };
    const std::size_t listed = catalogue_.candidates.size();
    for (std::size_t c = 0; c < listed; ++c) {
      if ((options_.core.effects >> terms_[catalogue_.candidates[c].columns.first].bit & 1u) != 0) take(c);
    }
    for (const CoreTerm& term : options_.core.terms) {
      terms_.push_back(term_info(term));
      catalogue_.candidates.push_back({"unlisted", {static_cast<int>(terms_.size()) - 1, 1}, {terms_.back().size}, 1});
      start_.push_back(0);
      take(catalogue_.candidates.size() - 1);
    }
  }

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
    return !out_.faults.empty() && !options_.accept_faults;
  }

  /// Noise above the stated one is an effect of its own; the fits below are weighted with what was found.
  void find_imu_noise() {
    begin("noise of the raw samples");
    out_.raw_noise = raw_imu_noise(sessions_.front());
    std::vector<DiagnosedParameter> factors;
    ImuNoise& noise = evidence_.options().noise;
    const auto take = [&factors](const SensorNoise& s, const char* name, double* density) {
      if (s.verdict != SensorNoise::Verdict::above) return;
      factors.push_back({name, s.factor, s.sigma, "-"});
      *density *= s.factor;
    };
    take(out_.raw_noise.gyro, "gyro_noise.factor", &noise.gyro_noise_density);
    take(out_.raw_noise.accel, "accel_noise.factor", &noise.accel_noise_density);
    out_.noise = noise;
    if (!factors.empty()) noise_effects_.push_back(noise_effect("imu_noise", factors, imu_halves(factors)));
  }

  /// Factors of the first half of the samples and of the second; 0 where one is too short to tell.
  std::vector<std::array<double, 2>> imu_halves(const std::vector<DiagnosedParameter>& factors) const {
    std::vector<std::array<double, 2>> out(factors.size(), {0, 0});
    for (int half = 0; half < 2; ++half) {
      Recording part = sessions_.front();
      std::vector<ImuSample>& samples = part.imu.samples;
      const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
      half == 0 ? samples.erase(middle, samples.end()) : samples.erase(samples.begin(), middle);
      const RawNoise noise = raw_imu_noise(part);
      for (std::size_t i = 0; i < factors.size(); ++i) {
        const SensorNoise& sensor = factors[i].name[0] == 'g' ? noise.gyro : noise.accel;
        out[i][half] = sensor.axes[0].density > 0 ? sensor.factor : 0;
      }
    }
    return out;
  }

  /// Factors of the two halves of the segments at the last fit.
  std::array<double, 2> pixel_halves() const {
    std::vector<CoreKept> half[2];
    const std::vector<CoreKept> segments = evidence_.segments();
    for (std::size_t i = 0; i < segments.size(); ++i) half[is_held_out(i) ? 1 : 0].push_back(segments[i]);
    const double ratio = evidence_.result().model.pixel_sigma / options_.core.pixel_sigma;
    return {ratio * pixel_noise(half[0]).factor, ratio * pixel_noise(half[1]).factor};
  }

  Problem fit(const std::vector<bool>& estimated) {
    begin("fit " + std::to_string(++fits_));
    fits_left_.take();
    const Problem problem = evidence_.fit(terms_, estimated, start_);
    pixels_ = pixel_noise(evidence_.result().kept);
    return problem;
  }

  /// Without effects.
  void fit_plain() {
    if (terms_.empty()) {
      terms_ = catalogue_.terms;
      start_.assign(terms_.size(), 0);
      begin_with_known();
      given_terms_ = terms_.size();
    }
    plain_ = fit(std::vector<bool>(terms_.size(), false));
  }

  /// A model that is so wrong that odometry diverges leaves nothing to be fitted. Says so; empty: it does not diverge.
  std::string lost_odometry() const {
    std::map<std::string, std::uint32_t> count;
    for (const auto& [name, n] : evidence_.result().counters) count[name] = n;
    const std::uint32_t offered = evidence_.result().health.frames_offered;  // every third image of a camera with 30 Hz
    const bool used = 2 * count["frames_used"] > offered, seen = 2 * count["frames_few_tracks"] < count["frames"];
    if (used || !seen || (count["filter_restarts"] == 0 && count["frames_used"] > 0)) return "";
    return "odometry diverges with this model: " + std::to_string(count["filter_restarts"]) + " restarts, " +
           std::to_string(count["frames_used"]) + " of " + std::to_string(offered) +
           " images used; look for something large: the lens model, the resolution that the calibration was made at, the extrinsics";
  }

  bool judgeable() {
    const std::size_t n = evidence_.result().kept.size();
    int seen = 0;
    if (n >= kFewestSegments) {
      for (const Candidate& c : catalogue_.candidates) seen += test_effect(plain_, c, {}).seen > 0 ? 1 : 0;
    }
    out_.judged = seen > 2;
    out_.lost = lost_odometry();
    if (!out_.lost.empty()) {
      out_.judged = true;
      return false;
    }
    if (n < kFewestSegments) {
      out_.sentence = "too short or too still to judge: " + std::to_string(n) + " informative segments of 4 s, at least " +
                      std::to_string(kFewestSegments) + " are needed; move the device about and along all axes for 20 s or more";
    } else if (!out_.judged) {
      out_.sentence = "too still to judge: " + std::to_string(seen) + " of " + std::to_string(catalogue_.candidates.size()) +
                      " effects would have shown; needs " + needs("");
    }
    return out_.judged;
  }

  /// Less noise than stated is no fault, as in the raw samples (imu_noise.h): it was stated on purpose, and corner tracks follow
  /// their own error for many images, which differences of neighbours do not show and a stated noise must cover.
  /// Image noise above the stated one shows when the effects are in the model; then everything is weighed again.
  void find_effects() {
    out_.fit_before = evidence_.result();
    search();
    for (int round = 0; round < decision::kNoiseRounds && fits_left_.allows() && !lens_has_no_name() && pixel_noise_is_above(); ++round) {
      fit_plain();
      search();
      noisy_pixels_ = true;
    }
    find_pixel_factor();
    if (!selection_.accepted.empty() || noisy_pixels_) out_.fit_after = evidence_.result();
    out_.cut_short = fits_left_.used_up();
    collect();
  }

  void search() {
    terms_.resize(given_terms_);
    start_.resize(given_terms_);
    SelectionOptions options;
    options.known = known_;
    options.fits = &fits_left_;
    Problem last = plain_;
    const Refit refit = [this, &last](const std::vector<int>& accepted) {
      if (accepted.empty()) return plain_;
      std::vector<bool> estimated(terms_.size(), false);
      std::vector<TermGroup> groups;
      for (int c : accepted) {
        mark(catalogue_.candidates[c], &estimated);
        groups.push_back(catalogue_.candidates[c].columns);
      }
      begin_at(last, groups);
      last = fit(estimated);
      return last;
    };
    selection_ = select_effects(catalogue_.candidates, options, refit);
    look_beyond();
  }

  /// The next fit begins at what the rows of the last one say: its odometry knows the effects then.
  void begin_at(const Problem& problem, const std::vector<TermGroup>& groups) {
    const Solution s = solve(with_groups(with_prior(problem.all, problem.prior), problem.n_theta, groups));
    int at = problem.n_theta;
    for (const TermGroup& g : groups) {
      for (int i = 0; i < g.count; ++i) {
        const double most = 3 * terms_[g.first + i].size;
        start_[g.first + i] = std::clamp(s.x(at++), -most, most);
      }
    }
  }

  /// Polynomials come near a lens that has no name here; what is left looks like noise.
  bool lens_has_no_name() const {
    return std::any_of(selection_.accepted.begin(), selection_.accepted.end(), [this](const Accepted& a) {
      const Candidate& c = selection_.candidates[a.candidate];
      return c.name == "unlisted" && terms_[c.columns.first].term.kind >= static_cast<int>(SEGCAL_NS::TermKind::image_u);
    });
  }

  bool pixel_noise_is_above() {
    find_pixel_factor();
    const double so_far = evidence_.options().pixel_sigma / options_.core.pixel_sigma, above = out_.pixels.factor / so_far - 1;
    if (above <= std::max(decision::kNoiseAbove, decision::kNoiseSigmas * out_.pixels.sigma / so_far)) return false;
    evidence_.options().pixel_sigma = out_.pixels.factor * options_.core.pixel_sigma;
    return true;
  }

  /// At the last fit, over the stated noise. What the model leaves in all is an upper bound of noise: near neighbours differ
  /// by more where a step of the calibration is not in the fit.
  void find_pixel_factor() {
    const double ratio = evidence_.result().model.pixel_sigma / options_.core.pixel_sigma;
    std::vector<TermGroup> groups;
    for (const Accepted& a : selection_.accepted) groups.push_back(selection_.candidates[a.candidate].columns);
    Problem bare = selection_.problem;
    bare.noise = 0;
    if (pixels_.factor > 1) pixels_.factor = std::min(pixels_.factor, std::max(1.0, std::sqrt(dispersion(bare, groups))));
    out_.pixels = pixels_;
    out_.pixels.factor *= ratio;
    out_.pixels.sigma *= ratio;
  }

  void mark(const Candidate& c, std::vector<bool>* estimated) {
    for (int i = 0; i < c.columns.count; ++i) {
      (*estimated)[c.columns.first + i] = true;
    }
  }

  /// Terms that the catalogue has not, beside what it has; a catalogue's effect that they make superfluous goes.
  void look_beyond() {
    if (!options_.dictionary) return;
    begin("terms beyond the catalogue");
    Beyond beyond(&evidence_, &terms_, &start_, &selection_, &fits_left_, has_temperature_);
    beyond.run([this](const std::vector<bool>& estimated) { return fit(estimated); });
  }

  /// Not below the stated noise: what stays within it is no disagreement.
  Floor noise_floor() const {
    const double factor = std::max(std::sqrt(selection_.problem.noise), pixels_.factor);
    return {factor * factor, 2 * factor * pixels_.sigma};
  }

  void collect() {
    for (const Rejected& r : selection_.rejected) out_.rejected.push_back({selection_.candidates[r.candidate].name, r.why});
    for (int c : selection_.cannot_tell) {
      out_.cannot_tell.push_back({selection_.candidates[c].name, "needs " + needs(selection_.candidates[c].name)});
    }
    if (!has_temperature_) {
      for (const char* name : {"gyro_temperature", "accel_temperature"}) out_.cannot_tell.push_back({name, "needs " + needs(name)});
    }
    for (std::size_t i = 0; i < selection_.alone.size(); ++i) {
      const EffectTest& t = selection_.alone[i];
      out_.scores.push_back({selection_.candidates[i].name, t.statistic, t.log10_p, t.seen});
    }
  }

  void measure_gap() {
    const HeldOut held_out{selection_, terms_, noise_floor()};
    report_gap(held_out, evidence_.result(), &out_);
    find_where();
    if (noisy_pixels_ && !lens_has_no_name() && out_.open_excess <= (1 - decision::kNamesFrom) * out_.before.total) name_pixel_noise();
    add_noise_gap(noise_effects_, &out_);
  }

  /// Where something else is open, what the points show beside noise is that.
  void name_pixel_noise() {
    out_.pixel_sigma = evidence_.options().pixel_sigma;
    const DiagnosedParameter factor{"pixel_noise.factor", out_.pixels.factor, out_.pixels.sigma, "-"};
    noise_effects_.push_back(noise_effect("pixel_noise", {factor}, {pixel_halves()}));
  }

  void find_where() {
    begin("structure of the residuals");
    std::vector<ImuData> imu;
    for (const Recording& r : sessions_) imu.push_back(r.imu);
    const auto lists_of = [&imu](const ReplayResult& fit) { return residual_lists(fit.kept, fit.model.pixel_sigma, imu); };
    out_.where = find_structure(lists_of(out_.fit_before), kStructure, 2);
    const std::vector<Structure> after = find_structure(lists_of(evidence_.result()), kAll, kCauses);
    refuse_where_structure_is_left(after, &out_);
    for (const Structure& s : out_.where) {
      const auto same = std::find_if(after.begin(), after.end(), [&s](const Structure& a) {
        return a.sensor == s.sensor && a.axis == s.axis && a.against == s.against;
      });
      out_.left.push_back(same == after.end() ? Structure{} : *same);
      out_.where_after.push_back(out_.left.back().correlation);
    }
  }

  const std::vector<Recording>& sessions_;
  const DiagnoseOptions& options_;
  bool has_temperature_;
  Catalogue catalogue_;
  Evidence evidence_;
  std::string step_;
  int fits_ = 0;
  Budget fits_left_{decision::kFits};
  std::vector<TermInfo> terms_;
  std::vector<double> start_;
  std::vector<int> known_;
  std::size_t given_terms_ = 0;
  Problem plain_;
  PixelNoise pixels_;
  Selection selection_;
  bool noisy_pixels_ = false;
  std::vector<NoiseEffect> noise_effects_;
  Diagnosis out_;
};

}  // namespace

Diagnosis diagnose(const std::vector<Recording>& sessions, const DiagnoseOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Diagnosis out = Diagnoser(sessions, options).run();
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace host
