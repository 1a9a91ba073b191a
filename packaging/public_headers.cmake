# SPDX-License-Identifier: BSD-3-Clause
# The library's face: what is meant to be included, as <magimu/...>. Copies of these headers, and of
# those that they need, stand in the build folder's include/magimu with includes of that form; they
# serve projects that take magimu in by add_subdirectory() or FetchContent, and are what is installed.
set(magimu_public_headers
    graph/factor.h graph/factor_graph.h graph/numerical_error.h graph/rot3.h graph/values.h
    factors/keys.h factors/magnetometer_factor.h factors/prior_factor.h
    factors/relative_rotation_factor.h factors/effects/effect.h
    solvers/levenberg_marquardt.h solvers/marginals.h solvers/tree/incremental_qr.h
    recording/read.h recording/csv/csv.h recording/data/error.h recording/data/recording.h
    sim/simulate.h
    calibration/calibrate.h calibration/fit/parameter_prior.h calibration/fit/stage.h
    calibration/live/streaming.h calibration/model/extension.h calibration/result/calibration_json.h
    calibration/survey/survey.h
    calibration/trust/field_check.h calibration/use/apply.h calibration/use/export.h
    diagnosis/result/diagnosis.h diagnosis/result/diagnosis_json.h)

# How Eigen aligns and allocates depends on a file's flags: under -mavx it takes 32 bytes and an allocator
# of its own. What a user's file and the library share must agree: magimu/same_memory.h stops the compiler
# where it does not.
separate_arguments(flags UNIX_COMMAND "${CMAKE_CXX_FLAGS}")
get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
list(TRANSFORM eigen PREPEND -I)
file(WRITE ${PROJECT_BINARY_DIR}/eigen_memory.cpp "#include <Eigen/Core>
#ifdef _GLIBCXX_DEBUG
#define CONTAINERS 1
#else
#define CONTAINERS 0
#endif
magimu_memory EIGEN_DEFAULT_ALIGN_BYTES EIGEN_MAX_STATIC_ALIGN_BYTES EIGEN_MALLOC_ALREADY_ALIGNED CONTAINERS
")
execute_process(COMMAND ${CMAKE_CXX_COMPILER} ${flags} ${eigen} -E ${PROJECT_BINARY_DIR}/eigen_memory.cpp
                OUTPUT_VARIABLE preprocessed COMMAND_ERROR_IS_FATAL ANY)
if(NOT preprocessed MATCHES "magimu_memory ([0-9]+) ([0-9]+) ([01]) ([01])")
  message(FATAL_ERROR "How Eigen aligns its matrices is not to be found out")
endif()
set(magimu_alignment ${CMAKE_MATCH_1})
set(magimu_static_alignment ${CMAKE_MATCH_2})
set(magimu_plain_malloc ${CMAKE_MATCH_3})
set(magimu_debug_containers ${CMAKE_MATCH_4})
configure_file(packaging/same_memory.h.in include/magimu/same_memory.h @ONLY)
# Users of the installed library get Eigen's code for the instructions that it was built with.
set(magimu_user_flags -DEIGEN_MALLOC_ALREADY_ALIGNED=${magimu_plain_malloc})
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND magimu_alignment EQUAL 16)
  list(APPEND magimu_user_flags -U__AVX__ -U__AVX2__ -U__AVX512F__ -U__FMA__)
endif()

set(waiting ${magimu_public_headers})
set(needed "")
while(waiting)
  list(POP_FRONT waiting header)
  if(header IN_LIST needed)
    continue()
  endif()
  list(APPEND needed ${header})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
  file(READ ${PROJECT_SOURCE_DIR}/${header} text)
  string(REGEX MATCHALL "#include \"[a-z_0-9/]+\\.h\"" includes "${text}")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "#include \"([^\"]*)\"" "\\1" include "${include}")
    list(APPEND waiting ${include})
  endforeach()
  string(REGEX REPLACE "#include \"([a-z_0-9/]+\\.h)\"" "#include <magimu/\\1>" text "${text}")
  string(REPLACE "#include <Eigen/Core>\n" "#include <Eigen/Core>\n#include <magimu/same_memory.h>\n" text
         "${text}")
  set(copy ${PROJECT_BINARY_DIR}/include/magimu/${header})
  set(present "")
  if(EXISTS ${copy})
    file(READ ${copy} present)
  endif()
  if(NOT "${present}" STREQUAL "${text}")
    file(WRITE ${copy} "${text}")
  endif()
endwhile()
# Copies of headers that are public no longer.
file(GLOB_RECURSE copies RELATIVE ${PROJECT_BINARY_DIR}/include/magimu
     ${PROJECT_BINARY_DIR}/include/magimu/*.h)
foreach(copy IN LISTS copies)
  if(NOT copy IN_LIST needed AND NOT copy STREQUAL same_memory.h)
    file(REMOVE ${PROJECT_BINARY_DIR}/include/magimu/${copy})
  endif()
endforeach()
