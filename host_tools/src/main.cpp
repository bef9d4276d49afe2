// The `segcal` program. All of it is in the library, so that this
// file and what tests link need no header of the command line's.
#include "command_line.h"

int main(int argc, char** argv) { return host::run_command_line(argc, argv); }
