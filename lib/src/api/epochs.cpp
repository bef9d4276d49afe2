// The C API's view of epochs, what each alone says about the calibration, and of changes.
#include "api/handle.h"
#include "information/marginal.h"

namespace SEGCAL_NS {
namespace {

/// The optimum of the prior and the epoch, and its sigmas as printed, for the noise of the last release.
void read_epoch(const Epoch<Real>& epoch, Device<Real>& device, segcal_epoch_t* out) {
  const ThetaPrior<Real>& prior = device.options().prior;
  const int n = epoch.columns();
  Real row[kMaxTheta + 1], work[kMaxTheta + 1];
  Workspace<Real>::Lease memory;
  device.begin_question(&memory);
  PackedTriangle<Real> T(memory.numbers<packed_size(kMaxTheta + 1)>(), n + 1);
  write_prior(prior, epoch.theta, &T);
  fold_moved(epoch.information, epoch.theta, epoch.theta, &T);
  Calibration<Real> theta = epoch.theta;
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
  out->segments = epoch.segments;
  out->first_session = epoch.first_session;
  out->last_session = epoch.last_session;
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
  read_epoch(*epoch, d->device, out);
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
