// What is released of a rotation of which one component is not known: at the identity, near a half turn and past it.
#include <cmath>

#include "../support/cases.h"
#include "../support/random.h"
#include "api/release.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// Where a fit stands: R_CI = Exp(d) R_mean, of whose three printed
/// components two are known to 1e-3 rad and `blind` not at all.
template <class S>
struct Fit {
  ThetaPrior<S> prior;
  Calibration<S> theta;
  S storage[packed_size(kMaxTheta + 1)];

  Fit(const Vec3<double>& v_mean, const Vec3<double>& d, int blind) : R_(storage, columns() + 1) {
    theta = prior.mean;
    prior.mean.camera[0].R_CI = so3_exp<S>(v_mean.cast<S>());
    theta.camera[0].R_CI = so3_exp<S>(d.cast<S>()) * prior.mean.camera[0].R_CI;
    default_prior_sigmas(prior.mean, prior.sigma);
    write_prior(prior, theta, &R_);
    const Vec3<S> v = so3_log_near<S>(theta.camera[0].R_CI, so3_log<S>(prior.mean.camera[0].R_CI));
    const Mat3<S> J = so3_right_jacobian_inverse<S>(Vec3<S>(-v));
    for (int i = 0; i < 3; ++i) {
      if (i == blind) continue;
      S row[kMaxTheta + 1] = {};
      for (int k = 0; k < 3; ++k) row[k] = S(1e3) * J(i, k);
      fold_rows(R_, row, 1, columns() + 1, 0, columns() + 1);
    }
  }

  Release<S> release() {
    Release<S> out;
    judge_filter(theta, prior, ReleaseRules<S>{}, &R_, &out);
    return out;
  }

 private:
  int columns() {
    prior.mean.n_cameras = 1;
    prior.mean.camera[0].model = Distortion::radtan;
    prior.mean.camera[0].intrinsics << S(480), S(480), S(320), S(240);
    return prior.mean.columns();
  }
  PackedTriangle<S> R_;
};

/// The released rotation is as near to the fit as the blind component's own step, the blind component stands where it
/// was, and its verdict says so. Half a turn about an axis of the image plane is how phones carry their cameras.
template <class S>
void check_release(std::uint32_t seed) {
  test::Random random(seed);
  const Vec3<double> axes[] = {{1, -1, 0}, {1, 0, 0}, {0.6, 0.5, -0.7}, random.direction()};
  for (const Vec3<double>& axis : axes) {
    for (double angle : {0.3, 2.0, 3.1, 3.141592653589793}) {
      for (int blind = 0; blind < 3; ++blind) {
        const Vec3<double> v = axis.normalized() * angle, d = random.direction() * 0.04;
        const Id id = Id().add("seed", seed).add("angle", angle).add("blind", blind).add("float", sizeof(S) == 4);
        Fit<S> fit(v, d, blind);
        const Release<S> out = fit.release();
        test::check_true(id, "the blind component is fixed", out.verdict[blind] == Verdict::fixed);
        const Mat3<S>& R_mean = fit.prior.mean.camera[0].R_CI;
        const Mat3<S>& R = out.theta.camera[0].R_CI;
        const Vec3<S> before = so3_log<S>(R_mean), after = so3_log_near<S>(R, before);
        // A component of the vector is given back exactly, but for what Exp and Log round: some ulps of pi.
        test::check_near(id, "blind component", double(before(blind)), double(after(blind)),
                         sizeof(S) == 4 ? 4e-6 : 1e-12);
        // It was 0.04 rad off in all; moving one component back moves the rotation by no more than twice that.
        test::check_between(id, "angle to the fit", 0,
                            double(so3_log<S>(Mat3<S>(R * fit.theta.camera[0].R_CI.transpose())).norm()), 0.08);
      }
    }
  }
}

void test_half_turns_stay() {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    check_release<float>(seed);
    check_release<double>(seed);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_half_turns_stay);
  return UNITY_END();
}
