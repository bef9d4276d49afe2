# Builds for a target inside another build, and what CTest does with them. For the firmware workflow, and for the one target
# of the test workflow.
include(ExternalProject)
set(firmware_folder ${CMAKE_CURRENT_LIST_DIR})
set(measured_files "")

# segcal_instruction_counter(FILE): compiles the QEMU plugin. The compiler is the host's.
function(segcal_instruction_counter file)
  set(source ${PROJECT_SOURCE_DIR}/test/budget/instruction_counter.c)
  add_custom_command(OUTPUT ${file} COMMAND ${CMAKE_C_COMPILER} -O2 -std=gnu99 -Wall -Wextra -shared -fPIC ${source} -o ${file}
                     DEPENDS ${source} ${PROJECT_SOURCE_DIR}/test/budget/qemu_plugin.h)
  add_custom_target(instruction_counter ALL DEPENDS ${file})
  set(instruction_counter ${file} PARENT_SCOPE)
endfunction()

# segcal_measured_build(TARGET PROFILE OPTIMISATION): a build in BINARY_DIR/TARGET-PROFILE-OPTIMISATION, with these tests:
#   on_NAME          the Unity tests on the target
#   symbols_NAME     what the library's objects refer to
#   session_NAME     the recorded session; sizes, stack by call graph, instructions: NAME.json
function(segcal_measured_build target profile optimisation)
  set(name ${target}-${profile}${optimisation})
  set(build ${PROJECT_BINARY_DIR}/${name})
  set(options -DSEGCAL_PROFILE=1)
  if(profile STREQUAL "mobile")
    set(options -DSEGCAL_PROFILE=2)
  elseif(profile STREQUAL "mcu_double")
    list(APPEND options -DCMAKE_C_FLAGS=-DSEGCAL_REAL=double -DCMAKE_CXX_FLAGS=-DSEGCAL_REAL=double)
  endif()
  set(tools "")
  if(target STREQUAL "aarch64")
    set(tools aarch64-linux-gnu-)
  elseif(target MATCHES "^cortex")
    set(tools arm-none-eabi-)
  endif()
  if(tools)
    list(APPEND options -DCMAKE_TOOLCHAIN_FILE=${PROJECT_SOURCE_DIR}/cmake/toolchains/${target}.cmake)
  endif()
  # Compiler caches do not keep call graphs. One job each: several of these builds run side by side.
  ExternalProject_Add(${name} SOURCE_DIR ${PROJECT_SOURCE_DIR} BINARY_DIR ${build} BUILD_ALWAYS ON INSTALL_COMMAND ""
    BUILD_COMMAND ${CMAKE_COMMAND} --build <BINARY_DIR> -j 1
    CMAKE_ARGS -GNinja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_C_FLAGS_RELEASE=-O2 -DNDEBUG" "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG"
               -DCMAKE_CXX_COMPILER_LAUNCHER= -DCMAKE_C_COMPILER_LAUNCHER=
               -DSEGCAL_BUILD_HOST_TOOLS=OFF -DSEGCAL_BUILD_TESTS=OFF -DSEGCAL_BUILD_IMAGES=ON -DSEGCAL_OPTIMISATION=${optimisation}
               ${options})

  add_test(NAME on_${name} COMMAND ${firmware_folder}/run_image.sh ${target} ${build}/target_tests.elf)
  set_tests_properties(on_${name} PROPERTIES ENVIRONMENT SEGCAL_STORAGE=${build}/storage.bin)
  add_test(NAME symbols_${name} COMMAND ${PROJECT_SOURCE_DIR}/test/gates/symbol_gate.sh ${build}/lib/libsegcal.a)
  set_tests_properties(symbols_${name} PROPERTIES ENVIRONMENT NM=${tools}nm)

  set(measured ${PROJECT_BINARY_DIR}/measured/${name}.json)
  set(counter "")
  if(NOT profile STREQUAL "mcu_double")
    set(counter --counter ${instruction_counter})
  endif()
  add_test(NAME session_${name}
    COMMAND ${PROJECT_SOURCE_DIR}/test/budget/measure.py --target ${target} --profile ${profile} --optimisation=${optimisation}
            --build ${build} --tools=${tools} ${counter} --out ${measured})
  set_tests_properties(session_${name} PROPERTIES FIXTURES_SETUP measured TIMEOUT 600)
  set_tests_properties(on_${name} symbols_${name} session_${name} PROPERTIES LABELS firmware)
  set(measured_files ${measured_files} ${measured} PARENT_SCOPE)
endfunction()

# segcal_budget_test(NAME OUT): all measured builds against fixtures/budget; OUT/budget.json and budget.md.
function(segcal_budget_test name out)
  set(strict "")
  if(SEGCAL_OPEN_LIMITS)
    set(strict --open-limits)
  endif()
  add_test(NAME ${name} COMMAND ${PROJECT_SOURCE_DIR}/test/budget/budget.py --fixtures ${PROJECT_SOURCE_DIR}/fixtures/budget
                                --out ${out} ${strict} ${measured_files})
  set_tests_properties(${name} PROPERTIES FIXTURES_REQUIRED measured LABELS firmware)
endfunction()

# segcal_image_gates(): the gates of linked images, each seen red.
function(segcal_image_gates)
  add_test(NAME call_graph_refuses COMMAND ${PROJECT_SOURCE_DIR}/test/gates/test_call_graph.sh
                                           ${PROJECT_BINARY_DIR}/gate_objects arm-none-eabi-)
  add_test(NAME link_refuses COMMAND ${PROJECT_SOURCE_DIR}/test/gates/test_link_gate.sh ${PROJECT_BINARY_DIR}/gate_objects)
  add_test(NAME budget_refuses COMMAND ${PROJECT_SOURCE_DIR}/test/budget/test_budget.py)
  set_tests_properties(call_graph_refuses link_refuses budget_refuses PROPERTIES LABELS "firmware;gate")
endfunction()
