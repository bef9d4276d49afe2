# Target `unity`: the test framework. The first of these that is there:
#   1. third_party/unity, where host_tools/setup.sh put it,
#   2. its own repository at the pinned tag,
#   3. Debian's source package that carries it (host_tools/fetch_unity.sh).
set(unity_repository https://github.com/ThrowTheSwitch/Unity.git)
set(unity_tag v2.6.0)
set(unity_cache ${PROJECT_SOURCE_DIR}/third_party/unity)

# Asked first, because an unreachable repository makes FetchContent wait for minutes and then stop.
function(segcal_reachable repository result)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env GIT_TERMINAL_PROMPT=0 git ls-remote --exit-code ${repository} refs/tags/${unity_tag}
    TIMEOUT 8 RESULT_VARIABLE code OUTPUT_QUIET ERROR_QUIET)
  if(code EQUAL 0)
    set(${result} TRUE PARENT_SCOPE)
  else()
    set(${result} FALSE PARENT_SCOPE)
  endif()
endfunction()

set(unity_folder ${unity_cache})
if(NOT EXISTS ${unity_cache}/unity.c)
  segcal_reachable(${unity_repository} unity_reachable)
  if(unity_reachable)
    include(FetchContent)
    # SOURCE_SUBDIR names no folder with a CMakeLists.txt: the sources are wanted, not Unity's own targets.
    FetchContent_Declare(unity GIT_REPOSITORY ${unity_repository} GIT_TAG ${unity_tag} GIT_SHALLOW TRUE SOURCE_SUBDIR src)
    FetchContent_MakeAvailable(unity)
    set(unity_folder ${unity_SOURCE_DIR}/src)
  else()
    execute_process(COMMAND ${PROJECT_SOURCE_DIR}/host_tools/fetch_unity.sh ${unity_cache} COMMAND_ERROR_IS_FATAL ANY)
  endif()
endif()
message(STATUS "Unity: ${unity_folder}")

add_library(unity STATIC ${unity_folder}/unity.c)
target_include_directories(unity SYSTEM PUBLIC ${CMAKE_CURRENT_LIST_DIR} ${unity_folder})
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_DOUBLE)
