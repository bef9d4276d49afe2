// The start, part 1: inertial integrals from the first frame of the window to each other one.
#pragma once

#include "math/near.h"
#include "vio/standstill.h"

namespace SEGCAL_NS {

/// Where the next start puts the device: yaw and place are not observable, so they are continued.
template <class S>
struct Origin {
  Vec3<S> p_GI = Vec3<S>::Zero();
  Vec3<S> forward = Vec3<S>(S(1), S(0), S(0));  ///< x axis of I seen in G

  void remember(const State<S>& x) {
    if (!is_finite(x.p_GI.squaredNorm()) || !is_finite(x.R_GI.sum())) return;
    p_GI = x.p_GI;
    forward = x.R_GI.col(0);
  }

  /// Attitude in which the vector `down` of I points along gravity and the x axis keeps its heading.
  [[gnu::cold]] Mat3<S> attitude(const Vec3<S>& down, const Vec3<S>& g) const {
    const Vec3<S> z = g / -square_root(g.squaredNorm());
    const Vec3<S> up_I = down / -square_root(down.squaredNorm());
    Vec3<S> y_G = cross<S>(z, forward), y_I = cross<S>(up_I, Vec3<S>(S(1), S(0), S(0)));
    if (y_G.squaredNorm() < S(1e-4) || y_I.squaredNorm() < S(1e-4)) {
      // x points up or down: any heading will do.
      y_G = cross<S>(z, Vec3<S>(S(0), S(1), S(0)));
      if (y_G.squaredNorm() < S(1e-4)) y_G = cross<S>(z, Vec3<S>(S(1), S(0), S(0)));
      y_I = cross<S>(up_I, Vec3<S>(S(0), S(1), S(0)));
      if (y_I.squaredNorm() < S(1e-4)) y_I = cross<S>(up_I, Vec3<S>(S(0), S(0), S(1)));
    }
    y_G /= square_root(y_G.squaredNorm());
    y_I /= square_root(y_I.squaredNorm());
    return renormalised<S>(axes(y_G, z) * axes(y_I, up_I).transpose());
  }

 private:
  static Mat3<S> axes(const Vec3<S>& y, const Vec3<S>& z) {
    Mat3<S> out;
    out.col(0) = cross<S>(y, z);
    out.col(1) = y;
    out.col(2) = z;
    return out;
  }
};

/// Memory of the start.
template <class S>
struct StartScratch {
  Near<StartLink<S>> link;  ///< one for each pose, in the window's memory
  State<S> x0, best;        ///< state at the window's first frame, and the best one so far
  State<S> aligned;         ///< what the descent from the linear alignment found
  CameraCalibration<S> best_camera[kMaxCameras], aligned_camera[kMaxCameras];
  S pixel_scale;  ///< what the fit says about pixel_sigma, 1..4
  S waited;       ///< s since the first try
  S lack = S(2);  ///< how many times what a start may have the fit had, of misfit or of the motion's sigma
  bool still;
};

template <class S>
void copy_link(const ImuIntegral<S>& I, StartLink<S>* link) {
  link->t = I.dt;
  link->dR = link->dR_base = I.dR;
  link->dv = link->dv_base = I.dv;
  link->dp = link->dp_base = I.dp;
  link->R_bg = I.J_R.template leftCols<3>();
  link->v_bg = I.J_v.template middleCols<3>(kInputBg);
  link->v_ba = I.J_v.template middleCols<3>(kInputBa);
  link->p_bg = I.J_p.template middleCols<3>(kInputBg);
  link->p_ba = I.J_p.template middleCols<3>(kInputBa);
}

/// The integrals at x0's biases, which are so far from those
/// that they were made at: to first order (Forster et al. 2017).
template <class S>
void correct_links(int n, const Vec3<S>& d_ba, const Vec3<S>& d_bg, StartLink<S>* links) {
  for (int i = 0; i < n; ++i) {
    StartLink<S>& link = links[i];
    link.dR = link.dR_base * so3_exp<S>(Vec3<S>(link.R_bg * d_bg));
    link.dv = link.dv_base + link.v_bg * d_bg + link.v_ba * d_ba;
    link.dp = link.dp_base + link.p_bg * d_bg + link.p_ba * d_ba;
  }
}

/// The window's poses from x0 and the links; they are first estimates too.
template <class S>
void place_poses(Window<S>* w, const VioOptions<S>& options, const StartScratch<S>& s) {
  for (int i = 0; i < w->n_poses; ++i) {
    const StartLink<S>& link = s.link[i];
    WindowPose<S>& pose = w->pose[i];
    pose.R_GI = pose.R_first = renormalised<S>(s.x0.R_GI * link.dR);
    const Vec3<S> fall = options.g * (link.t * link.t / S(2));
    pose.p_GI = pose.p_first = s.x0.p_GI + s.x0.v_GI * link.t + fall + s.x0.R_GI * link.dp;
  }
}

/// Unit bearing of a track's point in I; false if it has none there.
template <class S>
bool bearing_in_imu(const Window<S>& w, const VioTrack<S>& track, int pose, Vec3<S>* f) {
  if (!track.in(w.pose[pose].slot)) return false;
  const CameraCalibration<S>& camera = w.theta.camera[track.camera];
  Vec3<S> h;
  if (!unproject(camera, track.uv[w.pose[pose].slot], &h)) return false;
  *f = camera.R_CI.transpose() * (h / square_root(h.squaredNorm()));
  return true;
}

}  // namespace SEGCAL_NS
