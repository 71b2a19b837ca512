# Installs what other projects take with find_package(kerf): the simulation library (component core) and the client library
# (component client). Each has one front door, <kerf/kerf.h> and <kerf/client.h>, and installs what that includes, nothing
# else. The component devel of `cmake --install` is all of that without the programs.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(kerf_package ${CMAKE_INSTALL_LIBDIR}/cmake/kerf)

# kerf_install_part(part TARGETS ... [DOOR folder HEADERS file ...]): libraries, exported as kerf::x. `folder` has the front
# door at kerf/x.h. The files are included from it as in this repository, and installed below include/kerf.
function(kerf_install_part part)
  cmake_parse_arguments(ARG "" "DOOR" "TARGETS;HEADERS" ${ARGN})
  foreach(target ${ARG_TARGETS})
    string(REGEX REPLACE "^kerf_" "" name ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  endforeach()
  add_dependencies(installed ${ARG_TARGETS})
  install(TARGETS ${ARG_TARGETS} EXPORT kerf-${part}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT devel)
  install(EXPORT kerf-${part} NAMESPACE kerf:: FILE kerf-${part}.cmake DESTINATION ${kerf_package} COMPONENT devel)
  foreach(header ${ARG_HEADERS})
    cmake_path(GET header PARENT_PATH folder)
    install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION include/kerf/${folder} COMPONENT devel)
  endforeach()
  if(ARG_DOOR)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/${ARG_DOOR}/kerf/ DESTINATION include/kerf COMPONENT devel FILES_MATCHING PATTERN "*.h")
  endif()
endfunction()

kerf_install_part(base TARGETS kerf_flags kerf_base kerf_codec)
kerf_install_part(core TARGETS kerf_linear kerf_mesh kerf_cut kerf_contact kerf_fem kerf_scene kerf_sheet kerf_analysis kerf_core
  DOOR server/core
  HEADERS
    server/base/result.h server/core/analysis/analysis.h server/core/contact/collider.h server/core/cut/curve.h server/core/cut/cut_types.h
    server/core/fem/element/material.h server/core/fem/step/step_stats.h server/core/linear/linear_solver_kind.h
    server/core/mesh/ids.h server/core/scene/sheet_config.h server/core/scene/command.h server/core/scene/conditions.h
    server/core/scene/sheet_config.h server/core/sheet/sheet.h server/core/sheet/snapshot.h)
set(kerf_parts core)
if(KERF_TRANSPORTS)
  kerf_install_part(client TARGETS kerf_messages kerf_services kerf_client
    DOOR client/cpp
    HEADERS
      client/cpp/client.h client/cpp/cut_options.h client/cpp/failure.h client/cpp/geometry.h client/cpp/image_watcher.h
      client/cpp/live_stream.h client/cpp/mirror.h client/cpp/result.h client/cpp/run_writer.h client/cpp/scene.h
      client/cpp/server.h client/cpp/sheet.h client/cpp/watcher.h server/service/codec/vertex_predictors.h)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/proto/ DESTINATION include/kerf COMPONENT devel
    FILES_MATCHING PATTERN "*.pb.h" PATTERN CMakeFiles EXCLUDE)
  list(APPEND kerf_parts client)
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/server/cmake/kerf-config.cmake.in
  ${PROJECT_BINARY_DIR}/kerf-config.cmake INSTALL_DESTINATION ${kerf_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kerf-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kerf-config.cmake ${PROJECT_BINARY_DIR}/kerf-config-version.cmake
  DESTINATION ${kerf_package} COMPONENT devel)
