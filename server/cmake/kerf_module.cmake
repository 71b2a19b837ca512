# One library a folder. Include root is the repository: #include "server/core/mesh/triangle_mesh.h".

add_library(kerf_warnings INTERFACE)
target_compile_options(kerf_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wnon-virtual-dtor -Woverloaded-virtual)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(kerf_warnings INTERFACE -Wno-restrict)  # false alarms on std::string (GCC bug 105651)
  if(KERF_SANITIZE)
    target_compile_options(kerf_warnings INTERFACE -Wno-maybe-uninitialized)  # and on std::regex (GCC bug 105562)
  endif()
endif()
if(KERF_WERROR)
  target_compile_options(kerf_warnings INTERFACE -Werror)
endif()

# What every target, ours or generated, is compiled with. Contraction off: the same source gives the same bits
# whether or not the processor has fused multiply-add.
add_library(kerf_flags INTERFACE)
target_compile_features(kerf_flags INTERFACE cxx_std_20)
target_compile_options(kerf_flags INTERFACE -ffp-contract=off)
# Position-independent for libkerf_local.so; without interposition functions are inlined as in a program.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
target_compile_options(kerf_flags INTERFACE $<BUILD_INTERFACE:-fno-semantic-interposition>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # The compiler collects no garbage below 1 GB: a seventh of its time for half as much memory again.
  target_compile_options(kerf_flags INTERFACE $<BUILD_INTERFACE:--param=ggc-min-heapsize=1000000>)
endif()
target_compile_definitions(kerf_flags INTERFACE EIGEN_DONT_PARALLELIZE EIGEN_MPL2_ONLY)
if(KERF_FUZZ)
  target_compile_options(kerf_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Our own libraries have sanitizers with assertions, and checks of every mesh invariant, beside that.
# Tests and generated code are not instrumented: they are compiled as for release, so that a compiler cache has them. The
# libraries are shared ones then, bound to their own copies of inline functions. Thread sanitizer and fuzzers need all.
add_library(kerf_instrumented INTERFACE)
if(KERF_VALIDATE)
  target_compile_definitions(kerf_instrumented INTERFACE KERF_VALIDATE)
endif()
if(KERF_SANITIZE)
  target_compile_options(kerf_instrumented INTERFACE
    -O1 -g1 -UNDEBUG -fsanitize=${KERF_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(kerf_flags INTERFACE -fsanitize=${KERF_SANITIZE})
  if(KERF_SANITIZE MATCHES "thread")
    # The thread sanitizer does not model fences; Asio's queues are ordered by their mutexes all the same.
    target_compile_definitions(kerf_instrumented INTERFACE BOOST_ASIO_DISABLE_FENCED_BLOCK)
  endif()
  if(KERF_SANITIZE MATCHES "address")
    # Eigen would pad its blocks itself where the sanitizer is on: tests, without it, could not free what libraries allocate.
    target_compile_definitions(kerf_instrumented INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
  if(KERF_SANITIZE MATCHES "undefined")
    # The four left out cost a third of the build; the address sanitizer finds what null and object-size would.
    target_compile_options(kerf_instrumented INTERFACE -fno-sanitize=null,alignment,object-size,vptr
                                                       -fno-sanitize-recover=undefined)
  endif()
  if(NOT BUILD_SHARED_LIBS)
    target_link_libraries(kerf_flags INTERFACE $<BUILD_INTERFACE:kerf_instrumented>)
  endif()
endif()

# kerf_batches(result_variable SIZE n SOURCES ...): with KERF_UNITY, files that include so many of the sources each, to be
# compiled in their place; without it the sources. Large ones: each compiles the headers of gRPC, Boost and Eigen
# once more. Not CMake's UNITY_BUILD: its absolute paths keep two checkouts from sharing a compiler cache.
function(kerf_batches result)
  cmake_parse_arguments(ARG "" "SIZE" "SOURCES" ${ARGN})
  set(batches ${ARG_SOURCES})
  if(KERF_UNITY)
    set(batches)
    set(rest ${ARG_SOURCES})
    while(rest)
      list(SUBLIST rest 0 ${ARG_SIZE} batch)
      list(REMOVE_ITEM rest ${batch})
      set(includes)
      foreach(source ${batch})
        cmake_path(ABSOLUTE_PATH source NORMALIZE)
        cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
        string(APPEND includes "#include \"${source}\"\n")
      endforeach()
      list(LENGTH batches number)
      set(path ${CMAKE_CURRENT_BINARY_DIR}/${result}_${number}.cc)
      file(CONFIGURE OUTPUT ${path} CONTENT "${includes}" @ONLY)
      list(APPEND batches ${path})
    endwhile()
  endif()
  set(${result} ${batches} PARENT_SCOPE)
endfunction()

# The include root of our headers: in the source tree, and where they are installed.
set(kerf_includes $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/kerf>)

# kerf_module(name SOURCES ... [ALONE ...] DEPENDS ...): library kerf_<name> with alias kerf::<name>. With KERF_UNITY its
# sources are compiled some at a time, as most of the time goes into the headers they share; those named in ALONE as well
# are not, and names in unnamed namespaces must be unique in a module.
function(kerf_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;ALONE;DEPENDS" ${ARGN})
  if(NOT ARG_SOURCES)  # header-only
    add_library(kerf_${name} INTERFACE)
    add_library(kerf::${name} ALIAS kerf_${name})
    target_include_directories(kerf_${name} INTERFACE ${kerf_includes})
    target_link_libraries(kerf_${name} INTERFACE kerf_flags ${ARG_DEPENDS})
    return()
  endif()
  set(together ${ARG_SOURCES})
  foreach(source ${ARG_ALONE})
    list(REMOVE_ITEM together ${source})
  endforeach()
  kerf_batches(${name}_batch SIZE 20 SOURCES ${together})
  add_library(kerf_${name} ${${name}_batch} ${ARG_ALONE})
  set_target_properties(kerf_${name} PROPERTIES KERF_SOURCES "${ARG_SOURCES}")
  add_library(kerf::${name} ALIAS kerf_${name})
  target_include_directories(kerf_${name} PUBLIC ${kerf_includes})
  target_link_libraries(kerf_${name} PUBLIC kerf_flags ${ARG_DEPENDS} PRIVATE $<BUILD_INTERFACE:kerf_warnings>
    $<BUILD_INTERFACE:kerf_instrumented>)
  if(BUILD_SHARED_LIBS)
    target_link_options(kerf_${name} PRIVATE -Wl,-Bsymbolic-functions)
  endif()
  if(KERF_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # False alarms on std::variant, where so much is inlined.
    target_compile_options(kerf_${name} PRIVATE $<$<CONFIG:Release>:-Wno-maybe-uninitialized>)
  endif()
endfunction()

# What programs of tests have in common: they themselves are compiled without much optimisation, what they test as it ships.
function(kerf_test_program name)
  target_link_libraries(${name} PRIVATE kerf_flags kerf_warnings ${ARGN} GTest::gtest_main GTest::gmock)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-Og>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${name} PRIVATE -Wno-maybe-uninitialized)  # false alarms on std::optional in std::variant
  endif()
endfunction()

# kerf_test(path/to/name_test.cc LABEL core DEPENDS ... [SLOW] [ARGS ...] [TIMEOUT seconds]): one binary and one ctest
# entry. SLOW tests are left out of `deploy/test quick`.
# Every test requires the fixture `built`, so `ctest --preset dev` builds what is stale first.
function(kerf_test source)
  cmake_parse_arguments(ARG "SLOW" "LABEL;TIMEOUT" "DEPENDS;ARGS" ${ARGN})
  if(ARG_SLOW)
    list(APPEND ARG_LABEL slow)
  endif()
  get_filename_component(folder ${source} DIRECTORY)
  get_filename_component(stem ${source} NAME_WE)
  string(REPLACE "/" "_" prefix "${folder}")
  if(prefix)
    set(name ${prefix}_${stem})
  else()
    set(name ${stem})
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(KERF_SANITIZE)
    math(EXPR ARG_TIMEOUT "6 * ${ARG_TIMEOUT}")  # instrumented code is that much slower
  endif()
  add_executable(${name} ${source})
  kerf_test_program(${name} ${ARG_DEPENDS})
  add_test(NAME ${name} COMMAND ${name} --gtest_brief=1 ${ARG_ARGS})
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABEL}" TIMEOUT ${ARG_TIMEOUT} FIXTURES_REQUIRED built)
endfunction()

# kerf_tests(name LABEL core SOURCES a_test.cc ... DEPENDS ... [SLOW] [SHARDS n] [TIMEOUT seconds]): the tests of a folder as one
# program, compiled some files at a time (see kerf_module), and as n entries of ctest, <name>_1 to <name>_n, that share
# its tests out among them.
function(kerf_tests name)
  cmake_parse_arguments(ARG "SLOW" "LABEL;SHARDS;TIMEOUT" "SOURCES;DEPENDS" ${ARGN})
  if(ARG_SLOW)
    list(APPEND ARG_LABEL slow)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(KERF_SANITIZE)
    math(EXPR ARG_TIMEOUT "6 * ${ARG_TIMEOUT}")
  endif()
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 1)
  endif()
  kerf_batches(${name}_batch SIZE 12 SOURCES ${ARG_SOURCES})
  add_executable(${name} ${${name}_batch})
  kerf_test_program(${name} ${ARG_DEPENDS})
  foreach(shard RANGE 1 ${ARG_SHARDS})
    math(EXPR index "${shard} - 1")
    add_test(NAME ${name}_${shard} COMMAND ${name} --gtest_brief=1)
    set_tests_properties(${name}_${shard} PROPERTIES LABELS "${ARG_LABEL}" TIMEOUT ${ARG_TIMEOUT} FIXTURES_REQUIRED built
      ENVIRONMENT "GTEST_TOTAL_SHARDS=${ARG_SHARDS};GTEST_SHARD_INDEX=${index}")
    if(ARG_SLOW)
      set_tests_properties(${name}_${shard} PROPERTIES COST 100)  # begins early, so that nothing runs alone at the end
    endif()
  endforeach()
endfunction()
