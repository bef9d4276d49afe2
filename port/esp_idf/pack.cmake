# cmake -DOUT=FOLDER/segcal -P pack.cmake: the component with all that belongs to it, in one folder, as the component registry and a project's
# components/ take it. The folder's name is the component's.
if(NOT OUT)
  message(FATAL_ERROR "usage: cmake -DOUT=FOLDER/segcal -P pack.cmake")
endif()
get_filename_component(out ${OUT} ABSOLUTE BASE_DIR ${CMAKE_CURRENT_BINARY_DIR})
if(EXISTS ${out})
  message(FATAL_ERROR "${out} is there already: what is left in it would be packed as well")
endif()
set(root ${CMAKE_CURRENT_LIST_DIR}/../..)
file(COPY ${CMAKE_CURRENT_LIST_DIR}/segcal/ ${root}/LICENSE DESTINATION ${out})
file(COPY ${root}/lib/src ${root}/lib/include ${root}/lib/sources.cmake DESTINATION ${out}/lib)
file(COPY ${root}/port/include DESTINATION ${out}/port)
file(COPY ${root}/examples/stream.h DESTINATION ${out}/examples/calibrate/main)
