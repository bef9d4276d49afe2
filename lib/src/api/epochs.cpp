// The C API's view of epochs and sessions, what each alone says about the calibration, of changes and of their course.
#include "api/handle.h"
#include "information/marginal.h"

namespace SEGCAL_NS {
namespace {

/// The optimum of the prior and what was condensed at `at`, and its sigmas as printed, for the noise of the last
/// release.
void read_rows(const SegmentInformation<Real>& rows, const Calibration<Real>& at, Device<Real>& device,
               segcal_epoch_t* out) {
  const ThetaPrior<Real>& prior = device.options().prior;
  const int n = at.columns();
  Real row[kMaxTheta + 1], work[kMaxTheta + 1];
  Workspace<Real>::Lease memory;
  device.begin_question(&memory);
  PackedTriangle<Real> T(memory.numbers<packed_size(kMaxTheta + 1)>(), n + 1);
  write_prior(prior, at, &T);
  fold_moved(rows, at, at, &T);
  Calibration<Real> theta = at;
  for (int i = 0; i < n; ++i) row[i] = T(i, n);
  back_substitute(T, n, row);
  add_step(&theta, row);
  parameter_values(prior.mean, theta, out->value);
  for (int i = 0; i < n; ++i) {
    const PrintedValue<Real> value = printed_value(prior.mean, theta, i);
    const Real sigma =
        marginal_sigma(T, n, value.first, value.weight, value.count, work) * device.report().release.noise_scale;
    const Real before = sigma_before(value, prior.sigma);
    out->sigma[i] = static_cast<double>(sigma < before ? sigma : before);
  }
  memory.end();
  out->n_parameters = n;
}

/// A build without a history has a course of another type.
template <class C>
void read_course(const C& course, int n, segcal_course_t* out) {
  if constexpr (kHistory > 0) {
    out->courses = course.forms;
    out->sessions = course.sessions;
    for (int f = 0; f < kCourseForms; ++f) out->ln_odds[f] = static_cast<double>(course.ln_odds[f]);
    out->rate_of = course.rate_form >= 0 && course.rate_form < kCourseForms ? 1u << course.rate_form : 0;
    out->step_session = course.step_session;
    out->n_parameters = n;
    for (int i = 0; i < n && out->rate_of != 0; ++i) {
      out->rate[i] = static_cast<double>(course.rate[i]);
      out->sigma[i] = static_cast<double>(course.sigma[i]);
    }
  }
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" [[gnu::cold]] int segcal_get_epoch(segcal_t* device, int32_t index, segcal_epoch_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  CDevice* d = open(device);
  const Epoch<Real>* epoch = d ? d->device.epochs().find(index) : nullptr;
  if (!epoch) return SEGCAL_ERROR_STATE;
  if (!d->device.epochs_at_rest()) return SEGCAL_ERROR_BUSY;
  *out = segcal_epoch_t{};
  read_rows(epoch->information, epoch->theta, d->device, out);
  out->segments = epoch->segments;
  out->first_session = epoch->first_session;
  out->last_session = epoch->last_session;
  return SEGCAL_OK;
}

extern "C" [[gnu::cold]] int segcal_get_history(segcal_t* device, int32_t index, segcal_epoch_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  CDevice* d = open(device);
  const HistoryEntry<Real>* entry = d ? d->device.history().find(index) : nullptr;
  if (!entry) return SEGCAL_ERROR_STATE;
  if (!d->device.epochs_at_rest()) return SEGCAL_ERROR_BUSY;
  *out = segcal_epoch_t{};
  read_rows(entry->information, entry->theta, d->device, out);
  out->segments = entry->segments;
  out->first_session = out->last_session = entry->session;
  out->temperature_degC = 25 + static_cast<double>(entry->mean_warmth());
  out->changes = entry->changes;
  return SEGCAL_OK;
}

extern "C" [[gnu::cold]] int segcal_get_course(const segcal_t* device, segcal_course_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d || kHistory == 0) return SEGCAL_ERROR_STATE;
  *out = segcal_course_t{};
  read_course(d->device.report().course, d->device.theta().columns(), out);
  return SEGCAL_OK;
}

extern "C" [[gnu::cold]] int segcal_get_change(const segcal_t* device, int32_t index, segcal_change_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  const auto& changes = d->device.changes();
  const Change<Real>* change = index == -1 ? changes.open() : changes.find(index);
  if (!change) return SEGCAL_ERROR_STATE;
  *out = segcal_change_t{};
  out->open = index == -1 ? 1 : 0;
  out->before_session = change->before_session;
  out->after_session = change->after_session;
  out->t_ns = change->t_ns;
  out->n_parameters = change->n;
  for (int i = 0; i < change->n; ++i) {
    out->step[i] = static_cast<double>(change->step[i]);
    out->sigma[i] = static_cast<double>(change->sigma[i]);
  }
  return SEGCAL_OK;
}
