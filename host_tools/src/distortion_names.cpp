// The three distortion models by name, as Kalibr and EuRoC write them.
#include "calibration_file.h"

namespace host {

bool reads_columns(const std::string& readout) {
  if (readout != "rows" && readout != "columns") throw InputError("readout: rows or columns, found '" + readout + "'");
  return readout == "columns";
}

DistortionModel distortion_from_name(const std::string& name) {
  if (name == "fov") return DistortionModel::fov;
  if (name == "radtan" || name == "radial-tangential") return DistortionModel::radtan;
  if (name == "equidistant" || name == "equi") return DistortionModel::equidistant;
  throw InputError("a distortion model 'fov', 'radtan' or 'equidistant', found '" + name + "'");
}

std::string distortion_name(DistortionModel model) {
  switch (model) {
    case DistortionModel::fov: return "fov";
    case DistortionModel::radtan: return "radtan";
    case DistortionModel::equidistant: return "equidistant";
  }
  return {};
}

std::vector<std::string> distortion_parameters(DistortionModel model) {
  switch (model) {
    case DistortionModel::fov: return {"w"};
    case DistortionModel::radtan: return {"k1", "k2", "p1", "p2"};
    case DistortionModel::equidistant: return {"k1", "k2", "k3", "k4"};
  }
  return {};
}

}  // namespace host
