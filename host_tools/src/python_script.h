// The Python scripts of the source tree: pages with plots are drawn there.
#pragma once

#include <string>
#include <vector>

namespace host {

/// Runs host_tools/SCRIPT and waits. 0, or 2 when the script has told on stderr what is wrong, or `negative`, its exit
/// code for a negative answer if it has one. Throws InputError where it could not tell: no Python, no script, a crash.
/// Python is $SEGCAL_PYTHON, else the virtual environment that host_tools/setup.sh made, else python3.
int run_python_script(const std::string& script, const std::vector<std::string>& arguments, int negative = 0);

}  // namespace host
