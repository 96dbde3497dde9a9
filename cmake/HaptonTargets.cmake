# The compile rules that all targets share, and one function for each kind of target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
# Where installed programs and libraries find the libraries of the package, if these are shared.
include(GNUInstallDirs)
if(BUILD_SHARED_LIBS)
  set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}" "$ORIGIN")
endif()
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(HAPTON_CCACHE ccache)
if(HAPTON_CCACHE)
  # Without this, ccache does not cache files that include a precompiled header, and another folder's build shares nothing.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env "CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime"
    "CCACHE_BASEDIR=${CMAKE_SOURCE_DIR}" CCACHE_NOHASHDIR=1 "${HAPTON_CCACHE}")
endif()
find_program(HAPTON_MOLD mold)
if(HAPTON_MOLD)
  add_link_options(-fuse-ld=mold)
endif()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(tl-expected REQUIRED)
find_package(Threads REQUIRED)

add_library(hapton_options INTERFACE)
target_include_directories(hapton_options INTERFACE "$<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>" $<INSTALL_INTERFACE:include/hapton>)
target_compile_features(hapton_options INTERFACE $<INSTALL_INTERFACE:cxx_std_20>)
# Warnings and the CPU are for this build only; the rest also holds for users of the installed package.
set(hapton_warnings -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Werror)
target_compile_options(hapton_options INTERFACE
  "$<BUILD_INTERFACE:${hapton_warnings}>"
  # Products and sums round as written: the error bounds of core/math depend on it.
  -ffp-contract=off)
if(HAPTON_MARCH)
  target_compile_options(hapton_options INTERFACE "$<BUILD_INTERFACE:-march=${HAPTON_MARCH}>")
endif()
if(HAPTON_SCALAR)
  target_compile_definitions(hapton_options INTERFACE HAPTON_SCALAR)
