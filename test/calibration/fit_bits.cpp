// fit_bits: the bits of a few fits, and on the standard error how many slices they took. Built with and without
// SEGCAL_KEEP_ELIMINATIONS (compare_fits.cmake): what is kept must be what would be made again.
#include <cstdio>
#include <cstring>
#include <memory>

#include "../support/cast.h"
#include "../support/synthetic_segments.h"
#include "calibration/calibrator.h"

using namespace SEGCAL_NS;

namespace {

struct Solver {
  Calibrator<float> calibrator;
  SegmentEliminator<float> eliminator;
};

void print_bits(const char* name, const float* values, int n) {
  std::printf("  %s", name);
  for (int i = 0; i < n; ++i) {
    std::uint32_t bits;
    std::memcpy(&bits, values + i, sizeof bits);
    std::printf(" %08x", bits);
  }
  std::printf("\n");
}

/// Terms are estimated beside theta.
int fit(const char* name, const test::SyntheticOptions& options, const std::vector<Term>& terms) {
  const test::SyntheticSession session(options);
  const auto solver = std::make_unique<Solver>();
  test::Copies<float> copies(session.segments);
  ThetaPrior<float> prior;
  prior.mean = test::cast<float>(session.nominal);
  for (const Term& term : terms) prior.mean.effects.add(term, 0.0f);
  default_prior_sigmas(prior.mean, prior.sigma);
  for (std::size_t i = 0; i < terms.size(); ++i) prior.sigma[prior.mean.effect_column() + i] = 0.01f;
  solver->calibrator.begin(copies.pointer, copies.count(), prior, prior.mean, MeasurementModel<float>());
  int slices = 1;
  for (int run = 0; run < 2; ++run) {  // as a device does: what the first one kept is not what the second may take
    while (!solver->calibrator.run_step(CalibratorOptions{}, &solver->eliminator)) ++slices;
    solver->calibrator.reject_outliers(5);
  }
  const CalibrationFit<float>& made = solver->calibrator.fit();
  std::printf("%s: %d segments, %d ties, %d partitions, converged %d after %d\n", name, copies.count(),
              solver->calibrator.ties().count(), solver->calibrator.partitions(), made.converged ? 1 : 0,
              made.iterations);
  const float cost[] = {made.start_cost, made.cost, made.chi2, made.dof};
  print_bits("fit", cost, 4);
  const PackedTriangle<float> T = solver->calibrator.theta_triangle();
  for (int i = 0; i < T.columns(); ++i) print_bits("theta", T.row(i) + i, T.columns() - i);
  for (const auto& copy : copies.owned) {
    for (int k = 0; k < copy->n_keyframes; ++k) {
      print_bits("p_GI", copy->states.x[k].p_GI.data(), 3);
      print_bits("b_g", copy->states.x[k].b_g.data(), 3);
    }
    for (int j = 0; j < copy->n_landmarks; ++j) print_bits("rho", &copy->states.landmark[j].rho, 1);
  }
  return slices;
}

}  // namespace

int main() {
  test::SyntheticOptions joined;
  joined.segments = 3;
  joined.keyframes = 8;
  joined.landmarks = 40;
  test::SyntheticOptions tied = joined;  // ties take columns: not all triangles of the eight segments find room
  tied.segments = 8;
  tied.seed = 2;
  tied.landmarks = 25;
  tied.gap = 1.5;
  tied.shared = 12;
  test::SyntheticOptions far = joined;  // steps are taken back
  far.seed = 3;
  far.start_error = 12;
  int slices = fit("joined", joined, {}) + fit("tied", tied, {}) + fit("far", far, {});
  slices += fit("clock and accelerometer", joined,
                {kTimeOffsetTerm,
                 {TermKind::accel_x, static_cast<std::uint8_t>(Signal::fx), static_cast<std::uint8_t>(Signal::fx)}});
  std::fprintf(stderr, "%d\n", slices);
  return 0;
}
