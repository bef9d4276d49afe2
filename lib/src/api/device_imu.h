// Device: IMU samples on their way to the filter. Faults are counted, gaps begin anew.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

/// No chip works beyond, degC.
template <class S>
constexpr S kMostCelsius = S(200);

template <class S>
Taken Device<S>::push_imu(std::int64_t t_ns, const InertialReading<S>& reading, S celsius) {
  ++d_.faults.imu_samples;
  if (!is_finite(reading.gyro.sum()) || !is_finite(reading.accel.sum())) {
    ++d_.faults.imu_not_finite;
    return Taken::not_finite;
  }
  const bool began = has_imu_;
  switch (imu_clock_.take(t_ns)) {
    case StampVerdict::good: break;
    case StampVerdict::back: ++d_.faults.imu_stamps_back; return Taken::stamp_refused;
    case StampVerdict::far: ++d_.faults.imu_stamps_far; return Taken::stamp_refused;
    case StampVerdict::anew:
      if (began && t_ns > last_imu_) break;  // a long gap
      ++d_.faults.clock_restarts;
      end_segment(false);
      restart_filter();
      imu_clock_.take(t_ns);
      break;
  }
  if (!began && d_.faults.imu_samples - d_.faults.imu_not_finite - d_.faults.imu_stamps_far == 1) start_clock(t_ns);
  if (d_.options.has_temperature && absolute(celsius) <= kMostCelsius<S>) imu_.set_warmth(celsius - S(25));
  if (!in_range(reading.gyro, d_.options.gyro_range) || !in_range(reading.accel, d_.options.accel_range)) {
    ++d_.faults.imu_saturated;
    return Taken::skipped;  // what it measured is not known; its neighbours bridge it, or it is a gap
  }
  keep_unbroken(t_ns, reading);
  last_imu_ = t_ns;
  has_imu_ = true;
  used_ <<= 1;
  InertialReading<S> mean = reading;
  if (decimation_.take(&t_ns, &mean)) imu_.push(t_ns, mean);
  return frame_ready() ? process_frame() : Taken::ok;
}

/// The open segment ends at a gap and at a spike, which is known only now, by what follows it. A spike is taken out of
/// the stream, and its neighbours bridge it: the filter goes on. If a frame has used it already, the segment is
/// dropped, and a new stretch begins, as at a gap; so too where the bridge would be long: samples at full scale were
/// left out beside.
template <class S>
[[gnu::cold]] void Device<S>::keep_unbroken(std::int64_t t_ns, const InertialReading<S>& reading) {
  const bool gap = has_imu_ && S(t_ns - last_imu_) * S(1e-9) > S(3) / d_.options.imu_rate_hz;
  if (gap || !has_imu_) spikes_.clear();
  const int wrong = spikes_.after(reading);
  if (!gap && wrong == 0) return;
  const bool bridged = wrong > 0 && (used_ & ((1u << wrong) - 1)) == 0 && bridge_is_short(t_ns, wrong);
  if (wrong > 0 && !bridged) begin_segment(false);  // nothing of the open one is to be trusted
  end_segment(false);
  imu_spikes_ += static_cast<std::uint32_t>(wrong);
  if (bridged) {
    imu_.take_back(d_.options.imu_group > 1 ? decimation_.drop_newest(wrong) : wrong);
    used_ >>= wrong;
    hole_ns_ = t_ns + static_cast<std::int64_t>(S(d_.options.imu_group - 1) / d_.options.imu_rate_hz * S(1e9));
    has_hole_ = true;
    return;
  }
  if (gap) ++d_.faults.imu_gaps;
  break_stream();
  imu_clock_.take(t_ns);
}

/// From the newest sample that stays when `wrong` go, to `t_ns`: three periods for two, and what stamps scatter by. Of
/// groups of m, from the middle of the last one: half of it, one that goes, and one or two periods.
template <class S>
bool Device<S>::bridge_is_short(std::int64_t t_ns, int wrong) const {
  const std::int32_t m = d_.options.imu_group;
  std::int64_t last_ns;
  if (m > 1) {
    if (!decimation_.stays(wrong, &last_ns)) return false;
  } else if (imu_.size() > wrong) {
    last_ns = imu_.time(imu_.size() - 1 - wrong);
  } else {
    return false;
  }
  return S(t_ns - last_ns) * S(1e-9) <= (m > 1 ? S(1.6) * S(m) + S(2.5) : S(3.5)) / d_.options.imu_rate_hz;
}

/// Signal::time counts from the first sample.
template <class S>
void Device<S>::start_clock(std::int64_t t_ns) {
  d_.options.prior.mean.effects.time_zero_ns = theta_.effects.time_zero_ns = t_ns;
  vio_.set_time_zero(t_ns);
}

/// The filter starts again.
template <class S>
void Device<S>::break_stream() {
  const std::int64_t last_frame = last_frame_;
  const bool has_frame = has_frame_;
  restart_filter();
  last_frame_ = last_frame;
  has_frame_ = has_frame;
}

}  // namespace SEGCAL_NS
