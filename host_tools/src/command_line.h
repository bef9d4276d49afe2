// The command line of the program: arguments in, exit code out. The work is in one file per subcommand (commands.h).
#pragma once

namespace host {

int run_command_line(int argc, char** argv);

}  // namespace host
