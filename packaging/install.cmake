# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` puts where: the program, the libraries with their headers, what
# find_package(magimu) and pkg-config need, completion for bash; and a .deb of all that (cpack).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(magimu_rooms graph factors solvers recording sim calibration diagnosis)
add_library(magimu_library INTERFACE)
set_target_properties(magimu_library PROPERTIES EXPORT_NAME magimu)
target_compile_features(magimu_library INTERFACE cxx_std_20)
set(magimu_pc_libraries "")
foreach(room ${magimu_rooms})
  target_link_libraries(magimu_library INTERFACE magimu_${room})
  set(magimu_pc_libraries "-lmagimu_${room} ${magimu_pc_libraries}")  # the last room first
  install(DIRECTORY ${room} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/magimu
          FILES_MATCHING PATTERN "*.h")
  install(TARGETS magimu_${room} EXPORT magimuTargets DESTINATION ${CMAKE_INSTALL_LIBDIR})
endforeach()
install(TARGETS magimu_library EXPORT magimuTargets)
install(EXPORT magimuTargets NAMESPACE magimu::
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/magimu)
configure_package_config_file(packaging/magimuConfig.cmake.in magimuConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/magimu)
write_basic_package_version_file(magimuConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/magimuConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/magimuConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/magimu)

# The libraries are static: whoever links them links what they need.
foreach(library ${HDF5_C_LIBRARIES} ${ZLIB_LIBRARIES} ${BZ2_LIBRARY} ${SQLITE3_LIBRARY} ${LZ4_LIBRARY}
                ${ZSTD_LIBRARY})
  string(APPEND magimu_pc_libraries " ${library}")
endforeach()
if(MAGIMU_WITH_SUITESPARSE)
  string(APPEND magimu_pc_libraries " -lspqr -lcholmod")
endif()
file(RELATIVE_PATH magimu_pc_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(packaging/magimu.pc.in magimu.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/magimu.pc
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

if(TARGET magimu)
  install(TARGETS magimu DESTINATION ${CMAKE_INSTALL_BINDIR})
  add_custom_command(TARGET magimu POST_BUILD COMMAND magimu completion > magimu.bash
                     WORKING_DIRECTORY ${CMAKE_BINARY_DIR} VERBATIM)
  install(FILES ${CMAKE_BINARY_DIR}/magimu.bash
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME magimu)
endif()
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME magimu)
set(CPACK_PACKAGE_CONTACT "magimu developers <magimu@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Calibrates magnetometers and IMUs together")
set(CPACK_PACKAGE_DESCRIPTION
    "Joint calibration of magnetometer, accelerometer and gyroscope from a recording of someone
 turning the sensor by hand: a program and a C++20 library.")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
    "libeigen3-dev, libtbb-dev, libfmt-dev, nlohmann-json3-dev, libhdf5-dev, libsuitesparse-dev, libbz2-dev, liblz4-dev, libzstd-dev, libsqlite3-dev")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
include(CPack)
