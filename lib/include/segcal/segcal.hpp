// segcal for C++17 (namespace segcal_cpp, since segcal is the tag of segcal_t): the C API with its own memory, no heap,
// no exceptions. A thin cover: names, units and rules are those of segcal.h.
//
//   static segcal_cpp::Device device(config);          // too large for a stack
//   if (device.error()) puts(segcal_code_words(device.error()));
//   device.push(sample);
//   device.push_tracks(t_ns, points, n);
//   device.background(8);
//   segcal_result_t result;
//   if (device.get(&result) == SEGCAL_OK) ...
#ifndef SEGCAL_HPP
#define SEGCAL_HPP

#include "segcal/health.h"
#include "segcal/lookup.h"
#include "segcal/segcal.h"

namespace segcal_cpp {

class Device {
 public:
  explicit Device(const segcal_config_t& config) {
    error_ = segcal_create(&handle_, &config, storage_, sizeof storage_);
  }
  // No copies and no moves: handle_ points at storage_ of this object. (The bytes of a device may move: blocks.h.)
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// SEGCAL_OK, or why there is no device: then all calls answer SEGCAL_ERROR_STATE.
  int error() const { return error_; }
  segcal_t* handle() { return handle_; }
  const segcal_t* handle() const { return handle_; }

  int push(const segcal_imu_t& sample) { return segcal_push_imu(handle_, &sample); }
  int push_tracks(int64_t t_ns, const segcal_point_t* points, int32_t n) {
    return segcal_push_tracks(handle_, t_ns, points, n);
  }
  int push_keyframe(const segcal_state_t& state, const segcal_point_t* points, int32_t n) {
    return segcal_push_keyframe(handle_, &state, points, n);
  }
  int background(int32_t slices) { return segcal_background(handle_, slices); }
  int work_when_due(bool on) { return segcal_work_when_due(handle_, on ? 1 : 0); }
  int request_calibration() { return segcal_request_calibration(handle_); }
  int flush_slices(int32_t slices) { return segcal_flush_slices(handle_, slices); }
  int flush() { return segcal_flush(handle_); }
  int new_session() { return segcal_new_session(handle_); }
  int calibrate() { return segcal_calibrate(handle_); }

  int get(segcal_state_t* out) const { return segcal_get_state(handle_, out); }
  int get(segcal_result_t* out) const { return segcal_get_result(handle_, out); }
  int get(segcal_counters_t* out) const { return segcal_get_counters(handle_, out); }
  int get(segcal_progress_t* out) const { return segcal_progress(handle_, out); }
  int get(segcal_imu_calibration_t* out) const { return segcal_get_imu_calibration(handle_, out); }
  int get(int32_t camera, segcal_camera_t* out) const { return segcal_get_camera(handle_, camera, out); }
  int health() const { return segcal_get_health(handle_); }
  uint64_t result_hash() const { return segcal_result_hash(handle_); }

 private:
  alignas(SEGCAL_STORAGE_ALIGNMENT) unsigned char storage_[SEGCAL_STORAGE_BYTES];
  segcal_t* handle_ = nullptr;
  int error_;
};

}  // namespace segcal_cpp

#endif
