# cmake --install BUILD --prefix PREFIX: the library `segcal`, for find_package(segcal) with target segcal::segcal, and for
# pkg-config. Users see C headers and one archive; Eigen is only needed to build it.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

target_include_directories(segcal INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
install(TARGETS segcal segcal_store segcal_clock EXPORT segcal_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY lib/include/segcal port/include/segcal DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

set(segcal_package ${CMAKE_INSTALL_LIBDIR}/cmake/segcal)
install(EXPORT segcal_targets NAMESPACE segcal:: FILE segcal-config.cmake DESTINATION ${segcal_package})
write_basic_package_version_file(segcal-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/segcal-config-version.cmake DESTINATION ${segcal_package})

# The library folder may be deeper than one level (lib/x86_64-linux-gnu).
file(RELATIVE_PATH segcal_pc_to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/segcal.pc.in segcal.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/segcal.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
