// The core's arithmetic on the target: the same bits as everywhere, in float and in double. The expected numbers are
// those of x86-64; accuracy is tested on the host (test/math).
#include <unity.h>

#include <cstring>

#include "math/elementary.h"
#include "math/qr.h"
#include "math/so3.h"
#include "tests.h"

using namespace SEGCAL_NS;

namespace {

class Bits {
 public:
  template <class S>
  void add(S value) {
    unsigned char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (const unsigned char byte : bytes) hash_ = (hash_ ^ byte) * 0x100000001B3u;
  }
  std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xCBF29CE484222325u;
};

/// Even steps over [-12, 12), through all quadrants and both signs.
template <class S>
std::uint64_t elementary_bits() {
  Bits bits;
  for (int i = -1500; i < 1500; ++i) {
    const S x = S(i) * S(0.0080078125);  // exact in float
    bits.add(sine(x));
    bits.add(cosine(x));
    bits.add(arc_tangent(x));
    bits.add(arc_tangent2(x, S(0.75)));
    bits.add(logarithm(absolute(x) + S(0.03125)));
    bits.add(square_root(absolute(x)));
  }
  return bits.hash();
}

template <class S>
std::uint64_t rotation_bits() {
  Bits bits;
  Mat3<S> R = Mat3<S>::Identity();
  for (int i = 0; i < 200; ++i) {
    R = R * so3_exp<S>(Vec3<S>(S(i) * S(0.03125), S(0.5) - S(i) * S(0.0078125), S(-0.25)));
    const Vec3<S> r = so3_log<S>(R);
    for (int k = 0; k < 3; ++k) bits.add(r(k));
  }
  return bits.hash();
}

template <class S>
std::uint64_t qr_bits() {
  constexpr int n = 13, m = 9;
  S triangle[n * (n + 1) / 2] = {}, block[m * n];
  PackedTriangle<S> R(triangle, n);
  std::uint32_t random = 1;
  for (int round = 0; round < 20; ++round) {
    for (S& x : block) {
      random = random * 1664525u + 1013904223u;
      x = S(std::int32_t(random >> 8) - (1 << 23)) * S(1.0 / (1 << 23));
    }
    fold_rows(R, block, m, n, 0, n);
  }
  Bits bits;
  for (const S x : triangle) bits.add(x);
  return bits.hash();
}

void check(std::uint64_t expected, std::uint64_t actual, const char* what) {
  TEST_ASSERT_EQUAL_HEX32_MESSAGE(std::uint32_t(expected >> 32), std::uint32_t(actual >> 32), what);
  TEST_ASSERT_EQUAL_HEX32_MESSAGE(std::uint32_t(expected), std::uint32_t(actual), what);
}

// A core with single precision only has no root of a double but libm's, which an image cannot link.
#if defined(__ARM_FP) && !(__ARM_FP & 8)
#define DOUBLES(...)
#else
#define DOUBLES(...) __VA_ARGS__
#endif

void elementary_functions_have_the_same_bits() {
  check(0xFCC1FF3A530A83BAu, elementary_bits<float>(), "float");
  DOUBLES(check(0x4899C0785A7398F1u, elementary_bits<double>(), "double");)
}

void rotations_have_the_same_bits() {
  check(0xDF3D1A1AB0267983u, rotation_bits<float>(), "float");
  DOUBLES(check(0xD9B1F68D0CF89BD0u, rotation_bits<double>(), "double");)
}

void qr_has_the_same_bits() {
  check(0xE780D8356094B23Eu, qr_bits<float>(), "float");
  DOUBLES(check(0xDCC153701C1C38EFu, qr_bits<double>(), "double");)
}

}  // namespace

void test_math() {
  RUN_TEST(elementary_functions_have_the_same_bits);
  RUN_TEST(rotations_have_the_same_bits);
  RUN_TEST(qr_has_the_same_bits);
}
