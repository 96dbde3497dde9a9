# The compile rules that all targets share, and one function for each kind of target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
# RPATH: where installed programs and libraries find the shared libraries of the package.
include(GNUInstallDirs)
if(BUILD_SHARED_LIBS)
  set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}" "$ORIGIN")
endif()
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(HAPTON_CCACHE ccache)
if(HAPTON_CCACHE)
  # Without these settings ccache does not cache files that include a precompiled header, and builds in different folders share no cached files.
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
# Warnings and the CPU apply to this build only. The other options also apply to programs that use the installed package.
set(hapton_warnings -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Werror)
target_compile_options(hapton_options INTERFACE
  "$<BUILD_INTERFACE:${hapton_warnings}>"
  # Products and sums are rounded as written: the error bounds of core/math depend on it.
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
  # No program replaces functions of these libraries with its own (interposition). So the compiler may inline calls within a file in shared
  # libraries too.
  target_compile_options(hapton_options INTERFACE "$<BUILD_INTERFACE:${hapton_false_positives};-fno-semantic-interposition>")
endif()

# Headers that nearly every source includes are precompiled, once for each level of optimisation, but only in Release builds with GCC, which are
# built most often. In all other builds, such as those with sanitizers, a source that lacks an #include does not compile.
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

# hapton_source_level(LEVEL SOURCES ...): in Release builds compiles these sources at -LEVEL (O1 or O3), whatever the level of their target, with the
# headers precompiled for that level.
function(hapton_source_level level)
  set(options "-${level}")
  if(TARGET hapton_pch_${level})
    set(header "${CMAKE_BINARY_DIR}/CMakeFiles/hapton_pch_${level}.dir/cmake_pch.hxx")
    list(APPEND options -fpch-preprocess -Winvalid-pch -include "${header}")
    set_property(SOURCE ${ARGN} APPEND PROPERTY OBJECT_DEPENDS "${header}.gch")
  endif()
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "$<$<CONFIG:Release>:${options}>" SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# hapton_join_sources(NAME): with HAPTON_JOIN_SOURCES, compiles several sources of a target as one (unity build), so that their headers are read
# only once. So names in anonymous namespaces must differ within the whole target, and from the names in all headers that its sources include: a
# new file changes which files are compiled together.
function(hapton_join_sources name)
  if(HAPTON_JOIN_SOURCES)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  endif()
endfunction()

# The libraries of the package that find_package(hapton) finds (HaptonPackage.cmake). BUILD_SHARED_LIBS makes them shared libraries.
set(hapton_package_libraries hapton_core_base hapton_core_math hapton_core_effects hapton_core_geometry hapton_core_sculpt hapton_core_collision hapton_core_force
  hapton_core_tool hapton_runtime hapton_proto hapton_link hapton_scene hapton_safety hapton_hid hapton_watchdog_library hapton_plugin_host hapton_devices)

# hapton_add_library(NAME SOURCES ...): like add_library. The library is shared if BUILD_SHARED_LIBS is on and it belongs to the package, otherwise static.
function(hapton_add_library name)
  if(BUILD_SHARED_LIBS AND name IN_LIST hapton_package_libraries)
    add_library(${name} SHARED ${ARGN})
    # DEFINE_SYMBOL "": CMake does not define the macro NAME_EXPORTS, so the object files are the same as those of the static library. The
    # versions follow the version of the package. All shared libraries are in one folder, where dpkg-shlibdeps finds them.
    set_target_properties(${name} PROPERTIES DEFINE_SYMBOL "" VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
      LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
  else()
    add_library(${name} STATIC ${ARGN})
  endif()
endfunction()

# hapton_library(NAME [UNHURRIED] [JOINED] [SOURCES ...] LINKS ...): the library of this folder, from its *.cpp files and SOURCES. Without sources it is
# header-only.
# UNHURRIED: its run time hardly matters, because its work is done once, or when a person asks for it. So it is compiled faster, at -O1.
# JOINED: several of its sources may be compiled as one (hapton_join_sources); this also applies with UNHURRIED. Not for a layer of the hot path:
# every build compiles those in the same way.
function(hapton_library name)
  cmake_parse_arguments(ARG "UNHURRIED;JOINED" "" "LINKS;SOURCES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$")
  list(APPEND sources ${ARG_SOURCES})
  # Sources that read a command line or write a report do so once. Most of their compile time is spent on CLI11 and JSON. So they are compiled at -O1.
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

# hapton_program(NAME LINKS ...): the program in main.cpp of this folder.
function(hapton_program name)
  cmake_parse_arguments(ARG "" "" "LINKS" ${ARGN})
  add_executable(${name} main.cpp)
  target_link_libraries(${name} PRIVATE ${ARG_LINKS})
endfunction()
