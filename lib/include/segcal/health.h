/* A sentence for each SEGCAL_HEALTH_* of segcal_get_health(): what is wrong and what to do. Inline, so that firmware
   that does not print it does not carry it. */
#ifndef SEGCAL_HEALTH_H
#define SEGCAL_HEALTH_H

#include "segcal/segcal.h"

static inline const char* segcal_health_words(int health) {
  switch (health) {
    case SEGCAL_HEALTH_RUNNING: return "the odometry runs";
    case SEGCAL_HEALTH_NO_IMU: return "no IMU sample has come";
    case SEGCAL_HEALTH_IMU_REFUSED:
      return "most IMU samples are refused: check that stamps are in ns and grow, and that values are finite";
    case SEGCAL_HEALTH_NO_FRAMES: return "no frame has come";
    case SEGCAL_HEALTH_CLOCKS_APART:
      return "most frames are stamped more than 2 s away from the IMU samples: give both the same clock";
    case SEGCAL_HEALTH_FRAMES_REFUSED: return "most frames are refused because their stamps do not grow";
    case SEGCAL_HEALTH_FEW_TRACKS: return "most frames have too few points seen before: check tracker, ids and light";
    case SEGCAL_HEALTH_STARTING: return "the odometry collects frames for its start";
    case SEGCAL_HEALTH_FRAMES_TOO_FAR:
      return "frames are more than 0.6 s apart, or too far apart for the IMU samples that this build keeps: more "
             "frames per second, fewer IMU samples per second, or a larger SEGCAL_IMU_HISTORY";
    case SEGCAL_HEALTH_NO_START:
      return "the odometry finds no motion that fits images and IMU: check the clocks' offset, R_CI, the axes and "
             "units of the IMU, and the focal length";
    case SEGCAL_HEALTH_LOST_OFTEN:
      return "the odometry is lost within seconds of each start: check the clocks' offset, R_CI and the lens";
    case SEGCAL_HEALTH_SATURATED:
      return "more than one IMU sample in a hundred is at full scale: choose a larger range, and check the units, "
             "rad/s and m/s^2, of samples, gyro_range and accel_range";
    case SEGCAL_HEALTH_FRAMES_CROWDED:
      return "most frames are dropped because their IMU samples come too late: shorter blocks of samples, a longer "
             "frame_interval_s, or a larger SEGCAL_WAITING_FRAMES";
    case SEGCAL_HEALTH_SPIKES:
      return "IMU samples, one or two every few seconds, stand alone, far from the ones before and after, and end a "
             "segment: look at the sensor's bus, and at what knocks against it";
    case SEGCAL_HEALTH_STARTS_LATE:
      return "the odometry does not start: the slices of a start in motion are done too late; do more slices after "
             "each sample, start at rest, or give it time (SEGCAL_START_DELAY_MS, SEGCAL_IMU_HISTORY)";
    case SEGCAL_HEALTH_IMU_RATE: return "IMU samples do not come at imu_rate_hz: state the sensor's rate";
    case SEGCAL_HEALTH_NO_SEGMENTS:
      return "no segment is of use: too few points are seen by several keyframes (keyframes too far apart, tracks too "
             "short), or images and IMU contradict each other";
    default: return "unknown";
  }
}

#endif
