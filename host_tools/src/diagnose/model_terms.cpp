#include "diagnose/model_terms.h"

#include "sensors/effect_names.h"

namespace host::diagnosis {

Catalogue core_catalogue(bool has_temperature) {
  using namespace SEGCAL_NS;
  Catalogue out;
  for (int e = 0; e < kEffects; ++e) {
    const EffectEntry& entry = effect_entry(e);
    if (!has_temperature && hypothesis(entry.name).asks == Asks::temperature) continue;
    out.candidates.push_back(
        {entry.name, {static_cast<int>(out.terms.size()), entry.n}, std::vector<double>(entry.n, entry.prior_sigma)});
    for (int i = 0; i < entry.n; ++i) {
      const Term t = effect_term(e, i);
      out.terms.push_back({{static_cast<int>(t.kind), t.a, t.b, t.c},
                           entry.name,
                           e,
                           std::string(entry.name) + "." + entry.parameter[i],
                           entry.unit,
                           entry.prior_sigma});
    }
  }
  return out;
}

TermInfo term_info(const CoreTerm& term) {
  using namespace SEGCAL_NS;
  const auto byte = [](int v) { return static_cast<std::uint8_t>(v); };
  const Term t{static_cast<TermKind>(term.kind), byte(term.a), byte(term.b), byte(term.c)};
  char name[64], unit[32];
  write_term_name(t, name, sizeof name, unit, sizeof unit);
  return {term, "", -1, name, unit, term_prior_sigma(t)};
}

std::vector<TermInfo> dictionary(bool has_temperature) {
  using namespace SEGCAL_NS;
  std::vector<TermInfo> out;
  const auto add = [&out](const Term& t) {
    int effect, parameter;
    if (find_effect(t, &effect, &parameter)) return;
    out.push_back(term_info({static_cast<int>(t.kind), t.a, t.b, t.c}));
  };
  const auto byte = [](Signal s) { return static_cast<std::uint8_t>(s); };
  for (int axis = 0; axis < 6; ++axis) {
    const TermKind kind = static_cast<TermKind>(axis);
    const bool gyro = axis < 3;
    for (Signal s : {Signal::abs_w, Signal::time, Signal::cos_heading, Signal::sin_heading}) add({kind, byte(s), 0, 0});
    for (Signal s : {Signal::cos_heading, Signal::sin_heading}) add({kind, byte(Signal::cos_heading), byte(s), 0});
    for (Signal s : {Signal::dwx, Signal::dwy, Signal::dwz}) {
      if (gyro) add({kind, byte(s), 0, 0});  // for the accelerometer that is a lever arm: p_CI or accel_axis_offset
    }
    if (gyro)
      add({kind, static_cast<std::uint8_t>(byte(Signal::dwx) + axis),
           static_cast<std::uint8_t>(byte(Signal::abs_wx) + axis), 0});
    for (int i = 0; i < 3; ++i) {
      const Signal wi = static_cast<Signal>(byte(Signal::wx) + i), fi = static_cast<Signal>(byte(Signal::fx) + i);
      if (!gyro) add({kind, byte(wi), 0, 0});  // for the gyroscope that is its scale, its misalignment or r_CI
      for (int j = 0; j < 3; ++j) {
        const Signal wj = static_cast<Signal>(byte(Signal::wx) + j), fj = static_cast<Signal>(byte(Signal::fx) + j);
        if (j >= i) add({kind, byte(wi), byte(wj), 0});
        if (j >= i) add({kind, byte(fi), byte(fj), 0});
        add({kind, byte(wi), byte(fj), 0});
      }
      if (has_temperature) add({kind, byte(wi), byte(Signal::warmth), 0});
    }
  }
  for (const TermKind kind : {TermKind::image_u, TermKind::image_v}) {
    for (int total = 2; total <= 5; ++total) {
      for (int x = total; x >= 0; --x)
        add({kind, static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(total - x), 0});
    }
  }
  return out;
}

}  // namespace host::diagnosis
