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
  const bool began = imu_.any;
  switch (imu_.clock.take(t_ns)) {
    case StampVerdict::good: break;
    case StampVerdict::back: ++d_.faults.imu_stamps_back; return Taken::stamp_refused;
    case StampVerdict::far: ++d_.faults.imu_stamps_far; return Taken::stamp_refused;
    case StampVerdict::anew:
      if (began && t_ns > imu_.last_ns) break;  // a long gap
      ++d_.faults.clock_restarts;
      end_segment(false);
      restart_filter();
      imu_.clock.take(t_ns);
      break;
  }
  if (!began && d_.faults.imu_samples - d_.faults.imu_not_finite - d_.faults.imu_stamps_far == 1) start_clock(t_ns);
  if (d_.options.has_temperature && absolute(celsius) <= kMostCelsius<S>) imu_.history.set_warmth(celsius - S(25));
  if (!in_range(reading.gyro, d_.options.gyro_range) || !in_range(reading.accel, d_.options.accel_range)) {
    ++d_.faults.imu_saturated;
    return Taken::skipped;  // what it measured is not known; its neighbours bridge it, or it is a gap
  }
  keep_unbroken(t_ns, reading);
  imu_.last_ns = t_ns;
  imu_.any = true;
  imu_.used <<= 1;
  InertialReading<S> mean = reading;
  if (imu_.decimation.take(&t_ns, &mean)) imu_.history.push(t_ns, mean);
  return frame_ready() ? process_frame() : Taken::ok;
}

/// The open segment ends at a gap and at a spike, which is known only now, by what follows
/// it. A spike is taken out of the stream, and its neighbours bridge it: the filter goes on.
/// If a frame has used it already, the segment is dropped, and a new stretch begins, as at a
/// gap; so too where the bridge would be long: samples at full scale were left out beside.
template <class S>
[[gnu::cold]] void Device<S>::keep_unbroken(std::int64_t t_ns, const InertialReading<S>& reading) {
  const bool gap = imu_.any && S(t_ns - imu_.last_ns) * S(1e-9) > S(3) / d_.options.imu_rate_hz;
  if (gap || !imu_.any) imu_.spikes.clear();
  const int wrong = imu_.spikes.after(reading);
  if (!gap && wrong == 0) return;
  const bool bridged = wrong > 0 && (imu_.used & ((1u << wrong) - 1)) == 0 && bridge_is_short(t_ns, wrong);
  if (wrong > 0 && !bridged) begin_segment(false);  // nothing of the open one is to be trusted
  end_segment(false);
  imu_.spikes_found += static_cast<std::uint32_t>(wrong);
  if (bridged) {
    imu_.history.take_back(d_.options.imu_group > 1 ? imu_.decimation.drop_newest(wrong) : wrong);
    imu_.used >>= wrong;
    imu_.hole_ns = t_ns + static_cast<std::int64_t>(S(d_.options.imu_group - 1) / d_.options.imu_rate_hz * S(1e9));
    imu_.has_hole = true;
    return;
  }
  if (gap) ++d_.faults.imu_gaps;
  break_stream();
  imu_.clock.take(t_ns);
}

/// From the newest sample that stays when `wrong` go, to `t_ns`: three periods for two, and what stamps scatter by. Of
/// groups of m, from the middle of the last one: half of it, one that goes, and one or two periods.
template <class S>
bool Device<S>::bridge_is_short(std::int64_t t_ns, int wrong) const {
  const std::int32_t m = d_.options.imu_group;
  std::int64_t last_ns;
  if (m > 1) {
    if (!imu_.decimation.stays(wrong, &last_ns)) return false;
  } else if (imu_.history.size() > wrong) {
    last_ns = imu_.history.time(imu_.history.size() - 1 - wrong);
  } else {
    return false;
  }
  return S(t_ns - last_ns) * S(1e-9) <= (m > 1 ? S(1.6) * S(m) + S(2.5) : S(3.5)) / d_.options.imu_rate_hz;
}

/// Signal::time counts from the first sample.
template <class S>
void Device<S>::start_clock(std::int64_t t_ns) {
  d_.options.prior.mean.effects.time_zero_ns = theta_.effects.time_zero_ns = t_ns;
  odometry_.filter.set_time_zero(t_ns);
}

/// The filter starts again.
template <class S>
void Device<S>::break_stream() {
  const std::int64_t last_frame = frames_.last_ns;
  const bool has_frame = frames_.any;
  restart_filter();
  frames_.last_ns = last_frame;
  frames_.any = has_frame;
}

}  // namespace SEGCAL_NS
