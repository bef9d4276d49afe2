// The C API's side of effects: the catalogue, names and units of terms, and the rows that diagnosis works on.
#include "api/handle.h"
#include "sensors/effect_names.h"
#include "sensors/warm_camera.h"

namespace SEGCAL_NS {
namespace {

constexpr int kMostPower = 6;

}  // namespace

void describe(const Term& term, segcal_parameter_t* out) {
  out->prior_sigma = term_prior_sigma(term);
  write_term_name(term, out->name, SEGCAL_NAME_LENGTH, out->unit, SEGCAL_UNIT_LENGTH);
}

bool term_from_c(const segcal_term_t& in, Term* out) {
  *out = {static_cast<TermKind>(in.kind), in.a, in.b, in.c};
  int effect, parameter;
  if (in.kind > SEGCAL_TERM_CAMERA_WARMTH) return false;
  if (in.kind == SEGCAL_TERM_CAMERA_WARMTH) return kHasWarmCamera && find_effect(*out, &effect, &parameter);
  if (in.kind >= SEGCAL_TERM_IMAGE_U) return in.a <= kMostPower && in.b <= kMostPower && in.c <= kMostPower;
  if (in.kind <= SEGCAL_TERM_ACCEL_Z) return in.a < kNamedSignals && in.b < kNamedSignals && in.c == 0;
  return find_effect(*out, &effect, &parameter);
}

segcal_term_t term_to_c(const Term& term) { return {static_cast<std::uint8_t>(term.kind), term.a, term.b, term.c}; }

}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

[[gnu::cold]] int segcal_get_effect(int32_t index, segcal_effect_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  if (index < 0 || index >= kEffects) return SEGCAL_ERROR_SIZE;
  const EffectEntry& e = effect_entry(index);
  *out = segcal_effect_t{e.name, e.n, {}, e.unit, e.prior_sigma, e.looks_like, e.confounded};
  for (int i = 0; i < e.n; ++i) out->parameter[i] = e.parameter[i];
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_effect_terms(int32_t index, segcal_term_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  if (index < 0 || index >= kEffects) return SEGCAL_ERROR_SIZE;
  for (int i = 0; i < effect_entry(index).n; ++i) out[i] = term_to_c(effect_term(index, i));
  return effect_entry(index).n;
}

[[gnu::cold]] int segcal_describe_term(const segcal_term_t* term, segcal_parameter_t* out) {
  if (!term || !out) return SEGCAL_ERROR_NULL;
  Term t;
  if (!term_from_c(*term, &t)) return SEGCAL_ERROR_CONFIG;
  *out = segcal_parameter_t{};
  describe(t, out);
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_get_terms(const segcal_t* device, segcal_term_t* term, double* value, int32_t capacity) {
  if (!term || !value) return SEGCAL_ERROR_NULL;
  if (capacity < 0) return SEGCAL_ERROR_SIZE;
  const CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  const EffectTerms<Real>& effects = d->device.theta().effects;
  const int n = effects.count() < capacity ? effects.count() : capacity;
  for (int i = 0; i < n; ++i) {
    term[i] = term_to_c(effects.term[i]);
    value[i] = static_cast<double>(effects.value[i]);
  }
  return n;
}

[[gnu::cold]] int segcal_get_effect_scores(segcal_t* device, segcal_effect_score_t* out, int32_t capacity) {
  if (!out) return SEGCAL_ERROR_NULL;
  if (capacity < 0) return SEGCAL_ERROR_SIZE;
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  EffectMonitor<Real>& monitor = d->device.monitor();
  int n = 0;
  for (int e = 0; e < kEffects && n < capacity; ++e) {
    const int parameters = monitor.active() ? monitor.parameters(e) : 0;
    if (parameters == 0) continue;
    const EffectScore<Real> score = monitor.score(e);
    segcal_effect_score_t& to = out[n++] = segcal_effect_score_t{};
    to.effect = e;
    to.n_parameters = parameters;
    to.dof = score.dof;
    to.segments = monitor.segments();
    to.statistic = static_cast<double>(score.statistic);
    to.chi2_per_dof = static_cast<double>(monitor.chi2_per_dof());
    for (int i = 0; i < parameters; ++i) {
      to.estimate[i] = static_cast<double>(score.estimate[i]);
      to.sigma[i] = static_cast<double>(score.sigma(i, parameters));
    }
  }
  return n;
}

[[gnu::cold]] int segcal_linearise(segcal_t* device, const uint8_t* use_slot, const segcal_term_t* candidate,
                                   int32_t n_candidates, double* triangle, int32_t capacity, int32_t* n_theta,
                                   int32_t* n_terms, int32_t* dof) {
  if (!use_slot || !triangle || !n_theta || !n_terms || !dof || (!candidate && n_candidates > 0))
    return SEGCAL_ERROR_NULL;
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  const int n = d->device.theta().columns(), taken = d->device.theta().effects.count();
  if (n_candidates < 0 || n_candidates + taken > SEGCAL_MAX_EFFECT_COLUMNS) return SEGCAL_ERROR_SIZE;
  if (capacity < packed_size(n + n_candidates + 1)) return SEGCAL_ERROR_SIZE;
  CandidateTerms terms;
  for (; terms.n < n_candidates; ++terms.n) {
    if (!term_from_c(candidate[terms.n], &terms.term[terms.n])) return SEGCAL_ERROR_CONFIG;
    if (d->device.theta().effects.place_of(terms.term[terms.n]) >= 0) return SEGCAL_ERROR_CONFIG;
  }
  int used = 0;
  for (int i = 0; i <= SEGCAL_MAX_SEGMENTS; ++i) {
    if (!use_slot[i]) continue;
    if (!find_slot(*d, i)) return SEGCAL_ERROR_STATE;
    ++used;
  }
  if (used == 0) return SEGCAL_ERROR_STATE;
  if (d->device.pending()) return SEGCAL_ERROR_BUSY;
  const Real freedom = d->device.linearise(use_slot, terms);
  const PackedTriangle<Real> T = d->device.calibrator().theta_triangle();
  const Real* from = T.row(0);
  for (int i = 0; i < packed_size(T.columns()); ++i) triangle[i] = static_cast<double>(from[i]);
  *n_theta = n;
  *n_terms = n_candidates;
  *dof = static_cast<int32_t>(freedom + Real(0.5));
  return SEGCAL_OK;
}

}  // extern "C"
