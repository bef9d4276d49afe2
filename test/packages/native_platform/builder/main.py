# Builds with this computer's gcc and g++. PlatformIO's flags of C and C++ survive the look for the tools.
from SCons.Script import Default, DefaultEnvironment

env = DefaultEnvironment()
flags = {name: list(env.get(name, [])) for name in ("CFLAGS", "CXXFLAGS")}
for tool in "gcc", "g++":
    env.Tool(tool)
env.Append(**flags)
Default([env.BuildProgram()])
