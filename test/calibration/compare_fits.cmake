# The same fits by a build that keeps eliminations and one that makes them anew: equal bits, and fewer slices.
# Expects: KEEPS and ANEW (programs).
foreach(build KEEPS ANEW)
  execute_process(COMMAND ${${build}} OUTPUT_VARIABLE bits_${build} ERROR_VARIABLE slices_${build} COMMAND_ERROR_IS_FATAL ANY)
  string(STRIP "${slices_${build}}" slices_${build})
endforeach()
if(NOT bits_KEEPS STREQUAL bits_ANEW)
  message(FATAL_ERROR "a fit that keeps eliminations has other bits than one that makes them anew:\n  ${KEEPS}\n  ${ANEW}")
endif()
message("slices: ${slices_KEEPS} where eliminations are kept, ${slices_ANEW} where they are made anew")
# An iteration linearises, goes back and asks for the cost: four integrations of each link and two eliminations, of
# which one each is left. Landmarks' refinement stays.
math(EXPR most "${slices_ANEW} * 3 / 4")
if(slices_KEEPS GREATER most)
  message(FATAL_ERROR "hardly anything was kept")
endif()