endif()
if(HAPTON_SANITIZE)
  target_compile_options(hapton_options INTERFACE -fsanitize=${HAPTON_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(hapton_options INTERFACE -fsanitize=${HAPTON_SANITIZE})
  if(HAPTON_SANITIZE MATCHES "undefined")
    target_compile_options(hapton_options INTERFACE -fno-sanitize-recover=undefined)
  endif()
  if(HAPTON_SANITIZE MATCHES "thread")
    target_compile_options(hapton_options INTERFACE -Wno-tsan)
  endif()
endif()
# GCC 12 reports false positives inside Eigen and the standard library at -O3.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(hapton_false_positives -Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread -Wno-restrict)
  # No program replaces a function of these libraries by its own (interposition), so calls within a file may be inlined in shared libraries, too.
  target_compile_options(hapton_options INTERFACE "$<BUILD_INTERFACE:${hapton_false_positives};-fno-semantic-interposition>")
endif()

# Headers that nearly every source includes are precompiled, once for each level of optimisation, in the build that is made most often. In the
# other builds, which include those that check more, each source must include what it needs.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_BUILD_TYPE STREQUAL "Release")
  file(CONFIGURE OUTPUT "${CMAKE_BINARY_DIR}/pch.cpp" CONTENT "")
  foreach(level O3 O1)
    add_library(hapton_pch_${level} OBJECT EXCLUDE_FROM_ALL "${CMAKE_BINARY_DIR}/pch.cpp")
    target_link_libraries(hapton_pch_${level} PRIVATE hapton_options Eigen3::Eigen fmt::fmt tl::expected)
    target_compile_options(hapton_pch_${level} PRIVATE -${level} -fpch-preprocess)
    target_precompile_headers(hapton_pch_${level} PRIVATE <algorithm> <array> <atomic> <cmath> <cstdint> <functional> <limits> <memory> <optional>
      <span> <string> <string_view> <utility> <vector> <fmt/core.h> <tl/expected.hpp> <Eigen/Core> <Eigen/Geometry>)
  endforeach()
endif()

# hapton_reuse_pch(NAME PCH): the target uses the precompiled headers of PCH, if PCH exists. Both need the same level of optimisation.
function(hapton_reuse_pch name pch)
  if(TARGET ${pch})
    target_compile_options(${name} PRIVATE -fpch-preprocess)
    target_precompile_headers(${name} REUSE_FROM ${pch})
  endif()
endfunction()

# hapton_source_level(LEVEL SOURCES ...): these sources are compiled at -LEVEL (O1 or O3), whatever the level of their target, with the headers precompiled for that level.
function(hapton_source_level level)
  set(options "-${level}")
  if(TARGET hapton_pch_${level})
    set(header "${CMAKE_BINARY_DIR}/CMakeFiles/hapton_pch_${level}.dir/cmake_pch.hxx")
    list(APPEND options -fpch-preprocess -Winvalid-pch -include "${header}")
    set_property(SOURCE ${ARGN} APPEND PROPERTY OBJECT_DEPENDS "${header}.gch")
  endif()
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "$<$<CONFIG:Release>:${options}>" SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# hapton_join_sources(NAME): with HAPTON_JOIN_SOURCES, compiles several sources of a target at a time, so that headers are read once for all of
# them. Names in anonymous namespaces must differ within the target, also from names in headers that its other files include: a new file
# changes which files are joined.
function(hapton_join_sources name)
  if(HAPTON_JOIN_SOURCES)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  endif()
endfunction()

# The libraries that find_package(hapton) finds (HaptonPackage.cmake). They can be built as shared libraries.
set(hapton_package_libraries hapton_core_base hapton_core_math hapton_core_effects hapton_core_geometry hapton_core_sculpt hapton_core_collision hapton_core_force
  hapton_core_tool hapton_runtime hapton_proto hapton_link hapton_scene hapton_safety hapton_hid hapton_watchdog_library hapton_plugin_host hapton_devices)

# hapton_add_library(NAME SOURCES ...): as add_library: shared with BUILD_SHARED_LIBS if the library is in the package, otherwise static.
function(hapton_add_library name)
  if(BUILD_SHARED_LIBS AND name IN_LIST hapton_package_libraries)
    add_library(${name} SHARED ${ARGN})
    # Without CMake's macro NAME_EXPORTS, so that objects are the same as those of the static library. The versions follow that of the package.
    # All in one folder, where dpkg-shlibdeps finds them.
    set_target_properties(${name} PROPERTIES DEFINE_SYMBOL "" VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
      LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
  else()
    add_library(${name} STATIC ${ARGN})
  endif()
endfunction()

# hapton_library(NAME [UNHURRIED] [JOINED] LINKS ...): the library of this folder, from its *.cpp; header-only when it has none.
# UNHURRIED: its work is done once, or at the pace of a person, so compile time matters more than run time: -O1.
# JOINED: its sources may be compiled several at a time (UNHURRIED ones may, too). Not for a layer of the hot path, which every build compiles in the same way.
function(hapton_library name)
  cmake_parse_arguments(ARG "UNHURRIED;JOINED" "" "LINKS;SOURCES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$")
  list(APPEND sources ${ARG_SOURCES})
  # A command line is read once and a report written once, and most of the compile time goes into CLI11 and JSON.
  if(NOT ARG_UNHURRIED)
    set(unhurried ${sources})
    list(FILTER unhurried INCLUDE REGEX "_(command|options|report)\\.cpp$")
    if(unhurried)
      hapton_source_level(O1 ${unhurried})
    endif()
  endif()
  if(sources)
    hapton_add_library(${name} ${sources})
    target_link_libraries(${name} PUBLIC hapton_options ${ARG_LINKS})
    if(ARG_UNHURRIED)
      target_compile_options(${name} PRIVATE "$<$<CONFIG:Release>:-O1>")
      hapton_reuse_pch(${name} hapton_pch_O1)
    else()
      hapton_reuse_pch(${name} hapton_pch_O3)
    endif()
    if(ARG_UNHURRIED OR ARG_JOINED)
      hapton_join_sources(${name})
    endif()
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE hapton_options ${ARG_LINKS})
  endif()
endfunction()

# hapton_program(NAME LINKS ...): the program of this folder's main.cpp.
function(hapton_program name)
  cmake_parse_arguments(ARG "" "" "LINKS" ${ARGN})
  add_executable(${name} main.cpp)
  target_link_libraries(${name} PRIVATE ${ARG_LINKS})
endfunction()
