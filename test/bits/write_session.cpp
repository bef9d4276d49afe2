// Writes a simulated session as a device log of profile mcu: what the variants of session_hash are fed. The device
// begins a calibration of its own after four segments, and there is enough left for it to take effect and to be used.
#include <cstdio>

#include "device_log/write_log.h"
#include "file_output.h"
#include "simulate/simulate.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  host::SimulationOptions simulation;
  simulation.scenario = "rich";
  simulation.seconds = 48;
  simulation.seed = 5;
  const host::SimulationResult session = host::simulate(simulation);
  host::CoreOptions options;
  options.calibration = session.nominal;
  options.noise = session.recording.imu.noise;
  options.segments = 4;
  options.trigger_fraction = 0.5;
  const std::vector<std::uint8_t> log = host::device_log_of({session.recording}, options, "mcu");
  host::write_file(argv[1], std::string_view(reinterpret_cast<const char*>(log.data()), log.size()));
  return 0;
}
