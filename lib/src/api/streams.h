// What a device knows of each of its streams: samples, frames, the odometry's states, and the grid of keyframes.
#pragma once

#include "api/counts.h"
#include "api/stamp_guard.h"
#include "api/waiting_frames.h"
#include "math/hash.h"
#include "segments/boundary.h"
#include "sensors/decimation.h"
#include "sensors/spike_watch.h"
#include "vio/vio.h"

namespace SEGCAL_NS {

template <class S>
struct ImuStream {
  ImuHistory<S> history;
  StampGuard clock;
  SpikeWatch<S> spikes;
  Decimation<S> decimation;
  std::int64_t last_ns;        ///< of the newest sample, where there is any
  std::int64_t hole_ns;        ///< where a spike was taken out: the end of the first group of samples after it
  std::uint32_t used;          ///< bit k: a frame came after the k-th newest reading and before the next one, and may
                               ///< have used it
  std::uint32_t spikes_found;  ///< since create()
  bool any;
  bool has_hole;  ///< no image after hole_ns has been processed yet

  void create(const MeasurementModel<S>& model, S rate_hz, std::int32_t group) {
    decimation.begin(group);
    spikes.begin(model.imu, rate_hz);
    spikes_found = 0;
  }
  /// Nothing came before.
  void clear() {
    history.clear();
    clock.reset();
    decimation.clear();
    used = 0;
    any = has_hole = false;
  }
};

template <class S>
struct FrameStream {
  WaitingFrames<S> waiting;
  StreamCounts at_last_use;      ///< what had come when the odometry used a frame with enough points the last time
  std::int64_t last_ns;          ///< of the newest frame, where there is any
  std::int64_t last_offered_ns;  ///< the odometry was offered one, where it was any
  std::int64_t period_ns;        ///< the camera's; 0: not known
  std::uint32_t crowded_out;     ///< found no place to wait, since create()
  bool any, any_offered;

  void create() {
    period_ns = 0;
    crowded_out = 0;
    at_last_use = StreamCounts();
  }
  void clear() {
    waiting.clear();
    any = any_offered = false;
  }
};

/// Where states come from: the filter, or the user.
template <class S>
struct Odometry {
  Vio<S> filter;
  State<S> state;         ///< the newest; its position counts from origin
  double origin[3];       ///< m, in the odometry's frame: float holds what is near
  Hash trajectory;        ///< of all states so far
  std::int64_t state_ns;  ///< state's time
  std::uint32_t frame;    ///< number of the frame G, which is another one after each start of a filter
  bool has_state;
  bool own;  ///< the user's

  void create() {
    frame = 0;
    trajectory = Hash{};
    own = false;
  }
  void clear() {
    for (double& o : origin) o = 0;
    has_state = false;
  }
  bool runs() const { return own || filter.initialised(); }
};

/// When the next keyframe is due, and what decides when an open segment ends.
template <class S>
struct KeyframeGrid {
  Liveliness<S> liveliness;
  std::int64_t next_ns;  ///< where there was any
  std::int32_t thinned;  ///< how often the open segment was
  bool any;              ///< a keyframe has come in this stretch

  void create() {
    thinned = 0;
    liveliness.reset();
  }
  void clear() { any = false; }
};

}  // namespace SEGCAL_NS
