# Stand-in for ESP-IDF's project.cmake: project() builds `main` and the components that its manifest names by override_path, as ESP-IDF's
# documentation has it, with the host's compiler. A component sees the headers of those that it requires, and no others; Eigen's only with
# `espressif/eigen` among the dependencies of its manifest. Needs STUB_EIGEN, Eigen's folder, and STUB_OPTIMISATION.
set(idf_stub ${CMAKE_CURRENT_LIST_DIR}/../..)

# stub_requirements(OUT FOLDER): what the component requires. It is asked in script mode, where there are no targets yet.
function(stub_requirements out folder)
  execute_process(COMMAND ${CMAKE_COMMAND} -DFOLDER=${folder} -P ${idf_stub}/tools/cmake/requirements.cmake
                  ERROR_VARIABLE said RESULT_VARIABLE code)
  string(STRIP "${said}" said)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${folder} cannot be asked for its requirements: ${said}")
  endif()
  set(${out} ${said} PARENT_SCOPE)
endfunction()

macro(idf_component_register)
  cmake_parse_arguments(idf "" "" "SRCS;INCLUDE_DIRS;PRIV_INCLUDE_DIRS;REQUIRES;PRIV_REQUIRES" ${ARGN})
  set(COMPONENT_LIB __idf_${COMPONENT_NAME})
  add_library(${COMPONENT_LIB} STATIC ${idf_SRCS})
  target_include_directories(${COMPONENT_LIB} PUBLIC ${idf_INCLUDE_DIRS} PRIVATE ${idf_PRIV_INCLUDE_DIRS})
  target_link_libraries(${COMPONENT_LIB} PRIVATE idf_options)
endmacro()

# stub_component(NAME FOLDER)
function(stub_component COMPONENT_NAME folder)
  add_subdirectory(${folder} esp-idf/${COMPONENT_NAME})
  stub_requirements(required ${folder})
  foreach(name ${required})
    target_include_directories(__idf_${COMPONENT_NAME} PRIVATE ${idf_stub}/components/${name}/include)
  endforeach()
  file(READ ${folder}/idf_component.yml manifest)
  if(manifest MATCHES "\n  espressif/eigen: ")
    target_include_directories(__idf_${COMPONENT_NAME} PRIVATE ${STUB_EIGEN})
  endif()
  # The bits are the same at any level; a lower one takes less of the test's time.
  target_compile_options(__idf_${COMPONENT_NAME} PRIVATE ${STUB_OPTIMISATION})
endfunction()

macro(project name)
  _project(${name} C CXX)
  add_library(idf_options INTERFACE)
  target_compile_options(idf_options INTERFACE
    -Og -ffunction-sections -fdata-sections -Wall -Werror -Wno-error=unused-function -Wno-error=unused-variable -Wno-error=unused-but-set-variable
    -Wno-error=deprecated-declarations -Wextra -Wno-error=extra -Wno-unused-parameter -Wno-sign-compare
    $<$<COMPILE_LANGUAGE:C>:-std=gnu17> $<$<COMPILE_LANGUAGE:CXX>:-std=gnu++2b> $<$<COMPILE_LANGUAGE:CXX>:-fno-exceptions>
    $<$<COMPILE_LANGUAGE:CXX>:-fno-rtti>)
  add_executable(${name}.elf ${idf_stub}/app_main.c ${idf_stub}/system.c)
  foreach(component log esp_partition esp_timer)
    target_include_directories(${name}.elf PRIVATE ${idf_stub}/components/${component}/include)
  endforeach()
  stub_component(main ${CMAKE_CURRENT_LIST_DIR}/main)
  target_link_libraries(${name}.elf PRIVATE __idf_main)
  file(READ ${CMAKE_CURRENT_LIST_DIR}/main/idf_component.yml manifest)
  string(REGEX MATCHALL "override_path: \"[^\"]+\"" paths "${manifest}")
  foreach(path ${paths})
    string(REGEX REPLACE "override_path: \"(.+)\"" "${CMAKE_CURRENT_LIST_DIR}/main/\\1" path ${path})
    get_filename_component(path ${path} ABSOLUTE)
    get_filename_component(component ${path} NAME)
    stub_component(${component} ${path})
    target_link_libraries(__idf_main PRIVATE __idf_${component})
  endforeach()
endmacro()
