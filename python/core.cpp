// segcal._core: the C API with numpy arrays in and out. What is convenient stands in segcal/__init__.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include <climits>
#include <memory>
#include <string>

#include "segcal/segcal.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Stamps = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Vectors = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Ids = nb::ndarray<const std::uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Cameras = nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

void require(bool condition, const char* what) {
  if (!condition) throw nb::value_error(what);
}

/// A fixed array of a C struct as a list; setting takes exactly as many numbers.
template <class Struct, class Owner, int N>
void list_property(nb::class_<Struct>& type, const char* name, double (Owner::*member)[N]) {
  type.def_prop_rw(
      name, [member](const Struct& s) { return std::vector<double>(s.*member, s.*member + N); },
      [member, name](Struct& s, const std::vector<double>& values) {
        if (values.size() > static_cast<std::size_t>(N))
          throw nb::value_error((std::string(name) + ": at most " + std::to_string(N) + " numbers").c_str());
        for (int i = 0; i < N; ++i)
          (s.*member)[i] = static_cast<std::size_t>(i) < values.size() ? values[static_cast<std::size_t>(i)] : 0;
      });
}

nb::object owned(std::vector<double> values, std::vector<std::size_t> shape) {
  auto* heap = new std::vector<double>(std::move(values));
  nb::capsule owner(heap, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, double>(heap->data(), shape.size(), shape.data(), owner));
}

class Device {
 public:
  explicit Device(const segcal_config_t& config)
      : memory_(new std::byte[segcal_storage_bytes() + SEGCAL_STORAGE_ALIGNMENT]) {
    void* start = memory_.get();
    std::size_t room = segcal_storage_bytes() + SEGCAL_STORAGE_ALIGNMENT;
    std::align(SEGCAL_STORAGE_ALIGNMENT, segcal_storage_bytes(), start, room);
    const int code = segcal_create(&device_, &config, start, room);
    if (code != SEGCAL_OK)
      throw nb::value_error(("the core refuses this configuration, error " + std::to_string(code)).c_str());
    segcal_work_when_due(device_, 1);  // no deadlines here: background() is a choice of when
  }

  /// Number of samples that were refused (segcal.h says why, counters() how many of which kind).
  int push_imu(const Stamps& t_ns, const Vectors& gyro, const Vectors& accel, const Numbers& temperature) {
    const std::size_t n = t_ns.shape(0);
    require(gyro.shape(0) == n && accel.shape(0) == n && gyro.shape(1) == 3 && accel.shape(1) == 3,
            "expected t_ns (n), gyro and accel (n, 3)");
    require(temperature.shape(0) == n || temperature.shape(0) == 0, "expected n temperatures, or none");
    int refused = 0;
    for (std::size_t i = 0; i < n; ++i) {
      segcal_imu_t s{};
      s.t_ns = t_ns(i);
      for (std::size_t k = 0; k < 3; ++k) {
        s.gyro[k] = static_cast<float>(gyro(i, k));
        s.accel[k] = static_cast<float>(accel(i, k));
      }
      s.temperature = temperature.shape(0) > 0 ? static_cast<float>(temperature(i)) : 0;
      refused += segcal_push_imu(device_, &s) < 0 ? 1 : 0;
    }
    return refused;
  }

  int push_tracks(std::int64_t t_ns, const Ids& id, const Vectors& uv, const Cameras& camera) {
    const std::size_t n = id.shape(0);
    require(uv.shape(0) == n && uv.shape(1) == 2, "expected track ids (n) and uv (n, 2)");
    require(camera.shape(0) == n || camera.shape(0) == 0, "expected n cameras, or none");
    std::vector<segcal_point_t> points(n);
    for (std::size_t i = 0; i < n; ++i) {
      points[i] = {id(i), camera.shape(0) > 0 ? camera(i) : 0, static_cast<float>(uv(i, 0)),
                   static_cast<float>(uv(i, 1))};
    }
    return segcal_push_tracks(device_, t_ns, points.data(), static_cast<std::int32_t>(n));
  }

  int background(int slices) { return segcal_background(device_, slices); }
  int flush() { return segcal_flush(device_); }
  int new_session() { return segcal_new_session(device_); }
  int calibrate() { return segcal_calibrate(device_); }
  std::uint64_t result_hash() const { return segcal_result_hash(device_); }

  nb::object result() const {
    auto r = std::make_unique<segcal_result_t>();
    if (segcal_get_result(device_, r.get()) != SEGCAL_OK) return nb::none();
    static const char* const kStatus[] = {"insufficient", "calibrated", "failed"};
    static const char* const kVerdict[] = {"fixed", "weak", "observed"};
    nb::list parameters;
    for (int i = 0; i < r->n_parameters; ++i) {
      const segcal_parameter_t& p = r->parameter[i];
      nb::dict row;
      row["name"] = p.name;
      row["value"] = p.value;
      row["sigma"] = p.sigma;
      row["unit"] = p.unit;
      row["initial"] = p.initial;
      row["prior_sigma"] = p.prior_sigma;
      row["verdict"] = kVerdict[p.verdict];
      parameters.append(row);
    }
    nb::dict out;
    out["status"] = kStatus[r->status];
    out["parameters"] = parameters;
    out["segments"] = r->segments;
    out["chi2"] = r->chi2;
    out["dof"] = r->dof;
    out["noise_scale"] = r->noise_scale;
    out["reprojection_rms_px"] = r->reprojection_rms_px;
    const auto n = static_cast<std::size_t>(r->n_parameters);
    std::vector<double> mean(n), covariance(n * n);
    segcal_get_posterior(device_, mean.data(), covariance.data(), static_cast<std::int32_t>(n * n));
    out["mean"] = owned(std::move(mean), {n});
    out["covariance"] = owned(std::move(covariance), {n, n});
    return out;
  }

