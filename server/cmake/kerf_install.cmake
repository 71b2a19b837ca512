# What other projects take with find_package(kerf): the simulation library (component core) and the client library (component
# client), with their headers in include/kerf, so that #include "server/core/sheet/sheet.h" is found there as it is here. The
# component devel of `cmake --install` is all of that without the programs.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(kerf_package ${CMAKE_INSTALL_LIBDIR}/cmake/kerf)

# kerf_install_part(part TARGETS ... HEADERS folder ...): libraries and the headers of their folders, exported as kerf::x.
function(kerf_install_part part)
  cmake_parse_arguments(ARG "" "" "TARGETS;HEADERS" ${ARGN})
  foreach(target ${ARG_TARGETS})
    string(REGEX REPLACE "^kerf_" "" name ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  endforeach()
  add_dependencies(installed ${ARG_TARGETS})
  install(TARGETS ${ARG_TARGETS} EXPORT kerf-${part}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT devel)
  install(EXPORT kerf-${part} NAMESPACE kerf:: FILE kerf-${part}.cmake DESTINATION ${kerf_package} COMPONENT devel)
  foreach(folder ${ARG_HEADERS})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION include/kerf/${folder}/.. COMPONENT devel
      FILES_MATCHING PATTERN "*.h")
  endforeach()
endfunction()

kerf_install_part(base TARGETS kerf_flags kerf_base kerf_codec HEADERS server/base server/service/codec)
kerf_install_part(core TARGETS kerf_linear kerf_mesh kerf_cut kerf_contact kerf_fem kerf_scene kerf_sheet kerf_analysis kerf_core
  HEADERS server/core)
set(kerf_parts core)
if(KERF_TRANSPORTS)
  kerf_install_part(client TARGETS kerf_messages kerf_services kerf_client HEADERS client/cpp)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/proto/ DESTINATION include/kerf COMPONENT devel
    FILES_MATCHING PATTERN "*.pb.h" PATTERN CMakeFiles EXCLUDE)
  list(APPEND kerf_parts client)
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/server/cmake/kerf-config.cmake.in
  ${PROJECT_BINARY_DIR}/kerf-config.cmake INSTALL_DESTINATION ${kerf_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kerf-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kerf-config.cmake ${PROJECT_BINARY_DIR}/kerf-config-version.cmake
  DESTINATION ${kerf_package} COMPONENT devel)
