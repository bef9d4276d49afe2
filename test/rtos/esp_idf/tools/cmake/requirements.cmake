# cmake -DFOLDER=COMPONENT -P requirements.cmake: prints what a component requires, as a list.
macro(idf_component_register)
  cmake_parse_arguments(idf "" "" "REQUIRES;PRIV_REQUIRES" ${ARGN})
  message("${idf_REQUIRES};${idf_PRIV_REQUIRES}")
  return()
endmacro()
include(${FOLDER}/CMakeLists.txt)
