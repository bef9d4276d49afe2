// Terms of the camera that move the distorted point d (normalised, before focal length): d' = d + sum of c phi(d, row).
#pragma once

#include "sensors/effect_terms.h"

namespace SEGCAL_NS {

/// The terms in force for one image point; null: none.
template <class S>
struct ImageTerms {
  const EffectTerms<S>* effects = nullptr;
  S row = S(0);  ///< -1 at the top, 1 at the bottom of the image
};

template <class S>
S power(S x, int n) {
  S out = S(1);
  for (int i = 0; i < n; ++i) out *= x;
  return out;
}

/// phi of an image term and, optional, its derivative by d.
template <class S>
Vec2<S> image_phi(const Term& t, const Vec2<S>& d, S row, Mat<S, 2, 2>* J = nullptr) {
  const S x = d.x(), y = d.y(), q = x * x + y * y;
  Vec2<S> phi = Vec2<S>::Zero();
  if (J) J->setZero();
  if (t.kind == TermKind::radial) {
    phi = q * d;
    if (J) *J << q + S(2) * x * x, S(2) * x * y, S(2) * x * y, q + S(2) * y * y;
  } else if (t.kind == TermKind::tangential_1) {
    phi = Vec2<S>(S(2) * x * y, q + S(2) * y * y);
    if (J) *J << S(2) * y, S(2) * x, S(2) * x, S(6) * y;
  } else if (t.kind == TermKind::tangential_2) {
    phi = Vec2<S>(q + S(2) * x * x, S(2) * x * y);
    if (J) *J << S(6) * x, S(2) * y, S(2) * y, S(2) * x;
  } else if (t.of_image()) {
    const int axis = t.kind == TermKind::image_u ? 0 : 1;
    const S r = power(row, t.c);
    phi(axis) = power(x, t.a) * power(y, t.b) * r;
    if (J && t.a > 0) (*J)(axis, 0) = S(t.a) * power(x, t.a - 1) * power(y, t.b) * r;
    if (J && t.b > 0) (*J)(axis, 1) = S(t.b) * power(x, t.a) * power(y, t.b - 1) * r;
  }
  return phi;
}

/// Moves *d; `J`: derivative of the moved by the unmoved point.
template <class S>
void move_image_point(const ImageTerms<S>& terms, Vec2<S>* d, Mat<S, 2, 2>* J) {
  const Vec2<S> at = *d;
  J->setIdentity();
  for (int i = 0; i < terms.effects->count(); ++i) {
    if (!terms.effects->term[i].of_image()) continue;
    Mat<S, 2, 2> J_phi;
    *d += terms.effects->value[i] * image_phi(terms.effects->term[i], at, terms.row, &J_phi);
    *J += terms.effects->value[i] * J_phi;
  }
}

}  // namespace SEGCAL_NS
