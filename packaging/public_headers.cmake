# SPDX-License-Identifier: BSD-3-Clause
# The library's face: what is meant to be included, as <magimu/...>. Copies of these headers, and of
# those that they need, stand in the build folder's include/magimu with includes of that form; they
# serve projects that take magimu in by add_subdirectory() or FetchContent, and are what is installed.
set(magimu_public_headers
    graph/factor.h graph/factor_graph.h graph/rot3.h graph/values.h
    factors/keys.h factors/magnetometer_factor.h factors/prior_factor.h
    factors/relative_rotation_factor.h factors/effects/effect.h
    solvers/levenberg_marquardt.h solvers/marginals.h solvers/tree/incremental_qr.h
    recording/read.h recording/csv/csv.h recording/data/recording.h
    sim/simulate.h
    calibration/calibrate.h calibration/fit/stage.h calibration/live/streaming.h
    calibration/model/extension.h calibration/result/calibration_json.h calibration/survey/survey.h
    calibration/use/apply.h calibration/use/export.h
    diagnosis/result/diagnosis.h diagnosis/result/diagnosis_json.h)

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
  # No line of a header is to be taken for a list, or for a bracket's end.
  string(REGEX MATCHALL "#include \"[a-z_0-9/]+\\.h\"" includes "${text}")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "#include \"([^\"]*)\"" "\\1" include "${include}")
    list(APPEND waiting ${include})
  endforeach()
  string(REGEX REPLACE "#include \"([a-z_0-9/]+\\.h)\"" "#include <magimu/\\1>" text "${text}")
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
  if(NOT copy IN_LIST needed)
    file(REMOVE ${PROJECT_BINARY_DIR}/include/magimu/${copy})
  endif()
endforeach()
