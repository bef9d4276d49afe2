// Calibrations, noise, models and devices in YAML: the first byte says which file the rest is.
#include "calibration_file.h"
#include "fuzz_files.h"
#include "imu_noise_file.h"
#include "replay/model_file.h"
#include "replay/provenance.h"
#include "simulate/effect_model.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace host;
  static const FuzzFolder folder;
  static const bool once = [] {
    folder.put("whole/camchain-imucam.yaml",
               "cam0:\n  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n  camera_model: pinhole\n"
               "  intrinsics: [400, 400, 320, 240]\n  distortion_model: fov\n  distortion_coeffs: [0.9]\n  resolution: "
               "[640, 480]\n");
    return true;
  }();
  if (size < 1 || !once) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 7) {
    case 0: {
      const auto file = folder.put("chain.yaml", text);
      reads([&] { read_calibration(file); });
      break;
    }
    case 1:
      folder.put("whole/imu.yaml", text);
      reads([&] { read_calibration(folder.path() / "whole/camchain-imucam.yaml"); });
      break;
    case 2: {
      const auto file = folder.put("noise.yaml", text);
      reads([&] { read_noise_file(file); });
      break;
    }
    case 3: {
      const auto file = folder.put("model.yaml", text);
      reads([&] {
        CoreOptions options;
        read_model(file).apply(&options);
      });
      break;
    }
    case 4:
      folder.put("device.yaml", text);
      reads([&] { device_of(folder.path()); });
      break;
    case 5:
      folder.put("euroc/mav0/cam0/sensor.yaml", text);
      reads([&] { find_calibration(folder.path() / "euroc", "", 1); });
      break;
    default: {
      const auto file = folder.put("effects.yaml", text);
      reads([&] { sim::effects_of_model(file); });
    }
  }
  return 0;
}