  /// Seven numbers, position p_GI and q_GI (w x y z), or none before the filter runs.
  nb::object pose() const {
    segcal_state_t s;
    if (segcal_get_state(device_, &s) != SEGCAL_OK) return nb::none();
    return owned({s.p_GI[0], s.p_GI[1], s.p_GI[2], s.q_GI[0], s.q_GI[1], s.q_GI[2], s.q_GI[3]}, {7});
  }

 private:
  std::unique_ptr<std::byte[]> memory_;
  segcal_t* device_ = nullptr;
};

void bind_config(nb::module_& m) {
  nb::class_<segcal_camera_t> camera(m, "Camera");
  camera.def("__init__", [](segcal_camera_t* c) { new (c) segcal_camera_t{}; })
      .def_rw("model", &segcal_camera_t::model)
      .def_rw("height", &segcal_camera_t::height);
  list_property(camera, "q_CI", &segcal_camera_t::q_CI);
  list_property(camera, "p_CI", &segcal_camera_t::p_CI);
  list_property(camera, "intrinsics", &segcal_camera_t::intrinsics);
  list_property(camera, "distortion", &segcal_camera_t::distortion);

  nb::class_<segcal_imu_calibration_t> imu(m, "ImuCalibration");
  imu.def("__init__", [](segcal_imu_calibration_t* c) { new (c) segcal_imu_calibration_t{}; });
  list_property(imu, "gyro_scale", &segcal_imu_calibration_t::gyro_scale);
  list_property(imu, "gyro_misalignment", &segcal_imu_calibration_t::gyro_misalignment);
  list_property(imu, "accel_scale", &segcal_imu_calibration_t::accel_scale);
  list_property(imu, "accel_misalignment", &segcal_imu_calibration_t::accel_misalignment);
  list_property(imu, "q_AI", &segcal_imu_calibration_t::q_AI);

  nb::class_<segcal_config_t> config(m, "Config");
  config.def("__init__", [](segcal_config_t* c) { new (c) segcal_config_t{}; })
      .def_rw("imu", &segcal_config_t::imu)
      .def_rw("imu_rate_hz", &segcal_config_t::imu_rate_hz)
      .def_rw("gyro_noise_density", &segcal_config_t::gyro_noise_density)
      .def_rw("gyro_random_walk", &segcal_config_t::gyro_random_walk)
      .def_rw("accel_noise_density", &segcal_config_t::accel_noise_density)
      .def_rw("accel_random_walk", &segcal_config_t::accel_random_walk)
      .def_rw("pixel_sigma", &segcal_config_t::pixel_sigma)
      .def_rw("segment_s", &segcal_config_t::segment_s)
      .def_rw("keep_segments", &segcal_config_t::keep_segments)
      .def_rw("metric", &segcal_config_t::metric)
      .def_rw("strategy", &segcal_config_t::strategy)
      .def_rw("seed", &segcal_config_t::seed)
      .def_rw("outdated_level", &segcal_config_t::outdated_level)
      .def_rw("trigger_fraction", &segcal_config_t::trigger_fraction)
      .def_rw("filter_share", &segcal_config_t::filter_share)
      .def_rw("estimate_effects", &segcal_config_t::estimate_effects)
      .def_rw("has_temperature", &segcal_config_t::has_temperature)
      .def("set_cameras", [](segcal_config_t& c, const std::vector<segcal_camera_t>& cameras) {
        require(!cameras.empty() && cameras.size() <= SEGCAL_MAX_CAMERAS, "expected one camera, or two");
        c.n_cameras = static_cast<std::int32_t>(cameras.size());
        std::copy(cameras.begin(), cameras.end(), c.camera);
      });
}

}  // namespace

NB_MODULE(_core, m) {
  m.attr("MAX_TRACKS") = SEGCAL_MAX_TRACKS;
  m.attr("STORAGE_BYTES") = segcal_storage_bytes();
  bind_config(m);
  nb::class_<Device>(m, "Device")
      .def(nb::init<const segcal_config_t&>(), "config"_a)
      .def("push_imu", &Device::push_imu, nb::call_guard<nb::gil_scoped_release>())
      .def("push_tracks", &Device::push_tracks, nb::call_guard<nb::gil_scoped_release>())
      .def("background", &Device::background, "slices"_a = INT_MAX, nb::call_guard<nb::gil_scoped_release>())
      .def("flush", &Device::flush, nb::call_guard<nb::gil_scoped_release>())
      .def("new_session", &Device::new_session, nb::call_guard<nb::gil_scoped_release>())
      .def("calibrate", &Device::calibrate, nb::call_guard<nb::gil_scoped_release>())
      .def("result", &Device::result)
      .def("pose", &Device::pose)
      .def("result_hash", &Device::result_hash);
}
