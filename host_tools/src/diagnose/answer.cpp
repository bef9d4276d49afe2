#include "diagnose/answer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diagnose/chi_square.h"
#include "diagnose/decision.h"
#include "diagnose/exposure_offset.h"
#include "formatted.h"
#include "sensors/effect_terms.h"

namespace host::diagnosis {
namespace {

const char* signal_words(int signal) {
  static const char* const kWords[] = {"",
                                       "rate x",
                                       "rate y",
                                       "rate z",
                                       "the size of rate x",
                                       "the size of rate y",
                                       "the size of rate z",
                                       "the size of the rate",
                                       "accel x",
                                       "accel y",
                                       "accel z",
                                       "the change of rate x",
                                       "the change of rate y",
                                       "the change of rate z",
                                       "temperature",
                                       "time",
                                       "the cosine of the heading",
                                       "the sine of the heading"};
  return signal >= 0 && signal < SEGCAL_NS::kNamedSignals ? kWords[signal] : "";
}

std::string powers(int x, int y, int row) {
  std::string out;
  const auto add = [&out](const char* name, int power) {
    if (power == 0) return;
    out += (out.empty() ? "" : " times ") + std::string(name) + (power > 1 ? "^" + std::to_string(power) : "");
  };
  add("image x", x);
  add("image y", y);
  add("row", row);
  return out;
}

double largest_ratio(const DiagnosedEffect& e, std::size_t* at) {
  double best = -1;
  for (std::size_t i = 0; i < e.parameters.size(); ++i) {
    const DiagnosedParameter& p = e.parameters[i];
    const double ratio = p.sigma > 0 ? std::abs(p.value) / p.sigma : 0;
    if (ratio <= best) continue;
    best = ratio;
    *at = i;
  }
  return best;
}

std::string sentence_of(const DiagnosedEffect& e) {
  std::size_t i = 0;
  if (e.parameters.empty()) return e.name;
  largest_ratio(e, &i);
  const DiagnosedParameter& p = e.parameters[i];
  const std::string value = in_words(p.value, p.sigma, p.unit);
  if (e.name == "time_offset") return "camera and gyroscope disagree by " + value + ": " + e.name;
  if (e.name == kExposureOffset) return kappa_in_words(p.value, p.sigma, 0);
  const std::string most = e.parameters.size() > 1 ? "most in " + p.name.substr(p.name.find('.') + 1) + ", " : "";
  return hypothesis(e.name).looks_like + (", " + most) + value + ": " + e.name;
}

std::string gap_words(const Diagnosis& d) {
  if (d.effects.size() == 1 && std::isnan(d.effects[0].gap_closed))
    return formatted("Without it nothing can be fitted; with it an excess of %.2g is left", d.after.total);
  return "Held-out excess " + formatted("%.2g", d.before.total) + " -> " + formatted("%.2g", d.after.total) + ", " +
         formatted("%.1f", 100 * d.gap_closed) + " % of the gap";
}

std::string where_words(const Diagnosis& d) {
  if (d.where.empty()) return "";
  const Structure& s = d.where.front();
  return ", most in " + s.sensor + " " + s.axis + ", which follows " + s.against;
}

std::string effects_in_words(const Diagnosis& d) {
  std::string out;
  for (const DiagnosedEffect& e : d.effects) {
    out += (out.empty() ? "" : "; ") + e.words;
    for (const std::string& other : e.or_else) out += " or " + other;
  }
  return out;
}

}  // namespace

std::string in_words(double value, double sigma, const std::string& unit) {
  double scale = 1;
  std::string prefix;
  if (unit.rfind("s", 0) == 0 && (unit.size() == 1 || unit[1] == '/')) {
    const double size = std::max(std::abs(value), sigma);
    if (size < 1e-4) {
      scale = 1e6;
      prefix = "u";
    } else if (size < 1) {
      scale = 1e3;
      prefix = "m";
    }
  }
  const double v = value * scale, s = sigma * scale;
  char out[96];
  if (!(s > 0)) {
    std::snprintf(out, sizeof out, "%.3g %s%s", v, prefix.c_str(), unit.c_str());
  } else if (std::abs(v) >= 1e-2 && std::abs(v) < 1e4) {
    const int digits = std::min(6, std::max(0, static_cast<int>(std::ceil(-std::log10(s)))));
    std::snprintf(out, sizeof out, "%.*f %s%s +- %.1g", digits, v, prefix.c_str(), unit.c_str(), s);
  } else {
    std::snprintf(out, sizeof out, "%.2g %s%s +- %.1g", v, prefix.c_str(), unit.c_str(), s);
  }
  return out;
}

std::string in_words(const CoreTerm& t) {
  static const char* const kAxis[] = {"gyro x", "gyro y", "gyro z", "accel x", "accel y", "accel z"};
  if (t.kind < 6) {
    std::string out = std::string(kAxis[t.kind]) + " error follows " + signal_words(t.a);
    if (t.b > 0) out += std::string(t.b == t.a ? " squared" : " times ") + (t.b == t.a ? "" : signal_words(t.b));
    return out;
  }
  const bool u = t.kind == static_cast<int>(SEGCAL_NS::TermKind::image_u);
  return std::string("image ") + (u ? "x" : "y") + " error follows " + powers(t.a, t.b, t.c);
}

DiagnosedEffect named(const Candidate& candidate, const Accepted& accepted, const std::vector<TermInfo>& terms) {
  DiagnosedEffect out;
  out.name = candidate.name;
  out.statistic = accepted.test.statistic;
  out.dof = accepted.test.seen;
  out.log10_p = accepted.test.log10_p;
  for (int i = 0; i < candidate.columns.count; ++i) {
    const TermInfo& t = terms[candidate.columns.first + i];
    out.parameters.push_back({t.name, accepted.test.value(i), accepted.test.sigma(i), t.unit});
  }
  const TermInfo& first = terms[candidate.columns.first];
  out.words = !first.effect.empty() ? sentence_of(out) : "unlisted effect: " + in_words(first.term);
  return out;
}

DiagnosedEffect named(const Shift& shift, const Accepted& accepted) {
  DiagnosedEffect out;
  out.name = kCalibrationShift;
  out.statistic = accepted.test.statistic;
  out.dof = accepted.test.seen;
  out.log10_p = std::min(0.0, accepted.test.log10_p + std::log10(std::max(1, shift.trials)));
  out.parameters.push_back({"calibration_shift.time", shift.time_s, shift.uncertainty_s, "s"});
  const std::string& block = shift.block.name;
  const std::string unit = step_size(block).unit;
  for (int i = 0; i < shift.block.columns.count; ++i) {
    const std::string axis = i < 3 ? std::string(1, "xyz"[i]) : std::to_string(i);
    out.parameters.push_back(
        {"calibration_shift." + block + "." + axis, accepted.test.value(i), accepted.test.sigma(i), unit});
  }
  std::size_t most = 1;
  for (std::size_t i = 1; i < out.parameters.size(); ++i) {
    if (std::abs(out.parameters[i].value) > std::abs(out.parameters[most].value)) most = i;
  }
  out.words = "the calibration changed at " + formatted("%.0f", shift.time_s) + " s, " + block + " by " +
              in_words(out.parameters[most].value, out.parameters[most].sigma, unit) + ": calibration_shift";
  return out;
}

DiagnosedEffect named_noise(const std::string& effect, const std::vector<DiagnosedParameter>& factors) {
  DiagnosedEffect out;
  out.name = effect;
  out.parameters = factors;
  out.dof = static_cast<int>(factors.size());
  for (const DiagnosedParameter& p : factors) {
    const double z = p.sigma > 0 ? (p.value - 1) / p.sigma : 0;
    out.statistic += z * z;
    out.words += (out.words.empty() ? "" : ", ") + p.name.substr(0, p.name.find('.')) + " is " +
                 in_words(p.value, p.sigma, "times the stated one");
  }
  out.log10_p = log10_upper_tail(out.statistic, out.dof);
  out.words += ": " + effect;
  return out;
}

namespace {

void say_cut_short(Diagnosis* d) {
  if (!d->cut_short) return;
  d->sentence += ". The search ended before it was done, to bound its time: more may be there";
}

void conclude_fits(Diagnosis* d) {
  if (!d->judged) {
    d->verdict = "consistent";
    return;
  }
  if (!d->lost.empty()) {
    d->verdict = "unexplained";
    d->sentence = d->lost;
    return;
  }
  const bool open = d->before.total > 0 && d->open_excess > (1 - decision::kNamesFrom) * d->before.total;
  if (d->effects.empty()) {
    d->verdict = open ? "unexplained" : "consistent";
    d->sentence = open ? "something is missing in the model that has no name here: excess " +
                             formatted("%.2g", d->before.total) + " of chi2 per degree of freedom" + where_words(*d)
                       : "model and measurements agree: nothing is missing that this motion would have shown";
    say_cut_short(d);
    return;
  }
  d->verdict = open ? "partly_explained" : "explained";
  d->sentence =
      effects_in_words(*d) + ". " + gap_words(*d) + (open ? "; the rest has no name here" + where_words(*d) : "");
  say_cut_short(d);
}

/// A size of gravity that no effect of the accelerometer explains: one that acts at rest.
bool gravity_is_open(const Diagnosis& d) {
  return std::any_of(d.faults.begin(), d.faults.end(), [](const Fault& f) { return f.is_small_gravity(); }) &&
         std::none_of(d.effects.begin(), d.effects.end(), [](const DiagnosedEffect& e) {
           return e.name == "accel_temperature" || e.name == "accel_nonlinearity";
         });
}

}  // namespace

void conclude(Diagnosis* d) {
  const bool open = gravity_is_open(*d), faulty = spoil_fits(d->faults) || (open && d->effects.empty());
  if (faulty && !d->faults_accepted) {
    d->verdict = "bad_data";
    d->sentence = in_words(d->faults);
    return;
  }
  conclude_fits(d);
  if (faulty || open)
    d->sentence += ". The data are at fault, which may be behind this or hide more: " + in_words(d->faults);
}

}  // namespace host::diagnosis
