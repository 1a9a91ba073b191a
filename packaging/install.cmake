# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` puts where: the program, the libraries with their headers, what
# find_package(magimu) and pkg-config need, completion for bash, the manual page; and Debian packages
# of all that (cpack).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

include(packaging/public_headers.cmake)

set(magimu_rooms statistics graph factors solvers recording earth sim calibration diagnosis)
add_library(magimu_library INTERFACE)
add_library(magimu::magimu ALIAS magimu_library)
set_target_properties(magimu_library PROPERTIES EXPORT_NAME magimu)
target_compile_features(magimu_library INTERFACE cxx_std_20)
target_include_directories(magimu_library INTERFACE
                           $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
                           $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_compile_options(magimu_library INTERFACE $<INSTALL_INTERFACE:${magimu_user_flags}>)
list(JOIN magimu_user_flags " " magimu_pc_flags)
set(magimu_pc_libraries "")
foreach(room ${magimu_rooms})
  target_link_libraries(magimu_library INTERFACE magimu_${room})
  set(magimu_pc_libraries "-lmagimu_${room} ${magimu_pc_libraries}")  # the last room first
endforeach()
if(NOT PROJECT_IS_TOP_LEVEL)
  return()  # what is installed is for the project to say that took the library in
endif()
foreach(room ${magimu_rooms})
  install(TARGETS magimu_${room} EXPORT magimuTargets COMPONENT dev
          DESTINATION ${CMAKE_INSTALL_LIBDIR})
endforeach()
install(DIRECTORY ${PROJECT_BINARY_DIR}/include/magimu COMPONENT dev
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS magimu_library EXPORT magimuTargets)
install(EXPORT magimuTargets NAMESPACE magimu:: COMPONENT dev
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/magimu)
configure_package_config_file(packaging/magimuConfig.cmake.in magimuConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/magimu)
write_basic_package_version_file(magimuConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/magimuConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/magimuConfigVersion.cmake
        COMPONENT dev DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/magimu)

# The libraries are static: whoever links them links what they need.
foreach(library ${HDF5_C_LIBRARIES} ${ZLIB_LIBRARIES} ${BZ2_LIBRARY} ${SQLITE3_LIBRARY} ${LZ4_LIBRARY}
                ${ZSTD_LIBRARY})
  # Without a machine's folder, which pkg-config adds: the file is the same for every architecture.
  set(folder /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE})
  if(library MATCHES "^${folder}/lib([^/]+)[.](so|a)$")
    string(APPEND magimu_pc_libraries " -l${CMAKE_MATCH_1}")
  elseif(library MATCHES "^${folder}/.*/libhdf5[.]so$" AND EXISTS ${folder}/pkgconfig/hdf5.pc)
    set(magimu_pc_requires " hdf5")
  else()
    string(APPEND magimu_pc_libraries " ${library}")
  endif()
endforeach()
if(MAGIMU_WITH_SUITESPARSE)
  string(APPEND magimu_pc_libraries " -lspqr -lcholmod")
endif()
file(RELATIVE_PATH magimu_pc_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(packaging/magimu.pc.in magimu.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/magimu.pc COMPONENT dev
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

if(TARGET magimu)
  install(TARGETS magimu COMPONENT program DESTINATION ${CMAKE_INSTALL_BINDIR})
  find_program(GZIP gzip)
  add_custom_command(TARGET magimu POST_BUILD COMMAND magimu completion > magimu.bash
                     COMMAND magimu man > magimu.1
                     COMMAND $<IF:$<BOOL:${GZIP}>,${GZIP},true> -9nkf magimu.1
                     WORKING_DIRECTORY ${PROJECT_BINARY_DIR} VERBATIM)
  install(FILES ${PROJECT_BINARY_DIR}/magimu.1$<$<BOOL:${GZIP}>:.gz> COMPONENT program
          DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${PROJECT_BINARY_DIR}/magimu.bash COMPONENT program
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME magimu)
endif()
install(FILES README.md COMPONENT program DESTINATION ${CMAKE_INSTALL_DOCDIR})

# Two Debian packages: magimu (what is run) and libmagimu-dev (what is built with).
string(TIMESTAMP magimu_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(magimu_copyright_note "")
if(MAGIMU_WITH_SUITESPARSE)
  set(magimu_copyright_note
      "Comment: This program contains SPQR and the supernodal part of CHOLMOD, of SuiteSparse, which
 are under the GNU General Public License, version 2 or later: as a whole it may be passed on
 under the terms of that licence only (/usr/share/common-licenses/GPL-2).
")
endif()
file(STRINGS LICENSE magimu_licence_lines)
set(magimu_licence "")
foreach(line IN LISTS magimu_licence_lines)
  if(line STREQUAL "")
    set(line ".")
  endif()
  string(APPEND magimu_licence " ${line}\n")
endforeach()
configure_file(packaging/copyright.in copyright @ONLY)
configure_file(packaging/changelog.in changelog @ONLY)
foreach(package magimu libmagimu-dev)
  string(REPLACE "libmagimu-dev" "dev" component ${package})
  string(REPLACE "magimu" "program" component ${component})
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/copyright COMPONENT ${component}
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package})
  if(GZIP)
    execute_process(COMMAND ${GZIP} -9nkf changelog
                    WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
    install(FILES ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz COMPONENT ${component}
            DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package})
  endif()
endforeach()

# A package needs the program and the libraries: no tests and measurements built for it.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME magimu)
# lintian asks for the address of a real mail host. The project has none, and an invented one would
# reach a stranger or nobody: whoever distributes the packages puts their own here.
set(CPACK_PACKAGE_CONTACT "magimu developers <magimu@localhost>")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program dev)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME magimu)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "Calibrates magnetometers and IMUs together
Joint calibration of magnetometer, accelerometer and gyroscope from a
recording of someone turning the sensor by hand, with the uncertainty of
every number and a verdict.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libmagimu-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "libeigen3-dev, libtbb-dev, libfmt-dev, nlohmann-json3-dev, libhdf5-dev, zlib1g-dev, libbz2-dev, liblz4-dev, libzstd-dev, libsqlite3-dev")
if(MAGIMU_WITH_SUITESPARSE)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libsuitesparse-dev")
endif()
set(CPACK_DEBIAN_DEV_DESCRIPTION "Calibrates magnetometers and IMUs together (development files)
Headers and static libraries of magimu: recordings, calibration,
diagnosis, and the factor graph below them; with find_package() and
pkg-config.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
include(CPack)
